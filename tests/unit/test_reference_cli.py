#!/usr/bin/env python3
"""hprad reference from outside: test_reference_cli.py HPRAD SCENES. Options, files, report, exit codes, and the z-test
of what `hprad render` shows (tests/support/z_test.py), itself tested first."""
import csv
import json
import math
import os
import random
import subprocess
import sys
import tempfile
from array import array

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import exr  # noqa: E402
import z_test  # noqa: E402
from cli_support import Command, SIGNALS, interrupt, problems, write_scene  # noqa: E402
from tap import check, done  # noqa: E402

SMALL = ("--size", "16x12", "--samples", "4", "--quiet")

BAD_VALUES = {
    "--samples": ["0", "1", "-4", "4.5", "16777217", ""],
    "--seed": ["-1", "x", "1.5", "", "99999999999999999999"],
    "--environment": ["", "x", "-1", "1,2,", ",1,2", "1,,2", "nan", "inf", "1,-1,1", "0x1", "1 ", "1;2;3"],
    "--size": ["640", "0x480", ""],
    "--exposure": ["0", "inf"],
    "--max-reflectance": ["0", "1.01", "nan"],
    "--metallic": ["grey"],
    "--scene-index": ["-1"],
    "--threads": ["0"],
}

WRONG_USAGE = [
    ((), ["no input", "one scene"]),
    (("one.gltf", "two.gltf"), ["'two.gltf'", "too many"]),
    (("one.gltf", "--order", "3"), ["--order", "unknown option"]),
    (("one.gltf", "--exposure", "2"), ["--exposure", "--png"]),
    (("one.gltf", "--report", ""), ["--report"]),
    (("one.gltf", "-o", ""), ["empty"]),
    (("one.gltf", "-o", "one.gltf"), ["'one.gltf'", "input"]),
    (("one.gltf", "-o", "{frames}.exr"), ["{frames}", "{camera}"]),
    (("one.gltf", "-o", "x", "--report", "x"), ["'x'", "two outputs"]),
    (("two.gltf", "-o", "x.exr"), ["'x.exr'", "2 cameras", "--camera"]),
    (("two.gltf", "--camera", "roof"), ["'roof'", "a_b", "camera0"]),
]


def path_of(command, *parts):
    return os.path.join(command.folder, *parts)


def noisy(side, mean, error, seed):
    """A picture as path tracing gives it: Gaussian pixels of this standard error, the layer true."""
    numbers = random.Random(seed)
    channels = {name: array("f", (numbers.gauss(mean, error) for _ in range(side * side))) for name in "RGB"}
    channels.update({"variance." + name: array("f", [error * error]) * (side * side) for name in "RGB"})
    return exr.Picture(side, side, channels, {})


def even(side, mean, at=None, step=0):
    """The same picture without noise; the pixels of block (0, 0) off by `step` if `at` is a channel's name."""
    channels = {name: array("f", [mean]) * (side * side) for name in "RGB"}
    for y in range(z_test.BLOCK if at else 0):
        for x in range(z_test.BLOCK):
            channels[at][y * side + x] += step
    return exr.Picture(side, side, channels, {})


def check_z_test():
    """48 blocks: limit 4.26. A block's standard error is 0.16 / 16 = 1% of the mean."""
    reference = noisy(64, 1, .16, 1)
    verdict = z_test.compare(reference, even(64, 1), .011)
    check("z-test: equal means agree", verdict.problems)
    check("z-test: the limit is Bonferroni's", verdict.blocks == 48 and abs(math.erfc(verdict.limit / math.sqrt(2)) * 48 / 1e-3 - 1) < 1e-9)
    check("z-test: the stated error is the spread of the blocks", abs(verdict.error[0] / .01 - 1) < .01)
    check("z-test: one block in one channel off by 8 errors is seen",
          len(z_test.compare(reference, even(64, 1, "G", .08), .011).problems) == 1)
    check("z-test: 8 errors everywhere are seen", len(z_test.compare(reference, even(64, 1.08), .011).problems) > 40)
    check("z-test: a reference noisier than agreed is refused",
          len(z_test.compare(reference, even(64, 1), .009).problems) == 3)
    flat = noisy(20, 1, 0, 1)
    check("z-test: without noise, equality", z_test.compare(flat, even(20, 1), .01).problems)
    check("z-test: nor does rounding count where there is hardly any noise",
          z_test.compare(noisy(20, 1, 1e-11, 1), even(20, 1 + 2 ** -24), .01).problems)
    check("z-test: without noise, nothing else", bool(z_test.compare(flat, even(20, 1 + 1e-5), .01).problems))
    alarms = sum(bool(z_test.compare(noisy(32, 1, .1, seed), even(32, 1), .01, .1).problems) for seed in range(100))
    check("z-test: false alarms are as rare as asked", 2 <= alarms <= 20)  # 10 +- 3 of 100


def check_z_test_command(command):
    """As a user runs it, on what check_agreement left: the plates agree with themselves and not with another scene."""
    def run(reference, picture, *options):
        line = [sys.executable, z_test.__file__, reference, picture, "--error", "0.01", *options]
        return subprocess.run(line, cwd=command.folder, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True)

    agrees = run("parallel_plates_r.exr", "parallel_plates_g.exr", "--table", "blocks.csv")
    check("z_test.py exits 0 where pictures agree", agrees.returncode == 0 and "27 blocks" in agrees.stdout)
    with open(path_of(command, "blocks.csv"), encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    mean = sum(float(row["reference_w_m2_sr"]) for row in rows if row["channel"] == "R") / 9
    picture = exr.read(path_of(command, "parallel_plates_r.exr"))
    check("its table has every block", len(rows) == 27 and abs(mean * 48 * 48 / sum(picture.channels["R"]) - 1) < 1e-6)
    differs = run("parallel_plates_r.exr", "cube_mixed_g.exr")
    check("z_test.py exits 1 where they do not", differs.returncode == 1 and "limit" in differs.stderr)


def check_agreement(command, scenes):
    """Galerkin solutions whose own error is below 1e-4, rendered with 1024 rays per pixel (their fixed places err by
    1/1024 of a pixel along straight edges), against paths enough for a block's standard error of half a percent. All
    blocks of a scene together are held to three standard deviations (Bonferroni)."""
    three_sigma = math.erfc(3 / math.sqrt(2))
    for scene, paths in (("cube_mixed", "64"), ("parallel_plates", "256"), ("blocked_plates", "1024")):
        scene = os.path.join(scenes, scene + ".gltf")
        name = os.path.basename(scene)[:-len(".gltf")]
        solved, traced = f"{name}_g.exr", path_of(command, f"{name}_r.exr")
        command(scene, "--order", "3", "--subdivide", "2", "--size", "48x48", "--samples", "1024", "--quiet", "-o", solved)
        command("reference", scene, "--size", "48x48", "--samples", paths, "--quiet", "-o", traced)
        picture = exr.read(path_of(command, solved))
        verdict = z_test.compare(traced, picture, .005, three_sigma)
        print(f"# {name}: |z| <= {abs(verdict.worst.z):.2f} of {verdict.blocks} blocks, limit {verdict.limit:.2f}; "
              f"standard error of a block {max(verdict.error):.3%}, bound 0.5%; picture / reference "
              f"{verdict.mean_ratio[0]:.5f}")
        check(f"{name}: the Galerkin solution agrees", verdict.problems)
        for channel in "RGB":
            picture.channels[channel][:] = array("f", (1.03 * x for x in picture.channels[channel]))
        check(f"{name}: 3% off would be seen", bool(z_test.compare(traced, picture, .005, three_sigma).problems))


def check_usage(command):
    before = command.listing()
    for arguments, texts in WRONG_USAGE:
        check(f"wrong usage: hprad reference {' '.join(arguments)}",
              problems(command("reference", *arguments), 2, texts, ""))
    for option, values in BAD_VALUES.items():
        wrong = []
        for value in values:
            png = ("--png",) if option == "--exposure" else ()
            wrong += problems(command("reference", "one.gltf", *png, option, value), 2, [f"{option} '{value}'"], "")
        check(f"{option} refuses {len(values)} bad values, naming each", wrong)
    check("bad input: a missing scene", problems(command("reference", "none.gltf"), 3, ["none.gltf", "No such file"], ""))
    check("bad input: a solution", problems(command("reference", "one.glb"), 3, ["one.glb", "is a solution"], ""))
    check("before the work: a folder that is not there",
          problems(command("reference", "long.gltf", "--samples", "100000", "-o", "no/x.exr"), 1, ["'no/x.exr'", "No such"], ""))
    check("before the work: a report that cannot be written",
          problems(command("reference", "long.gltf", "--samples", "100000", "--report", "no/x"), 1, ["'no/x'", "No such"], ""))
    check("no room: exit code 1",
          problems(command("reference", "one.gltf", *SMALL, "-o", "/dev/full"), 1, ["No space left on device"]))
    check("wrong usage and bad input write nothing", command.listing() == before)


def check_signals(command):
    before = command.listing()
    for signal_name, (number, code) in SIGNALS.items():
        arguments = ("reference", "long.gltf", "-o", "x.exr", "--png", "--report", "x.json", "--samples", "1000000")
        got, text = interrupt(command, number, arguments, "trace")
        wrong = [] if got == code and signal_name in text else [f"exit code {got}, terminal {text!r}"]
        check(f"{signal_name}: exit code {code}, said so", wrong)
        check(f"{signal_name}: nothing is left", [file for file in command.listing() if file not in before])


def check_pictures(command):
    folder = path_of(command, "elsewhere")
    os.mkdir(folder)

    def pictures(fact, arguments, expected):
        for name in os.listdir(folder):
            os.remove(os.path.join(folder, name))
        result = command("reference", *arguments, *SMALL, folder=folder)
        found = sorted(os.listdir(folder))
        check(fact, [*problems(result, 0, (), "")] + ([] if found == sorted(expected) else [f"found {found}"]))

    pictures("the default name", ("../one.gltf",), ["one_reference.exr"])
    pictures("several cameras, default name", ("../two.gltf",), ["two_reference_a_b.exr", "two_reference_camera0.exr"])
    pictures("{camera} and {frame}", ("../two.gltf", "-o", "{camera}{frame:02}.exr"), ["a_b00.exr", "camera001.exr"])
    pictures("one camera by name", ("../two.gltf", "-o", "x.exr", "--camera", "a/b"), ["x.exr"])
    pictures("a scene without camera", ("../blind.gltf", "-o", "{camera}.exr"), ["camera0.exr"])
    pictures("previews and report", ("../one.gltf", "--png", "--exposure", "2", "--report", "r.json", "-o", "x.exr"),
             ["r.json", "x.exr", "x.png"])
    picture = exr.read(os.path.join(folder, "x.exr"))
    check("layers", sorted(picture.channels) == ["A", "B", "G", "R", "variance.B", "variance.G", "variance.R"])
    check("--size is obeyed", (picture.width, picture.height) == (16, 12))
    check("scene and camera are in the file",
          picture.attributes["scene"] == b"one.gltf" and picture.attributes["camera"] == b"camera")
    check_report(os.path.join(folder, "r.json"), picture)


def check_report(path, picture):
    with open(path, encoding="utf-8") as file:
        report = json.load(file)
    check("report: settings", report["settings"] == {"samples": 4, "seed": 0, "environment": [0, 0, 0]})
    check("report: counts", report["counts"] == {"patches": 2, "lamps": 1, "channels": 3, "degenerate": 0, "duplicate": 0})
    check("report: rays", report["counters"]["camera_rays"] == 16 * 12 * 4 and report["counters"]["rays"] > 0)
    said = report["pictures"][0]
    check("report: picture", (said["camera"], said["width"], said["height"]) == ("camera", 16, 12))
    pixels = 16 * 12
    for i, name in enumerate("RGB"):
        mean = math.fsum(picture.channels[name]) / pixels
        error = math.sqrt(math.fsum(picture.channels["variance." + name])) / pixels
        check(f"report: mean and standard error of {name}",
              abs(said["mean_radiance"][i] - mean) <= 1e-12 * mean
              and abs(said["standard_error"][i] - error) <= 1e-12 * error)
    noise = math.sqrt(math.fsum(math.fsum(picture.channels["variance." + c]) for c in "RGB")
                      / math.fsum(x * x for c in "RGB" for x in picture.channels[c]))
    check("report: noise", abs(said["noise"] - noise) <= 1e-12 * noise)


def read(command, name):
    with open(path_of(command, name), "rb") as file:
        return file.read()


def check_options(command):
    """That each option has its effect."""
    def run(*options):
        command("reference", "one.gltf", *SMALL, *options, "-o", "x.exr")
        return read(command, "x.exr")

    plain = run()
    check("the same again", run("--threads", "1") == plain)
    check("--seed makes a difference", run("--seed", "1") != plain)
    check("--environment 0 makes none", run("--environment", "0") == plain)
    check("one environment is three equal ones", run("--environment", "0.5") == run("--environment", ".5,5e-1,0.5") != plain)
    run("--environment", "1,0,0")
    picture = exr.read(path_of(command, "x.exr"))
    bright = [c for c in "RGB" if picture.channels[c][0] >= .999]
    check("--environment R,G,B: where nothing is seen R shows, without coverage",
          bright == ["R"] and picture.channels["A"][0] == 0)
    check("--max-reflectance makes a difference", run("--max-reflectance", "0.1") != plain)
    result = command("reference", "one.gltf", "--size", "16x12", "--samples", "4", "-o", "x.exr")
    check("it sums up on stdout",
          [word for word in ("wrote x.exr", "rays ", "noise ", "seconds ") if word not in result.stdout])
    result = command("reference", "dark.gltf", *SMALL, "-o", "x.exr")
    check("no light: done, with a warning", problems(result, 0, ["warning", "dark.gltf", "no light"]))
    check("every option made a file", os.path.exists(path_of(command, "x.exr")))


def main():
    with tempfile.TemporaryDirectory() as folder:
        command = Command(sys.argv[1], folder)
        write_scene(path_of(command, "one.gltf"))
        write_scene(path_of(command, "two.gltf"), cameras=("a/b", None))
        write_scene(path_of(command, "blind.gltf"), cameras=())
        write_scene(path_of(command, "dark.gltf"), plates=0)
        write_scene(path_of(command, "long.gltf"), plates=160)
        command("solve", "one.gltf", "--order", "0", "--subdivide", "0", "-o", "one.glb", "--quiet")
        check_z_test()
        check_agreement(command, os.path.abspath(sys.argv[2]))
        check_z_test_command(command)
        check_usage(command)
        check_pictures(command)
        check_options(command)
        check_signals(command)
    return done()


sys.exit(main())
