"""What the tests of the command share: run it, a small scene, a long solve, a terminal, a small disk."""
import base64
import contextlib
import json
import math
import os
import pty
import select
import shutil
import signal
import struct
import subprocess
import time

# Far above what any run that is waited for takes; ./dev asan and tsan ask for more.
PATIENCE_S = 60 * int(os.environ.get("HPR_TEST_PATIENCE", "1"))


class Command:
    """The hprad executable, run in a folder of its own."""

    def __init__(self, path, folder):
        self.path = os.path.abspath(path)
        self.folder = folder

    def __call__(self, *arguments, stdout=subprocess.PIPE, folder=None):
        line = [self.path, *arguments]
        try:
            return subprocess.run(line, cwd=folder or self.folder, check=False, stdin=subprocess.DEVNULL,
                                  stdout=stdout, stderr=subprocess.PIPE, universal_newlines=True,
                                  timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            return subprocess.CompletedProcess(line, f"none, killed after {PATIENCE_S} s", "", "")

    def start(self, *arguments, stderr=subprocess.PIPE):
        return subprocess.Popen([self.path, *arguments], cwd=self.folder, stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=stderr)

    def listing(self, folder="."):
        return sorted(os.listdir(os.path.join(self.folder, folder)))


def problems(result, code, stderr=(), stdout=None):
    """What differs from: exit code `code`, each text of `stderr` in one line of it, no output if stdout is ''."""
    told = f"exit code {result.returncode}, stdout {result.stdout!r}, stderr {result.stderr!r}"
    if result.returncode != code:
        yield f"expected exit code {code}: {told}"
    for text in stderr:
        if text not in result.stderr:
            yield f"stderr lacks {text!r}: {told}"
    if not stderr and result.stderr:
        yield f"nothing was to be said on stderr: {told}"
    if stderr and not result.stderr.startswith("hprad: "):
        yield f"stderr does not begin with 'hprad: ': {told}"
    if stdout is not None and result.stdout != stdout:
        yield f"expected stdout {stdout!r}: {told}"


def write_scene(path, cameras=("camera",), plates=1, **extra):
    """A floor of 1 x 1, `plates` lamps of 0.5 x 0.5 above it and cameras (None: without name) that look down. More
    than one lamp: a swarm of tilted ones, lit on both sides, each in the way of all others."""
    corners = [(-.5, 0, .5), (.5, 0, .5), (.5, 0, -.5), (-.5, 0, -.5)]
    data = struct.pack("<12f", *(x for corner in corners for x in corner)) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    nodes = [{"mesh": 0}]
    for i in range(plates):
        c, s = math.cos(1 + 2.4 * i), math.sin(1 + 2.4 * i)  # the golden angle: they cross each other
        tilted = [.5 * c, .5 * s, 0, 0, 0, 0, .5, 0, .5 * s, -.5 * c, 0, 0, s, 1 + .05 * (i % 20), c, 1]
        facing_down = [.5, 0, 0, 0, 0, -.5, 0, 0, 0, 0, -.5, 0, 0, .5, 0, 1]
        nodes.append({"mesh": 1, "matrix": tilted if plates > 1 else facing_down})
    for name in cameras:
        node = {"camera": 0, "matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 2, 0, 1]}
        nodes.append(dict(node, name=name) if name is not None else node)
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": [{"primitives": [dict(primitive, material=m)]} for m in (0, 1)],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorFactor": [.8, .5, .2, 1], "metallicFactor": 0}},
            {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
             "emissiveFactor": [1, 1, .5], "doubleSided": plates > 1}],
        "buffers": [{"byteLength": len(data),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                       "min": [-.5, 0, -.5], "max": [.5, 0, .5]},
                      {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        **extra}
    if cameras:
        scene["cameras"] = [{"type": "perspective", "perspective": {"yfov": .8, "znear": .01, "aspectRatio": 1}}]
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)


# In write_scene(..., plates=160) more work than two cores do in a minute.
LONG_SOLVE = ("--order", "5", "--subdivide", "0")


def interrupt(command, number, arguments, begun):
    """Runs on a terminal until the progress bar shows the stage `begun`, sends the signal; (exit code, stderr)."""
    terminal, stderr = pty.openpty()
    process = command.start(*arguments, stderr=stderr)
    os.close(stderr)
    text, sent, end = b"", False, time.monotonic() + PATIENCE_S
    try:
        while time.monotonic() < end:
            if not select.select([terminal], [], [], 1)[0]:
                continue
            try:
                piece = os.read(terminal, 4096)
            except OSError:  # the other end is closed
                break
            text += piece
            if not piece:
                break
            if begun.encode() in text and not sent:
                process.send_signal(number)
                sent = True
        else:
            text += b" (did not end)"
            process.kill()
        process.stdout.read()
        return process.wait(), text.decode(errors="replace")
    finally:
        process.stdout.close()
        os.close(terminal)


@contextlib.contextmanager
def small_disk(folder, kilobytes):
    """A folder with little room, or None where mounting is not allowed."""
    place = os.path.join(folder, "small")
    os.makedirs(place)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={kilobytes}k", "tmpfs", place]
    mounted = shutil.which("mount") and subprocess.run(mount, stderr=subprocess.DEVNULL, check=False).returncode == 0
    try:
        yield place if mounted else None
    finally:
        if mounted:
            subprocess.run(["umount", place], check=True)
        os.rmdir(place)


SIGNALS = {"SIGINT": (signal.SIGINT, 130), "SIGTERM": (signal.SIGTERM, 143)}
