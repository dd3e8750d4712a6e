#!/usr/bin/env python3
"""Batches: test_batch.py HPRAD SANITIZER [KILLS]. What is made, what a killed batch leaves and what it does when it goes on, two at
once, shards, failures, errors in the batch file."""
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
import exr  # noqa: E402
from cli_support import PATIENCE_S, Command, problems, write_scene  # noqa: E402
from tap import check, done  # noqa: E402

JOBS = {
    "folder": "out",
    "pictures": "{scene}/{setting}_{camera}.exr",
    "scenes": ["one.gltf", {"name": "two", "file": "swarm2.gltf", "environment": [.1, .2, .3]},
               {"file": "swarm3.gltf", "max_reflectance": .9}],
    "settings": [{"name": "coarse", "order": 0, "subdivide": 1}, {"name": "fine", "order": 2, "subdivide": 1}],
    "cameras": [{"size": [48, 40], "samples": 2, "png": True, "aov": ["irradiance", "N"]}],
}

# what is wrong: (changes of JOBS as text, texts that the message must hold)
BAD_FILES = {
    "no JSON": ('{"scenes": ["one.gltf"],\n "settings": [}', ["bad.json:2", "JSON"]),
    "no scenes": ('{"folder": "out"}', ["bad.json:1", "scenes", "array"]),
    "an unknown key": ('{"scenes":\n ["one.gltf"],\n "colour": 3}', ["bad.json:3", "colour", "unknown key"]),
    "an unknown key within": ('{"scenes": ["one.gltf"], "settings": [{"name": "a"},\n{"name": "b",\n"ordre": 3}]}',
                              ["bad.json:3", "settings[1].ordre", "unknown key"]),
    "a wrong kind": ('{"scenes": ["one.gltf"], "settings": [{"name": "a",\n\n "order": "two"}]}',
                     ["bad.json:3", "settings[0].order", "whole number from 0 to 16", '"two"']),
    "out of range": ('{"scenes": ["one.gltf"], "settings": [{"name": "a", "order": 17}]}',
                     ["bad.json:1", "settings[0].order", "17"]),
    "no word of it": ('{"scenes": ["one.gltf"], "settings": [{"name": "a", "solver": "jacobi"}]}',
                      ["settings[0].solver", "gauss-seidel"]),
    "a tolerance of nothing": ('{"scenes": ["one.gltf"], "settings": [{"name": "a",\n "tol": 0}]}',
                               ["bad.json:2", "settings[0].tol", "above 0"]),
    "a refinement without tolerance": ('{"scenes": ["one.gltf"], "settings": [{"name": "a",\n "refine": "h"}]}',
                                       ["bad.json:2", "settings[0]", "refine", "tol"]),
    "a limit without tolerance": ('{"scenes": ["one.gltf"], "settings": [{"name": "a", "max_time": 9}]}',
                                  ["settings[0]", "max_time", "tol"]),
    "a setting without name": ('{"scenes": ["one.gltf"], "settings": [{"order": 1}]}', ["settings[0]", "no name"]),
    "a scene without file": ('{"scenes": [{"name": "a"}]}', ["scenes[0]", "file"]),
    "a name that is a path": ('{"scenes": [{"name": "a/b", "file": "one.gltf"}]}', ["scenes[0].name", '"a/b"']),
    "a key twice": ('{"scenes": ["one.gltf"],\n"folder": "a",\n"folder": "b"}', ["bad.json:3", "folder", "once"]),
    "a size of one number": ('{"scenes": ["one.gltf"], "cameras": [{"size": [3]}]}', ["cameras[0].size", "[3]"]),
    "an unknown layer": ('{"scenes": ["one.gltf"], "cameras": [{"aov": ["N", "depth"]}]}', ["cameras[0].aov", "patchId"]),
    "a flag": ('{"scenes": ["one.gltf"], "cameras": [{"png": 1}]}', ["cameras[0].png", "true or false"]),
    "a centre": ('{"scenes": ["one.gltf"], "cameras": [{"orbit": 3, "orbit_centre": [1, 2]}]}', ["cameras[0].orbit_centre"]),
    "an exposure of nothing": ('{"scenes": ["one.gltf"], "cameras": [{"exposure": 2}]}', ["cameras[0]", "png"]),
    "radiances": ('{"scenes": [{"file": "one.gltf", "environment": [1, -1, 1]}]}', ["scenes[0].environment"]),
}
BAD_USE = {
    "one name for several cameras": ({"pictures": "{scene}{setting}.exr"}, ["3 cameras", "{camera}"]),
    "one name for two settings": ({"pictures": "{scene}{camera}.exr"}, ["two outputs", "out/onea.exr"]),
    "an unknown placeholder": ({"pictures": "{lamp}.exr"}, ["{lamp}"]),
    "a camera that is not there": ({"cameras": [{"camera": "roof"}]}, ["'roof'", "a, b, c"]),
}


def write_jobs(folder, name="jobs.json", **changes):
    with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
        json.dump({**JOBS, **changes}, file, indent=1)


def contents(folder):
    """{name: hash} of all files below, but the manifest."""
    found = {}
    for place, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(place, name)
            with open(path, "rb") as file:
                found[os.path.relpath(path, folder)] = hashlib.sha256(file.read()).hexdigest()
    found.pop("manifest.jsonl", None)
    return found


def manifest(folder):
    with open(os.path.join(folder, "manifest.jsonl"), encoding="utf-8") as file:
        lines = file.read().split("\n")
    found = []
    for line in lines:
        try:
            found.append(json.loads(line))
        except ValueError:
            pass  # cut off by a kill, or the empty end
    return found


def differences(folder, expected):
    found = contents(folder)
    for name in sorted(set(found) | set(expected)):
        if found.get(name) != expected.get(name):
            yield f"{name}: {'differs' if name in found and name in expected else 'is there' if name in found else 'missing'}"


def manifest_problems(folder):
    told, found = manifest(folder), contents(folder)
    names = [line["output"] for line in told]
    yield from (f"{name} was made {names.count(name)} times" for name in sorted(set(names)) if names.count(name) > 1)
    yield from (f"{name} is not in the manifest" for name in sorted(set(found) - set(names)))
    yield from (f"{line['output']}: its hash is another" for line in told if found.get(line["output"]) != line["sha256"])


def check_whole(command, out):
    """Returns what an undisturbed batch makes."""
    result = command("batch", "jobs.json", "--dry-run")
    check("a dry run makes nothing", [*problems(result, 0), *(["it made out"] if os.path.exists(out) else [])])
    planned = [line.split()[-1] for line in result.stdout.splitlines() if line.startswith("to make")]
    result = command("batch", "jobs.json", "--jobs", "2")
    check("a batch", problems(result, 0))
    check("it sums up", "6 solved" in result.stdout and "18 made" in result.stdout and "0 failed" in result.stdout)
    whole = contents(out)
    check("a dry run said what it makes", sorted(planned) == sorted("out/" + name for name in whole))
    check("18 pictures, their previews and 6 solutions", len(whole) == 42)
    check("the manifest tells of each with its hash, once", manifest_problems(out))
    picture = exr.read(os.path.join(out, "two/fine_b.exr"))
    check("a picture is as asked for", (picture.width, picture.height) == (48, 40) and "irradiance.R" in picture.channels)
    command("solve", "swarm2.gltf", "--order", "2", "--subdivide", "1", "--environment", ".1,.2,.3", "-o", "two.glb")
    command("render", "two.glb", "--camera", "b", "--size", "48x40", "--samples", "2", "--aov", "irradiance,N", "-o", "two.exr")
    with open(os.path.join(command.folder, "two.exr"), "rb") as file:
        check("it is what solve and render make", hashlib.sha256(file.read()).hexdigest() == whole["two/fine_b.exr"])
    result = command("batch", "jobs.json")
    check("again: nothing is made", [*problems(result, 0), *(["made"] if "18 reused" not in result.stdout else [])])
    os.remove(os.path.join(out, "two/fine_b.exr"))
    with open(os.path.join(out, "one/coarse_a.png"), "ab") as file:
        file.write(b"x")
    result = command("batch", "jobs.json")
    check("what was removed or changed is made again, and no more",
          [*differences(out, whole), *([] if "2 made, 16 reused" in result.stdout else [result.stdout])])
    return whole


def check_kills(command, out, whole, kills):
    """Killed at random moments of the time that the batch takes, resumed until it comes to its end."""
    shutil.rmtree(out)
    start = time.monotonic()
    command("batch", "jobs.json", "--jobs", "2")
    duration = time.monotonic() - start
    shutil.rmtree(out)
    moments = random.Random(1)
    ended = 0
    for _ in range(kills):
        process = command.start("batch", "jobs.json", "--jobs", "2")
        try:
            process.communicate(timeout=moments.uniform(0, duration / 2))
            ended += 1
            shutil.rmtree(out)  # it came to its end: once more from the beginning
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.communicate()
    result = command("batch", "jobs.json", "--jobs", "2")
    check(f"killed {kills - ended} times, it comes to its end", problems(result, 0))
    check("killed: everything is there and the same, and no temporary file", differences(out, whole))
    check("killed: nothing that was finished was made again", manifest_problems(out))
    with open(os.path.join(out, "manifest.jsonl"), "r+b") as file:  # a line that was cut off
        file.truncate(os.path.getsize(file.name) - 30)
    cut = len(manifest(out))
    result = command("batch", "jobs.json")
    check("a line that was cut off: its file is made again", [*problems(result, 0), *differences(out, whole)]
          + ([] if len(manifest(out)) == cut + 1 or len(manifest(out)) == cut + 2 else ["other lines too"]))


def check_together(command, out, whole):
    shutil.rmtree(out)
    both = [command.start("batch", "jobs.json", "--jobs", "2") for _ in range(2)]
    said = [process.communicate(timeout=PATIENCE_S) for process in both]
    check("two batches in one folder both come to their end", [str(text) for process, text in zip(both, said) if process.returncode])
    check("two batches: everything is there once", [*differences(out, whole), *manifest_problems(out)])
    shutil.rmtree(out)
    made = []
    for i in (1, 2, 3, 4):
        before = set(contents(out)) if i > 1 else set()
        check(f"shard {i}/4", problems(command("batch", "jobs.json", "--shard", f"{i}/4"), 0))
        made.append({name for name in set(contents(out)) - before if name.endswith(".exr")})
    check("shards share the work", all(made) and sum(map(len, made)) == 18)
    check("shards make all of it", differences(out, whole))


def check_failures(command, out, whole):
    shutil.rmtree(out)
    write_jobs(command.folder, "partly.json", scenes=["missing.gltf", *JOBS["scenes"], "broken.gltf"])
    result = command("batch", "partly.json", "--jobs", "2")
    check("failed jobs: exit code 1, each is named", problems(result, 1, ["missing.gltf", "No such file", "broken.gltf", "left out"]))
    check("failed jobs: counted", "4 failed" in result.stdout and "4 left out" in result.stdout)
    check("failed jobs: all others are done", differences(out, whole))
    shutil.rmtree(out)
    write_jobs(command.folder, "long.json", scenes=["long.gltf"], settings=[{"name": "x", "order": 5, "subdivide": 0}])
    code, text = interrupted(command)
    check("SIGINT: exit code 130, said so", [] if code == 130 and "SIGINT" in text else [f"{code} {text}"])
    check("SIGINT: nothing is left", list(contents(out)))


def check_tolerances(command, out):
    """Two settings that reach their tolerance, and two that are not given the time or the memory for a second step."""
    shutil.rmtree(out)
    tight = {"tol": 1e-6, "order": 2}
    settings = [{"name": "easy", "tol": .5}, {"name": "h", "tol": .5, "refine": "h", "max_time": 1000, "max_memory": 1e10},
                {"name": "hasty", "max_time": 1e-9, **tight}, {"name": "lean", "max_memory": 1, **tight}]
    write_jobs(command.folder, "tol.json", scenes=["swarm2.gltf"], settings=settings)
    for again in (False, True):
        result = command("batch", "tol.json")
        check(f"missed tolerances: exit code 4{', also when nothing is made' if again else ''}",
              [*problems(result, 4, () if again else ["swarm2.gltf", "tolerance 1e-06", "--max-time"]), *([] if "0 failed, 2 missed" in result.stdout else [result.stdout])])
    told = manifest(out)
    check("missed tolerances: the manifest says which solutions, once",
          sorted(line["missed"] for line in told if line["output"].endswith(".glb")) == [False, False, True, True])
    check("missed tolerances: the pictures are made all the same", sum(line["output"].endswith(".exr") for line in told) == 12)


def check_memory(command, out, whole):
    shutil.rmtree(out)
    result = command("batch", "jobs.json", "--memory", "0.001")
    check("too little memory: said so", result.returncode == 1 and "6 failed" in result.stdout)
    check("too little memory: nothing is left", list(contents(out)))
    # A share of 1 MB is too little, 1 GB is plenty.
    result = command("batch", "jobs.json", "--memory", "1", "--jobs", "1000")
    check("too little for its share: a job runs again alone", [*problems(result, 0), *differences(out, whole)])


def interrupted(command):
    process = command.start("batch", "long.json")
    time.sleep(1)
    process.send_signal(signal.SIGINT)
    return process.wait(PATIENCE_S), process.communicate()[1].decode()


def check_errors(command):
    before = command.listing()
    for what, (text, texts) in BAD_FILES.items():
        with open(os.path.join(command.folder, "bad.json"), "w", encoding="utf-8") as file:
            file.write(text)
        check(f"refused: {what}", problems(command("batch", "bad.json"), 3, texts, ""))
    for what, (changes, texts) in BAD_USE.items():
        write_jobs(command.folder, "bad.json", **changes)
        check(f"refused: {what}", problems(command("batch", "bad.json"), 2, texts, ""))
    os.remove(os.path.join(command.folder, "bad.json"))
    check("refused: no such file", problems(command("batch", "no.json"), 3, ["no.json", "No such file"], ""))
    for option, values in {"--jobs": ["0", "x"], "--memory": ["0", "-1"], "--shard": ["0/2", "3/2", "1", "1/2/3"]}.items():
        for value in values:
            check(f"refused: {option} {value}", problems(command("batch", "jobs.json", option, value), 2, [f"{option} '{value}'"], ""))
    check("what is refused leaves nothing", command.listing() == before)


def main():
    kills = int(sys.argv[3]) if len(sys.argv) > 3 else 20
    with tempfile.TemporaryDirectory() as folder:
        command, out = Command(sys.argv[1], folder), os.path.join(folder, "out")
        cameras = ("a", "b", "c")
        write_scene(os.path.join(folder, "one.gltf"), cameras=cameras)
        for plates in (2, 3):
            write_scene(os.path.join(folder, f"swarm{plates}.gltf"), cameras=cameras, plates=plates)
        write_scene(os.path.join(folder, "long.gltf"), cameras=("a", "b"), plates=160)
        with open(os.path.join(folder, "broken.gltf"), "w", encoding="utf-8") as file:
            file.write("{}")
        write_jobs(folder)
        check_errors(command)
        whole = check_whole(command, out)
        check_kills(command, out, whole, kills)
        check_together(command, out, whole)
        check_failures(command, out, whole)
        check_tolerances(command, out)
        if sys.argv[2] == "none":  # sanitizers leave no limit to memory
            check_memory(command, out, whole)
    return done()


sys.exit(main())
