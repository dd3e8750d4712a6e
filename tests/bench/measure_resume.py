#!/usr/bin/env python3
"""Kills solves with a tolerance at random moments and takes them up again: CPU seconds against those that were left.

    measure_resume.py HPRAD SCENE.gltf [--tol 1e-2] [--kills 10] [--seed 1]

A solve is killed with signal 9 between its beginning and its end, evenly by CPU time; what was left is the time of an
undisturbed solve (the mean of two, one before and one after) less what the killed one had used. One thread. Exit code 1
if a resumed solve gives other bits."""
import argparse
import hashlib
import os
import random
import signal
import subprocess
import sys
import tempfile
import time


def cpu_seconds(pid):
    """Of a running process; None: it has ended."""
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii") as file:
            field = file.read().rsplit(")", 1)[1].split()
    except OSError:
        return None
    return None if field[0] == "Z" else (int(field[11]) + int(field[12])) / os.sysconf("SC_CLK_TCK")


def run(command, kill_at=None):
    """CPU seconds used, and whether it was killed."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    while kill_at is not None:
        used = cpu_seconds(process.pid)
        if used is None:
            break
        if used >= kill_at:
            process.send_signal(signal.SIGKILL)
            break
        time.sleep(.002)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 4, -signal.SIGKILL):
        sys.exit(f"{' '.join(command)}: {process.returncode}")
    return usage.ru_utime + usage.ru_stime, process.returncode == -signal.SIGKILL


def digest(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def measure(a, folder):
    def path(name):
        return os.path.join(folder, name)

    solve = [a.command, "solve", a.scene, "--tol", a.tol, "--threads", "1", "--quiet"]
    whole, _ = run([*solve, "-o", path("whole.glb")])
    killed = [*solve, "-o", path("k.glb"), "--checkpoint", path("k.json")]
    moments = random.Random(a.seed)
    rows, wrong = [], 0
    while len(rows) < a.kills:
        for name in ("k.json", "k.json.blocks", "k.glb"):
            if os.path.exists(path(name)):
                os.remove(path(name))
        used, was_killed = run(killed, moments.uniform(0, whole))
        if not was_killed:
            continue
        again, _ = run([*killed, *(["--resume", path("k.json")] if os.path.exists(path("k.json")) else [])])
        wrong += digest(path("k.glb")) != digest(path("whole.glb"))
        rows.append((used, again))
    size = os.path.getsize(path("k.json.blocks")) if os.path.exists(path("k.json.blocks")) else 0
    whole = (whole + run([*solve, "-o", path("whole.glb")])[0]) / 2
    return whole, rows, wrong, size


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("scene")
    parser.add_argument("--tol", default="1e-2")
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        whole, rows, wrong, size = measure(a, folder)
    print(f"undisturbed {whole:.2f} CPU s, blocks {size / 1e6:.1f} MB\n")
    print("| killed after s | left s | resumed s | resumed / left |\n| --- | --- | --- | --- |")
    for used, again in sorted(rows):
        print(f"| {used:.2f} | {whole - used:.2f} | {again:.2f} | {again / (whole - used):.2f} |")
    left = sum(whole - used for used, _ in rows)
    print(f"\nall: {sum(again for _, again in rows) / left:.2f}; {wrong} of {len(rows)} gave other bits")
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main())
