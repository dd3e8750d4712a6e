#!/usr/bin/env python3
"""A solve with a tolerance that is killed and taken up again: test_checkpoint.py HPRAD SCENES [KILLS]. The same bits as
if it had not been, and what is refused."""
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cli_support import Command, problems, write_scene  # noqa: E402
from tap import check, done  # noqa: E402

BOX = ("cornell_box.gltf", "--order", "2", "--tol", "3e-2")
SOLVE = ("solve", *BOX, "--quiet")


def digest(command, name):
    with open(os.path.join(command.folder, name), "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def report(command, name):
    with open(os.path.join(command.folder, name), encoding="utf-8") as file:
        return json.load(file)


def remove(command, *names):
    for name in names:
        if name in command.listing():
            os.remove(os.path.join(command.folder, name))


def check_whole(command):
    """What an undisturbed solve gives, and its seconds."""
    start = time.monotonic()
    result = command(*SOLVE, "-o", "whole.glb", "--report", "whole.json")
    duration = time.monotonic() - start
    check("an undisturbed solve", problems(result, 0))
    whole = digest(command, "whole.glb")
    told = report(command, "whole.json")
    check("it takes several steps, past obstacles", told["counts"]["steps"] >= 3 and told["counters"]["clips"] > 0)
    result = command(*SOLVE, "-o", "kept.glb", "--checkpoint", "end.json")
    check("a checkpoint changes nothing", [*problems(result, 0), *([] if digest(command, "kept.glb") == whole else ["other bits"])])
    return whole, told, duration


def check_every_step(command, whole, told):
    """From each of the steps: the blocks that an undisturbed solve takes over from the steps before are made anew."""
    kept = report(command, "end.json")
    for step in range(1, told["counts"]["steps"]):
        cut = {**kept, "refinements": [r for r in kept["refinements"] if r[0] < step]}
        with open(os.path.join(command.folder, "cut.json"), "w", encoding="utf-8") as file:
            json.dump(cut, file)
        remove(command, "cut.json.blocks")
        result = command(*SOLVE, "--threads", str(step), "-o", "cut.glb", "--resume", "cut.json", "--checkpoint", "cut.json",
                         "--report", "r.json")
        now = report(command, "r.json")
        check(f"resumed at step {step}: the same bits", [*problems(result, 0), *([] if digest(command, "cut.glb") == whole else [
            "other bits"])])
        check(f"resumed at step {step}: the same estimate and number of steps",
              all(now[key] == told[key] for key in ("error_estimate", "error_parts", "counts", "quadrature")))
        check(f"resumed at step {step}: the checkpoint is that of the whole", report(command, "cut.json") == kept)


def steps_of(command, name):
    """Refinements that a checkpoint holds."""
    return len(report(command, name)["refinements"]) if name in command.listing() else 0


def check_blocks(command, whole):
    """Blocks are read, not integrated again; whatever is broken of them is made anew."""
    made = None
    path = os.path.join(command.folder, "end.json.blocks")
    with open(path, "rb") as file:
        kept = file.read()
    for what, data, least, most in (("none", None, 1, 1), ("all", kept, 0, 0), ("a part", kept[:len(kept) * 3 // 4 + 5], 1, .9),
                                    ("one bit wrong", kept[:len(kept) // 2] + bytes([kept[len(kept) // 2] ^ 1]) +
                                     kept[len(kept) // 2 + 1:], 1, .9),
                                    ("of something else", b"x" * 200, 1, 1)):
        remove(command, "end.json.blocks")
        if data is not None:
            with open(path, "wb") as file:
                file.write(data)
        result = command(*SOLVE, "-o", "b.glb", "--resume", "end.json", "--report", "b.json")
        now = report(command, "b.json")["counters"]
        good = digest(command, "b.glb") == whole
        check(f"blocks kept: {what}: the same bits", [*problems(result, 0, ["integrated again"] if what == "of something else" else []), *([] if good else ["other bits"])])
        made = made or now
        share = now["pairs_partial"] / made["pairs_partial"]
        check(f"blocks kept: {what}: {share:.2f} of those past obstacles integrated", (share > 0) == (least > 0) and share <= most)
    with open(path, "wb") as file:
        file.write(kept)


def check_kills(command, whole, duration, kills):
    """At random moments; every other time not before there is a checkpoint."""
    moments = random.Random(1)
    wrong, killed, resumed = [], 0, 0
    for i in range(kills):
        remove(command, "k.json", "k.json.blocks", "k.glb")
        process = command.start(*SOLVE, "-o", "k.glb", "--checkpoint", "k.json")
        while i % 2 and process.poll() is None and not steps_of(command, "k.json"):
            time.sleep(.01)
        try:
            process.communicate(timeout=moments.uniform(0, duration / (1 + i % 2)))
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.communicate()
            killed += 1
        there = "k.json" in command.listing()
        resumed += there
        result = command(*SOLVE, "-o", "k.glb", "--checkpoint", "k.json", *(("--resume", "k.json") if there else ()))
        wrong += problems(result, 0)
        wrong += [] if digest(command, "k.glb") == whole else ["other bits"]
    check("killed at random moments and taken up again: the same bits", wrong)
    check("some could be taken up", resumed >= kills // 2)
    print(f"# killed {killed} times, taken up {resumed} times")


def check_refusals(command):
    write_scene(os.path.join(command.folder, "other.gltf"), plates=3)
    with open(os.path.join(command.folder, "broken.json"), "w", encoding="utf-8") as file:
        json.dump({**report(command, "end.json"), "refinements": [[1, 0, 2, 0, 2, 2, 0, 0]]}, file)
    with open(os.path.join(command.folder, "far.json"), "w", encoding="utf-8") as file:
        json.dump({**report(command, "end.json"), "refinements": [[1, 10 ** 6, 1, 0, 2, 2, 0, 0]]}, file)
    before = command.listing()
    for what, arguments, code, texts in (
            ("another tolerance", (*BOX, "--tol", "0.25"), 3, ["'end.json'", "tol was 0.0", "now it is 0.25"]),
            ("another way to refine", (*BOX, "--refine", "h"), 3, ["refine was hp, now it is h"]),
            ("light from outside", (*BOX, "--environment", "1"), 3, ["environment[0]", "not there"]),
            ("another scene", ("other.gltf", *BOX[1:]), 3, ["scene was"]),
            ("no tolerance", BOX[:1], 2, ["--resume", "--tol"])):
        result = command("solve", *arguments, "--resume", "end.json", "-o", "x.glb")
        check(f"refused: {what}", problems(result, code, texts, ""))
    for name, code, texts in (("missing.json", 3, ["missing.json", "No such file"]), ("cornell_box.gltf", 3, ["no checkpoint"]),
                              ("broken.json", 3, ["refinement 0 is broken"]), ("far.json", 2, ["element 1000000", "step 1"])):
        check(f"refused: {name}", problems(command(*SOLVE, "--resume", name, "-o", "x.glb"), code, texts, ""))
    result = command(*SOLVE, "--resume", "end.json", "-o", "end.json")
    check("refused: a solution over the checkpoint that is read", problems(result, 2, ["'end.json'"], ""))
    check("refused: a checkpoint without tolerance",
          problems(command("solve", BOX[0], "--checkpoint", "x.json"), 2, ["--checkpoint", "--tol"], ""))
    check("refused: a folder that is not there", problems(command(*SOLVE, "--checkpoint", "no/x.json"), 1, ["'no/x.json'"], ""))
    check("what is refused writes nothing", command.listing() == before)


def main():
    kills = int(sys.argv[3]) if len(sys.argv) > 3 else 5
    with tempfile.TemporaryDirectory() as folder:
        command = Command(sys.argv[1], folder)
        for name in ("cornell_box.gltf", "cornell_box.bin"):
            shutil.copy(os.path.join(sys.argv[2], name), folder)
        whole, told, duration = check_whole(command)
        check_every_step(command, whole, told)
        check_blocks(command, whole)
        check_refusals(command)
        check_kills(command, whole, duration, kills)
    return done()


sys.exit(main())
