#!/usr/bin/env python3
"""The command from outside: test_cli.py HPRAD. Exit codes, messages, names of outputs, what failures leave."""
import csv
import json
import os
import re
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import exr  # noqa: E402
from cli_support import Command, LONG_SOLVE, SIGNALS, interrupt, problems, small_disk, write_scene  # noqa: E402
from tap import check, done  # noqa: E402

SMALL = ("--size", "16x12", "--samples", "1")
COARSE = ("--order", "0", "--subdivide", "1")

COMMON = ["--threads", "--isa", "--quiet", "--verbose", "--version", "--help"]
SOLVE = ["--order", "--subdivide", "--tol", "--environment", "--refine", "--max-time", "--max-memory", "--element-size", "--grade", "--link-tol", "--block-tol",
         "--solver", "--max-sweeps", "--max-reflectance", "--metallic",
         "--scene-index", "--report"]
FILM = ["--camera", "--size", "--samples", "--png", "--exposure"]
RENDER = [*FILM, "--camera-file", "--orbit", "--orbit-centre", "--frames", "--crop", "--filter", "--filter-width",
          "--aov", "--half", "--tiled", "--false-colour", "--compare"]
METHOD = ["--method", "--hemicube", "--rays", "--shots", "--every"]
OPTIONS = {"": SOLVE + RENDER, "solve": [*SOLVE, *METHOD, "--checkpoint", "--resume"], "render": [*RENDER, "--environment", "--report"], "probe": ["--gather"],
           "plan": ["--measure", *SOLVE],
           "batch": ["--jobs", "--memory", "--shard", "--dry-run"],
           "formfactors": ["--tol", "--order", "--use-eps", "--scene-index"],
           "reference": FILM + ["--seed", "--environment", "--max-reflectance", "--metallic", "--scene-index", "--report"],
           "study": ["--orders", "--subdivide", "--refine", "--method", "--direct", "--truth", "--points", "--repeats",
                     "--resume", "--json", "--feet", "--environment", "--link-tol", "--block-tol", "--solver", "--hemicube",
                     "--rays", "--max-reflectance", "--metallic", "--scene-index"]}

# arguments after `hprad`: texts that the message must hold
WRONG_USAGE = [
    ((), ["solve, render, probe, formfactors, reference, study, plan, batch", "--help"]),
    (("bake", "one.gltf"), ["'bake'", "verb", "file"]),
    (("batch",), ["no input", "one batch file"]),
    (("formfactors",), ["no input", "one model"]),
    (("--quiet", "solve", "one.gltf"), ["verb comes first", "solve"]),
    (("solve",), ["one scene"]),
    (("solve", ""), ["''", "one scene"]),
    (("solve", "one.gltf", "two.gltf"), ["'two.gltf'", "too many"]),
    (("render",), ["solution or scene"]),
    (("probe", "one.glb"), ["table of points"]),
    (("probe", "one.glb", "p.csv", "q.csv"), ["'q.csv'", "too many"]),
    (("solve", "one.gltf", "--colour", "3"), ["--colour", "unknown option"]),
    (("solve", "one.gltf", "-x"), ["-x", "unknown option"]),
    (("solve", "one.gltf", "--order"), ["--order", "missing argument"]),
    (("solve", "one.gltf", "--samples", "3"), ["--samples", "unknown option"]),
    (("render", "one.gltf", "--order", "3"), ["--order", "unknown option"]),
    (("solve", "one.gltf", "--refine", "h"), ["--refine", "--tol"]),
    (("solve", "one.gltf", "--max-time", "3"), ["--max-time", "--tol"]),
    (("solve", "one.gltf", "--tol", "1e-2", "--method", "exact"), ["--tol", "--method galerkin"]),
    (("solve", "one.gltf", "--tol", "1e-2", "--order", "1"), ["order 1", "at least 2"]),
    (("solve", "one.gltf", "-o", ""), ["empty"]),
    (("solve", "one.gltf", "--report", ""), ["--report"]),
    (("one.gltf", "-o", "{frames}.exr"), ["{frames}", "{camera}", "{frame:04}"]),
    (("render", "one.gltf", "-o", "{camera.exr"), ["{camera.exr", "{camera}"]),
    (("solve", "one.gltf", "--environment", "1,2"), ["one.gltf", "2 radiances", "each of 3"]),
    (("one.gltf", "--environment", "1,2,3,4"), ["one.gltf", "4 radiances"]),
    (("render", "one.gltf", "--environment", "1,2"), ["one.gltf", "2 radiances"]),
    (("render", "one.gltf", "--environment", "-1"), ["--environment '-1'"]),
    (("render", "one.glb", "--environment", "1"), ["one.glb", "is a solution", "solve the scene again"]),
    (("render", "two.gltf", "-o", "x.exr"), ["'x.exr'", "2 cameras", "{camera}", "--camera"]),
    (("render", "two.gltf", "-o", "x.exr", "--camera", "roof"), ["'roof'", "a_b", "camera0"]),
    (("two.gltf", "--camera", "2"), ["'2'", "a_b", "camera0"]),
    (("one.gltf", "-o", "x.png", "--png"), ["x.png", "two outputs"]),
    (("solve", "one.gltf", "-o", "x", "--report", "x"), ["'x'", "two outputs"]),
    (("solve", "one.gltf", "--scene-index", "7"), ["one.gltf", "scene 7"]),
    (("one.gltf", "--exposure", "2"), ["--exposure", "--png"]),
    (("solve", "one.gltf", "--hemicube", "64"), ["--hemicube", "--method hemicube"]),
    (("solve", "one.gltf", "--method", "hemicube", "--rays", "2"), ["--rays", "--method raycast"]),
    (("solve", "one.gltf", "--method", "raycast", "--shots", "2"), ["--shots", "--solver shooting"]),
    (("solve", "one.gltf", "--solver", "shooting", "--every", "2"), ["--every", "full matrix"]),
    (("solve", "one.gltf", "--method", "exact", "--direct", "exact"), ["--direct exact", "--method galerkin"]),
    (("solve", "one.gltf", "--method", "exact", "--order", "1"), ["order 1", "'exact'"]),
    (("solve", "one.gltf", "--solver", "direct"), ["'galerkin'", "full matrix"]),
    (("one.gltf", "--method", "exact"), ["--method", "unknown option"]),
    (("one.gltf", "--orbit-centre", "0,1,2"), ["--orbit-centre", "--orbit"]),
    (("render", "two.gltf", "--orbit", "3"), ["2 with --camera", "a_b"]),
    (("render", "one.gltf", "-o", "x.exr", "--orbit", "3"), ["'x.exr'", "3 pictures", "{frame:04}"]),
    (("render", "one.gltf", "--orbit", "3", "--frames", "2-3"), ["2 to 3", "0 to 2"]),
    (("render", "one.glb", "--frames", "1"), ["1 to 1", "0 to 0"]),
    (("render", "one.glb", "--size", "16x12", "--crop", "0,0,17,12"), ["0,0 to 17,12", "16 x 12"]),
    (("render", "one.glb", "-o", "x.exr", "--compare", "{x}.exr"), ["{x}", "{camera}"]),
    (("render", "one.glb", "-o", "points.csv", "--compare", "points.csv"), ["'points.csv'", "is read"]),
    (("render", "one.glb", "-o", "one.gltf", "--camera-file", "one.gltf"), ["'one.gltf'", "input"]),
    (("solve", "one.gltf", "-o", "one.gltf"), ["'one.gltf'", "input"]),
    (("solve", "one.gltf", "-o", "link.gltf"), ["'link.gltf'", "input"]),
    (("solve", "one.gltf", "--report", "./one.gltf"), ["'./one.gltf'", "input"]),
    (("one.gltf", "-o", "one.gltf"), ["'one.gltf'", "input"]),
    (("probe", "one.glb", "points.csv", "-o", "points.csv"), ["'points.csv'", "input"]),
    (("probe", "one.glb", "points.csv", "-o", "one.glb"), ["'one.glb'", "input"]),
]

# option: values that are refused
BAD_VALUES = {
    "--threads": ["0", "-1", "x", "2x", "", " 2", "1.5", "99999999999999999999"],
    "--isa": ["avx1024", ""],
    "--order": ["-1", "17", "two", "2.0", "0x2"],
    "--subdivide": ["-1", "11", "1e1"],
    "--environment": ["", "x", "-1", "1,2,", ",1,2", "1,,2", "nan", "inf", "1,-1,1", "0x1", "1 ", "1;2;3", "1e999"],
    "--element-size": ["0", "-1", "x", "inf", ""],
    "--grade": ["-1", "21", "x"],
    "--link-tol": ["0", "1", "-1e-3", "nan", "x", ""],
    "--solver": ["jacobi", "GMRES", ""],
    "--method": ["radiosity", "Hemicube", ""],
    "--hemicube": ["0", "1", "3", "4098", "x"],
    "--rays": ["0", "65", "x"],
    "--shots": ["0", "-1", "x"],
    "--every": ["0", "-1", "x"],
    "--block-tol": ["0", "1", "-1e-3", "nan", "inf", "0x1p-3", "1e-3x", ""],
    "--max-sweeps": ["0", "-5", "many"],
    "--max-reflectance": ["0", "1.01", "nan"],
    "--metallic": ["grey", ""],
    "--scene-index": ["-1", "first"],
    "--tol": ["0", "1", "x", "nan"],
    "--size": ["640", "640x", "x480", "0x480", "640x480x3", "640X480", "-640x480", "99999x1", ""],
    "--samples": ["0", "-4", "4.5"],
    "--exposure": ["0", "-1", "inf", "bright"],
    "--camera-file": [""],
    "--orbit": ["0", "-3", "x", "1000001"],
    "--orbit-centre": ["", "1,2", "1,2,3,4", "1,2,x", "1;2;3", "nan,0,0", "1e999,0,0"],
    "--frames": ["", "x", "-1", "3-2", "1-2-3", "1,2", "1-", "99999999999999999"],
    "--crop": ["", "1,2,3", "0,0,0,1", "0,5,1,5", "-1,0,1,1", "0,0,1,1,1", "0 0 1 1"],
    "--filter": ["", "mitchell"],
    "--filter-width": ["0", "17", "-1", "wide"],
    "--aov": ["", "depth", "N,", "N,,P", "irradiance.R", "n"],
    "--false-colour": ["", "0", "-2", "viridis"],
    "--compare": [""],
}


def path_of(command, *parts):
    return os.path.join(command.folder, *parts)


def make_inputs(command):
    """The scenes and broken files that the tables name."""
    write_scene(path_of(command, "one.gltf"))
    write_scene(path_of(command, "two.gltf"), cameras=("a/b", None))
    write_scene(path_of(command, "dark.gltf"), plates=0, cameras=())
    write_scene(path_of(command, "draco.gltf"), extensionsUsed=["KHR_draco_mesh_compression"],
                extensionsRequired=["KHR_draco_mesh_compression"])
    write_scene(path_of(command, "long.gltf"), cameras=("a", "b"), plates=160)
    os.symlink("one.gltf", path_of(command, "link.gltf"))
    os.mkdir(path_of(command, "folder.gltf"))
    texts = {"empty.gltf": b"", "garbage.gltf": b"\x00\xff not json", "cut.glb": b"glTF\x02\x00\x00\x00",
             "points.csv": b"x,y,z,nx,ny,nz\n0.1,0,0.2,0,1,0\n9,9,9,0,1,0\n",
             "header.csv": b"x,y,z\n1,2,3\n", "word.csv": b"x,y,z,nx,ny,nz\n0,0,zero,0,1,0\n"}
    for name, text in texts.items():
        with open(path_of(command, name), "wb") as file:
            file.write(text)


def check_help(command):
    for verb, options in OPTIONS.items():
        name = " ".join(["hprad", verb]).strip()
        result = command(*filter(None, [verb]), "--help")
        missing = [option for option in options + COMMON if f" {option}" not in result.stdout]
        check(f"{name} --help names every option",
              [*problems(result, 0), *missing, *(["no usage"] if f"Usage: {name}" not in result.stdout else [])])
        check(f"{name} --help leaves its texts room", [line for line in re.findall(r"^ {2}(?:-\w, | {4})--\S+", result.stdout, re.M)
                                                       if len(line) > 30])
        check(f"{name} --help has an example", "Example" in result.stdout and f"\n  {name} " in result.stdout)
    result = command("--help")
    check("hprad --help lists the verbs", [v for v in OPTIONS if v and f"hprad {v}" not in result.stdout])
    result = command("solve", "--order", "2", "--version")
    lines = result.stdout.splitlines()
    check("--version tells version, commit, Embree and instruction set",
          [*problems(result, 0), *(w for w in ("hprad ", "commit", "Embree ", "instruction set ")
                                   if w not in result.stdout)] + ([] if len(lines) == 3 else [result.stdout]))


def check_usage(command):
    before = command.listing()
    for arguments, texts in WRONG_USAGE:
        check(f"wrong usage: hprad {' '.join(arguments)}", problems(command(*arguments), 2, texts, ""))
    for option, values in BAD_VALUES.items():
        verb = () if option in RENDER else ("solve",)
        wrong = []
        for value in values:
            wrong += problems(command(*verb, "one.gltf", option, value), 2, [f"{option} '{value}'"], "")
        check(f"{option} refuses {len(values)} bad values, naming each", wrong)
    check("wrong usage writes nothing", command.listing() == before)


def check_inputs(command):
    cases = [(("missing.gltf",), ["missing.gltf", "No such file"]),
             (("solve", "missing.gltf", "-o", "x.glb"), ["missing.gltf", "No such file"]),
             (("render", "missing.glb", "-o", "x.exr"), ["missing.glb", "No such file"]),
             (("render", "one.glb", "-o", "x.exr", "--camera-file", "missing.gltf"), ["missing.gltf", "No such file"]),
             (("render", "one.glb", "-o", "x.exr", "--camera-file", "dark.gltf"), ["dark.gltf", "no camera"]),
             (("render", "one.glb", "-o", "x.exr", "--compare", "missing.exr"), ["missing.exr", "No such file"]),
             (("render", "one.glb", "-o", "x.exr", "--compare", "garbage.gltf"), ["garbage.gltf", "OpenEXR"]),
             (("solve", "empty.gltf"), ["empty.gltf"]),
             (("solve", "garbage.gltf"), ["garbage.gltf"]),
             (("solve", "folder.gltf"), ["folder.gltf"]),
             (("solve", "cut.glb", "-o", "x.glb"), ["cut.glb"]),
             (("solve", "draco.gltf"), ["draco.gltf", "KHR_draco_mesh_compression"]),
             (("solve", "one.glb", "-o", "x.glb"), ["one.glb", "is a solution", "render"]),
             (("one.glb", "-o", "x.exr"), ["one.glb", "is a solution", "render"]),
             (("probe", "missing.glb", "points.csv"), ["missing.glb", "No such file"]),
             (("probe", "one.glb", "missing.csv"), ["missing.csv", "No such file"]),
             (("probe", "one.gltf", "points.csv"), ["one.gltf"]),
             (("probe", "one.glb", "header.csv"), ["header.csv", "nx"]),
             (("probe", "one.glb", "word.csv"), ["word.csv", "zero"])]
    before = command.listing()
    for arguments, texts in cases:
        check(f"bad input: hprad {' '.join(arguments)}", problems(command(*arguments), 3, texts, ""))
    with open(path_of(command, "one.glb"), "rb") as file:
        whole = file.read()
    for part in (0.2, 0.9):
        with open(path_of(command, "part.glb"), "wb") as file:
            file.write(whole[:int(part * len(whole))])
        check(f"bad input: a solution cut to {part:.0%}",
              problems(command("render", "part.glb", "-o", "x.exr"), 3, ["part.glb"], ""))
    os.remove(path_of(command, "part.glb"))
    check("bad input writes nothing", command.listing() == before)


def check_outputs_refused(command):
    """What is refused after the long solve would run out of patience."""
    long_solve = ("long.gltf", *LONG_SOLVE)
    places = {"no/x": ["'no/x'", "folder 'no'", "No such file or directory"],
              "points.csv/x": ["'points.csv/x'", "Not a directory"],
              "folder.gltf": ["'folder.gltf'", "folder"],
              "folder.gltf/": ["'folder.gltf/'", "folder"],
              "new/": ["'new/'", "folder"],
              "/proc/x": ["'/proc/x'", "folder '/proc'"]}
    before = command.listing()
    for place, texts in places.items():
        for verb, option in (("solve", "-o"), ("solve", "--report"), (None, "-o"), (None, "--report")):
            arguments = (*filter(None, [verb]), *long_solve, option, place, *(() if verb else ("--camera", "a")))
            check(f"before the work: hprad {' '.join(arguments)}", problems(command(*arguments), 1, texts, ""))
        check(f"before the work: hprad render one.glb -o {place}",
              problems(command("render", "one.glb", "-o", place), 1, texts, ""))
        check(f"before the work: hprad probe one.glb points.csv -o {place}",
              problems(command("probe", "one.glb", "points.csv", "-o", place), 1, texts, ""))
    check("before the work: the second camera's folder",
          problems(command(*long_solve, "-o", "x/{camera}/{frame}.exr"), 1, ["'x/a/0.exr'"], ""))
    name = "n" * 300
    check("before the work: a name that is too long",
          problems(command("solve", *long_solve, "-o", name), 1, [name, "too long"], ""))
    if os.geteuid() != 0:
        os.mkdir(path_of(command, "locked"), 0o500)
        check("before the work: a folder that is not ours",
              problems(command("solve", *long_solve, "-o", "locked/x"), 1, ["'locked/x'", "Permission denied"], ""))
        os.rmdir(path_of(command, "locked"))
    check("refused outputs leave nothing", command.listing() == before)


def check_full_disk(command):
    full = ["No space left on device"]
    before = command.listing()
    for arguments in (("solve", "one.gltf", *COARSE, "-o", "/dev/full"),
                      ("solve", "one.gltf", *COARSE, "-o", "/dev/null", "--report", "/dev/full"),
                      ("one.gltf", *COARSE, *SMALL, "-o", "/dev/full"),
                      ("render", "one.glb", *SMALL, "-o", "/dev/full"),
                      ("probe", "one.glb", "points.csv", "-o", "/dev/full")):
        check(f"no room: hprad {' '.join(arguments)}", problems(command(*arguments), 1, full))
    for arguments in (("--help",), ("--version",), ("probe", "one.glb", "points.csv"),
                      ("solve", "one.gltf", *COARSE, "-o", "/dev/null")):
        with open("/dev/full", "w", encoding="utf-8") as stdout:
            check(f"no room on stdout: hprad {' '.join(arguments)}",
                  problems(command(*arguments, stdout=stdout), 1, full))
    check("a full device leaves nothing behind", command.listing() == before)
    with small_disk(command.folder, 8) as place:
        if not place:
            return
        for arguments, target in ((("solve", "one.gltf"), "x.glb"),
                                  (("one.gltf", *COARSE, "--size", "600x600"), "x.exr"),
                                  (("render", "one.glb", "--size", "600x600"), "x.exr")):
            result = command(*arguments, "-o", os.path.join(place, target))
            left = os.listdir(place)
            check(f"a small disk: hprad {' '.join(arguments)}",
                  [*problems(result, 1, [*full, target], ""), *(f"left: {name}" for name in left)])


def check_choice(command):
    """101 patches, and no light, so that nothing but the choice is made."""
    def settings(*options, stderr):
        result = command("solve", "many.gltf", *options, "-o", "many.glb", "--report", "many.json")
        with open(path_of(command, "many.json"), encoding="utf-8") as file:
            found = json.load(file)
        said = any(text in warning for text in stderr for warning in found["warnings"])
        return [*problems(result, 0, [*stderr, "no light"]), *([] if said or not stderr else ["not in the report"])], [
            found["settings"][key] for key in ("order", "subdivide", "feet", "element_size_m")], found["counts"]["dofs"]

    def check_settings(fact, options, stderr, expected, least, most):
        wrong, chosen, dofs = settings(*options, stderr=stderr)
        check(fact, [*wrong, *([f"{chosen}"] if chosen[:len(expected)] != expected else []),
                     *([f"{dofs} coefficients"] if not least <= dofs <= most else [])])

    write_scene(path_of(command, "many.gltf"), plates=50, materials=[{}, {"doubleSided": True}])
    check_settings("a scene of many patches is solved on elements of one size, and that is said", (),
                   ["101 patches", "--order 4 --subdivide 0 --feet 0 --element-size "], [4, 0, 0], 2526, 12000)
    check_settings("but not if order and subdivision are given", ("--order", "4", "--subdivide", "2"), [], [4, 2, 0, 0],
                   101 * 25 * 16, 101 * 25 * 16)
    check_settings("a given order stays", ("--order", "5"), ["--order 5 --subdivide 0 --feet 0"], [5, 0, 0], 3637, 12000)
    # 16 elements on the floor of 1 x 1, 4 on each side of a lamp of 0.5 x 0.5
    check_settings("a given size of elements is kept", ("--order", "1", "--element-size", "0.26"), [], [1, 0, 0, .26],
                   4 * (16 + 100 * 4), 4 * (16 + 100 * 4))


def check_solve(command):
    result = command("solve", "one.gltf", *COARSE, "-o", "x.glb", "--report", "x.json")
    words = ("patches", "elements", "dofs", "sweeps", "residual", "seconds", "wrote x.glb", "wrote x.json")
    check("solve sums up on stdout", [*problems(result, 0), *(w for w in words if w not in result.stdout)])
    with open(path_of(command, "x.json"), encoding="utf-8") as file:
        report = json.load(file)
    check("the report is JSON and names the scene", "one.gltf" in json.dumps(report))
    result = command("solve", "one.gltf", *COARSE, "-o", "y.glb", "--quiet")
    check("--quiet says nothing", problems(result, 0, (), ""))
    command("solve", "one.gltf", *COARSE, "-o", "z.glb", "--threads", "1", "--quiet")
    check("one thread or several: the same bits", [f"{name}.glb differs" for name in "yz"
                                                   if read(command, f"{name}.glb") != read(command, "x.glb")])
    piped = subprocess.run([command.path, "solve", "one.gltf", *COARSE, "-o", "/dev/stdout"],
                           cwd=command.folder, stdout=subprocess.PIPE, check=False).stdout
    check("a solution on stdout is not mixed with the summary", piped == read(command, "x.glb"))
    os.mkdir(path_of(command, "elsewhere"))
    result = command("solve", "../one.gltf", *COARSE, "--quiet", folder=path_of(command, "elsewhere"))
    found = command.listing("elsewhere")
    check("solve writes <scene>.glb to the working folder",
          [*problems(result, 0)] + ([] if found == ["one.glb"] else [f"found {found}"]))
    result = command("solve", "dark.gltf", *COARSE, "-o", "dark.glb")
    check("no light: done, with a warning", problems(result, 0, ["warning", "dark.gltf", "no light"]))
    os.remove(path_of(command, "elsewhere", "one.glb"))


def check_methods(command):
    """The classical methods through the command: what the report says, and the solution after every n shots."""
    for method in ("galerkin", "hierarchical", "hemicube", "raycast", "exact"):
        options = ("--hemicube", "64") if method == "hemicube" else ("--rays", "3") if method == "raycast" else ()
        order = () if method != "galerkin" else ("--order", "0")
        result = command("solve", "one.gltf", "--method", method, "--subdivide", "1", *order, *options, "-o", "m.glb",
                         "--report", "m.json")
        with open(path_of(command, "m.json"), encoding="utf-8") as file:
            report = json.load(file)
        wrong = [*problems(result, 0)]
        if (report["settings"]["method"], report["settings"]["order"]) != (method, 0):
            wrong.append(f"the report says {report['settings']}")
        check(f"--method {method}: solved, and the report names it", wrong)
        result = command("probe", "m.glb", "points.csv")
        check(f"--method {method}: the solution can be probed", problems(result, 0, ["nomatch"]))
    shots = ("--method", "raycast", "--subdivide", "1", "--solver", "shooting", "--shots", "5", "--every", "2")
    result = command("solve", "one.gltf", *shots, "-o", "s.glb", "--report", "s.json")
    files = [name for name in command.listing() if name.startswith("s")]
    wrong = [] if files == ["s.glb", "s.json", "s_000002.glb", "s_000004.glb"] else [f"found {files}"]
    check("--every 2 of 5 shots: two solutions on the way", [*problems(result, 0), *wrong])
    with open(path_of(command, "s.json"), encoding="utf-8") as file:
        report = json.load(file)
    check("the report counts the shots", report["solver"]["method"] == "shooting" and report["solver"]["sweeps"] == 5)
    check("what the matrix does not know is null",
          all(e["lost_on_backs"] is None and e["escaped"] is None for e in report["energy"]))
    result = command("render", "s_000002.glb", *SMALL, "-o", "s.exr")
    check("what was kept on the way can be rendered", problems(result, 0))
    result = command("solve", "one.gltf", "--method", "raycast", "--environment", "1", "-o", "m.glb")
    check("no light from outside with a full matrix", problems(result, 3, ["'raycast'", "outside"]))


def read(command, *parts):
    with open(path_of(command, *parts), "rb") as file:
        return file.read()


def check_pictures(command):
    folder = path_of(command, "elsewhere")

    def pictures(fact, arguments, expected, code=0):
        for name in os.listdir(folder):
            os.remove(os.path.join(folder, name))
        result = command(*arguments, *SMALL, folder=folder)
        found = sorted(os.listdir(folder))
        check(fact, [*problems(result, code)] + ([] if found == sorted(expected) else [f"found {found}"]))
        return result

    solved = ("../two.gltf", *COARSE)
    command("solve", "two.gltf", *COARSE, "-o", "two.glb", "--quiet")
    pictures("one go: the default name", ("../one.gltf", *COARSE), ["one.exr"])
    pictures("one go: several cameras, default name", solved, ["two_a_b.exr", "two_camera0.exr"])
    pictures("one go: several cameras, one name", (*solved, "-o", "x.exr"), ["x_a_b.exr", "x_camera0.exr"])
    pictures("one go: --camera keeps the name", (*solved, "-o", "x.exr", "--camera", "a/b"), ["x.exr"])
    pictures("one go: report and previews beside", (*solved, "--png", "--camera", "0", "--report", "r.json"),
             ["two.exr", "two.png", "r.json"])
    write_scene(path_of(command, "blind.gltf"), cameras=())
    pictures("one go: a scene without camera gets one", ("../blind.gltf", *COARSE, "-o", "{camera}.exr"),
             ["camera0.exr"])
    pictures("render: {camera}", ("render", "../two.glb", "-o", "{camera}.exr"), ["a_b.exr", "camera0.exr"])
    pictures("render: {frame:04}", ("render", "../two.glb", "-o", "f{frame:04}.exr"), ["f0000.exr", "f0001.exr"])
    pictures("render: camera by its name in files", ("render", "../two.glb", "--camera", "a_b"), ["two.exr"])
    pictures("render: camera by index", ("render", "../two.glb", "-o", "{camera}{frame}.exr", "--camera", "1"),
             ["camera00.exr"])
    pictures("render: --camera all", ("render", "../two.glb", "--camera", "all"),
             ["two_a_b.exr", "two_camera0.exr"])
    pictures("render solves a scene", ("render", "../one.gltf"), ["one.exr"])
    result = pictures("render: previews", ("render", "../two.glb", "--png", "--camera", "1"), ["two.exr", "two.png"])
    check("the exposure of a preview is stated", "exposure" in result.stdout)
    width, height = struct.unpack(">II", read(command, "elsewhere", "two.png")[16:24])
    check("--size is obeyed", (width, height) == (16, 12))
    result = pictures("render: --exposure", ("render", "../one.glb", "--png", "--exposure", "0.25"),
                      ["one.exr", "one.png"])
    check("a chosen exposure is stated", "exposure 0.25)" in result.stdout)
    several = read(command, "elsewhere", "one.exr")
    pictures("render: one thread", ("render", "../one.glb", "--threads", "1", "--quiet"), ["one.exr"])
    check("one thread or several: the same picture", read(command, "elsewhere", "one.exr") == several)
    check("the picture is an OpenEXR file", several[:4] == b"\x76\x2f\x31\x01")


def check_tolerance(command):
    """A tolerance that is met, and one that --max-time leaves no time for: all is written, and then exit code 4."""
    def report(name):
        with open(path_of(command, name), encoding="utf-8") as file:
            return json.load(file)

    missed = ("--tol", "1e-6", "--max-time", "1e-9", "--quiet")
    for verb, arguments, files in (("solve", ("-o", "late.glb"), ["late.glb"]),
                                   ("", (*SMALL, "-o", "late.exr"), ["late.exr"])):
        result = command(*filter(None, [verb]), "one.gltf", *missed, *arguments, "--report", "late.json")
        told = report("late.json")
        estimate = f"{told['error_estimate']:.2e}"
        check(f"hprad {verb}: a tolerance that is missed",
              problems(result, 4, ["one.gltf", f"estimated error is {estimate}", "tolerance 1e-06", "is written"], ""))
        check(f"hprad {verb}: the report says so",
              told["error_estimate"] > 1e-6 and told["settings"]["tolerance"] == 1e-6)
        for name in (*files, "late.json"):
            check(f"hprad {verb}: {name} is there all the same", name in command.listing())
            os.remove(path_of(command, name))
    for verb, arguments in (("solve", ("-o", "met.glb")), ("", (*SMALL, "-o", "met.exr"))):
        result = command(*filter(None, [verb]), "one.gltf", "--tol", "0.5", *arguments, "--report", "met.json")
        told = report("met.json")
        check(f"hprad {verb}: a tolerance that is met", [*problems(result, 0), *(
            [] if 0 <= told["error_estimate"] <= .5 else [f"{told}"])])
    check("the parts of the error add up", abs(sum(told["error_parts"].values()) - told["error_estimate"]) <= 1e-12)
    result = command("solve", "dark.gltf", "--tol", "1e-3", "-o", "dark.glb")
    check("no light with a tolerance: done, with a warning", problems(result, 0, ["warning", "dark.gltf", "no light"]))


def check_environment(command):
    """Light from outside, through the command."""
    def picture(*arguments):
        result = command(*arguments, *SMALL, "-o", "x.exr")
        check(f"hprad {' '.join(arguments)}", problems(result, 0))
        return read(command, "x.exr")

    plain = picture("one.gltf", *COARSE)
    check("--environment 0 makes no difference", picture("one.gltf", *COARSE, "--environment", "0") == plain)
    bright = picture("one.gltf", *COARSE, "--environment", "0.5")
    check("one radiance is for all channels",
          bright == picture("one.gltf", *COARSE, "--environment", ".5,5e-1,0.5") != plain)
    seen = exr.read(path_of(command, "x.exr")).channels
    outside = [i for i, covered in enumerate(seen["A"]) if covered == 0]
    check("the camera sees it where nothing is, without coverage",
          outside and all(seen[c][i] == .5 for i in outside for c in "RGB"))
    command("solve", "one.gltf", *COARSE, "--environment", "0.5", "-o", "sky.glb", "--report", "sky.json")
    check("a solution keeps it", picture("render", "sky.glb") == bright)
    check("render solves a scene with it", picture("render", "one.gltf", "--environment", "0.5")
          == picture("one.gltf", "--environment", "0.5"))
    with open(path_of(command, "sky.json"), encoding="utf-8") as file:
        report = json.load(file)
    check("the report says so", report["environment"]["radiance"] == [.5] * 3
          and report["environment"]["direct"] == "exact" and report["energy"][0]["environment"] > 0)
    dark, lit = (float(next(csv.DictReader(command("probe", name, "points.csv").stdout.splitlines()))["irradiance_r"])
                 for name in ("one.glb", "sky.glb"))
    check("probe knows it", lit > dark + .1)
    result = command("solve", "dark.gltf", *COARSE, "--environment", "1", "-o", "x.glb")
    check("an environment is light: no warning", problems(result, 0))
    for name in ("x.exr", "x.glb", "sky.glb", "sky.json"):
        os.remove(path_of(command, name))


def check_probe(command):
    result = command("probe", "one.glb", "points.csv")
    rows = list(csv.DictReader(result.stdout.splitlines()))
    check("probe: a point on no patch is a warning", problems(result, 0, ["warning", "1 of 2"]))
    check("probe: ok and nomatch", [row["status"] for row in rows] == ["ok", "nomatch"])
    check("probe: the point on the floor is lit", float(rows[0]["irradiance_r"]) > 0)
    result = command("probe", "one.glb", "points.csv", "-o", "out.csv")
    with open(path_of(command, "out.csv"), encoding="utf-8") as file:
        check("probe: -o writes the same table", list(csv.DictReader(file)) == rows)
    os.remove(path_of(command, "out.csv"))
    result = command("probe", "one.glb", "points.csv", "-o", "-")
    check("probe: -o - is stdout", list(csv.DictReader(result.stdout.splitlines())) == rows)
    gathered = list(csv.DictReader(command("probe", "one.glb", "points.csv", "--gather").stdout.splitlines()))
    plain, other = (float(r[0]["irradiance_r"]) for r in (rows, gathered))
    check(f"probe --gather: such a table, too ({other / plain - 1:.1e})",
          [row["status"] for row in gathered] == ["ok", "nomatch"] and abs(other / plain - 1) < .2)


def check_signals(command):
    before = command.listing()
    runs = {"solve": (("solve", "long.gltf", *LONG_SOLVE, "-o", "x.glb", "--report", "x.json"), "assembly"),
            "one go": (("long.gltf", *LONG_SOLVE, "-o", "x.exr", "--png"), "assembly"),
            "render": (("render", "one.glb", "-o", "x.exr", "--size", "2000x2000", "--samples", "4096"), "render")}
    for name, (arguments, stage) in runs.items():
        for signal_name, (number, code) in SIGNALS.items():
            got, text = interrupt(command, number, arguments, stage)
            wrong = [] if got == code and signal_name in text else [f"exit code {got}, terminal {text!r}"]
            check(f"{signal_name} during {name}: exit code {code}, said so", wrong)
            left = [file for file in command.listing() if file not in before]
            check(f"{signal_name} during {name}: nothing is left", left)
    result = command("solve", "one.gltf", *COARSE, "-o", "x.glb", "--verbose")
    check("no progress bar where stderr is no terminal", "\r" not in result.stderr)
    os.remove(path_of(command, "x.glb"))


def main():
    with tempfile.TemporaryDirectory() as folder:
        command = Command(sys.argv[1], folder)
        make_inputs(command)
        check_help(command)
        result = command("solve", "one.gltf", *COARSE, "-o", "one.glb")
        check("solve: exit code 0", problems(result, 0))
        check_usage(command)
        check_choice(command)
        check_solve(command)
        check_methods(command)
        check_inputs(command)
        check_outputs_refused(command)
        check_full_disk(command)
        check_pictures(command)
        check_tolerance(command)
        check_environment(command)
        check_probe(command)
        check_signals(command)
    return done()


sys.exit(main())
