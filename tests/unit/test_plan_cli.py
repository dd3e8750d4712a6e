#!/usr/bin/env python3
"""hprad plan from outside: test_plan_cli.py HPRAD SCENES. What is left out ran zero operations; predictions against
measurements; what is too large; exit codes."""
import base64
import json
import os
import struct
import sys
import tempfile
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cli_support import Command, problems, write_scene  # noqa: E402
from tap import check, done  # noqa: E402

EFFECTS = ["channels", "lamps", "environment", "visibility", "interreflection", "two_sided", "textures", "openings"]
SCENES = ["parallel_plates", "parallel_plates_0.25", "l_corner", "furnace_cube", "furnace_box", "cube_mixed", "blocked_plates"]
# Sanitizers (./dev asan sets this) take several times the memory.
FORETOLD = ["dofs"] if "HPR_TEST_PATIENCE" in os.environ else ["dofs", "memory_bytes"]
# Refinement goes in steps: one step more or less may be a factor of 3, and this is at such a step: 455 coefficients are
# foretold, 180 suffice; at 6e-3 it takes 549.
AT_A_STEP = [("cube_mixed", 1e-2)]


def path_of(command, *parts):
    return os.path.join(command.folder, *parts)


def read(command, name):
    with open(path_of(command, name), encoding="utf-8") as file:
        return json.load(file)


def solve(command, scene, *options):
    result = command("solve", scene, *options, "-o", "x.glb", "--report", "s.json", "--quiet")
    check(f"hprad solve {os.path.basename(scene)} {' '.join(options)}", [] if result.returncode == 0 else [str(result)])
    return read(command, "s.json")


def plan(command, scene, *options):
    result = command("plan", scene, *options, "--report", "p.json", "--quiet")
    check(f"hprad plan {os.path.basename(scene)} {' '.join(options)}",
          [*([] if result.returncode == 0 else [result.stderr]), *([result.stdout] if result.stdout else [])])
    return read(command, "p.json")


def edited(command, scenes, name, target, change):
    """A copy of a scene beside its buffer, with its JSON changed."""
    with open(os.path.join(scenes, name + ".gltf"), encoding="utf-8") as file:
        gltf = json.load(file)
    change(gltf)
    for buffer in gltf["buffers"]:
        if not os.path.exists(path_of(command, buffer["uri"])):
            os.symlink(os.path.join(scenes, buffer["uri"]), path_of(command, buffer["uri"]))
    with open(path_of(command, target), "w", encoding="utf-8") as file:
        json.dump(gltf, file)


def called(told):
    return [name for name in EFFECTS if told["plan"][name]["called_for"]]


def blacken(gltf):
    for material in gltf["materials"]:
        material["pbrMetallicRoughness"]["baseColorFactor"] = [0, 0, 0, 1]
        material["pbrMetallicRoughness"]["metallicFactor"] = 0


def add_texture(gltf):
    """A picture of 2 x 2 white texels on the first lamp."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = (b"\0" + b"\xff" * 6) * 2
    png = (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)) +
           chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
    gltf["images"] = [{"uri": "data:image/png;base64," + base64.b64encode(png).decode()}]
    gltf["textures"] = [{"source": 0}]
    lamp = next(m for m in gltf["materials"] if any(m.get("emissiveFactor", [])))
    lamp["emissiveTexture"] = {"index": 0}


def check_left_out(command, scenes):
    cube = os.path.join(scenes, "furnace_cube.gltf")
    report = solve(command, cube)
    counters = report["counters"]
    check("a grey convex closed room: one channel", report["counts"]["channels_solved"] == 1)
    check("no ray, no clipping, no texture", [f"{k} {counters[k]}" for k in ("rays", "clips", "pairs_partial", "texture_means")
                                              if counters[k] != 0])
    check("and its report says so", called(report) == ["lamps", "interreflection"])
    check("its plan, too", called(plan(command, cube)) == ["lamps", "interreflection"])

    edited(command, scenes, "furnace_cube", "black.gltf", blacken)
    for options in ((), ("--tol", "1e-2"), ("--environment", "1")):
        report = solve(command, "black.gltf", *options)
        check("a black room: no link, no kernel block", report["counts"]["links"] == 0 and report["counts"]["block_bytes"] == 0)
        check("said so", "interreflection" not in called(report))
        check("light from outside is told", ("environment" in called(report)) == ("--environment" in options))
        check("no pair of elements is looked at: the blocks are those of lamps and sky",
              [f"{k} {report['counters'][k]}" for k in ("pairs_hidden", "pairs_visible", "pairs_partial", "rays", "clips")
               if report["counters"][k] != 0])
    check("its plan predicts that", plan(command, "black.gltf")["solves"][0]["predicted"]["links"] == 0)

    edited(command, scenes, "furnace_cube", "textured.gltf", add_texture)
    report = solve(command, "textured.gltf", "--order", "1", "--subdivide", "0")
    check("a texture is sampled once, and named", report["counters"]["texture_means"] == 1 and "textures" in called(report))

    for name, effects in (("cornell_box", ["channels", "lamps", "visibility", "interreflection", "openings"]),
                          ("l_corner", ["lamps", "interreflection", "openings"]),
                          ("blocked_plates", ["lamps", "visibility", "interreflection", "two_sided", "openings"])):
        scene = os.path.join(scenes, name + ".gltf")
        told, report = called(plan(command, scene)), solve(command, scene, "--order", "1", "--subdivide", "0")
        check(f"what {name} calls for", [] if told == [e for e in EFFECTS if e in told] and told == called(report) else
              [f"plan {told}, report {called(report)}"])
        check(f"as expected of {name}", [] if set(told) - {"two_sided"} == set(effects) - {"two_sided"} else [str(told)])
    write_scene(path_of(command, "dark.gltf"), plates=0)
    check("without light nothing is called for but what is there",
          not {"lamps", "visibility", "interreflection"} & set(called(plan(command, "dark.gltf"))))


def check_prediction(command, scenes):
    for name in SCENES:
        told = plan(command, os.path.join(scenes, name + ".gltf"), "--measure", "--max-time", "20")
        check(f"{name}: default and three tolerances", [s["tolerance"] for s in told["solves"]] == [None, .1, .01, .001])
        for row in told["solves"]:
            predicted, measured, tolerance = row["predicted"], row["measured"], row["tolerance"]
            if not measured:
                check(f"{name} at {tolerance}: too dear for 20 s", predicted["cpu_seconds"] > 20)
                continue
            if tolerance is None:
                check(f"{name}: elements, coefficients and links of the default are exact",
                      [f"{k}: {predicted[k]}, {measured[k]}" for k in ("elements", "dofs", "links") if predicted[k] != measured[k]])
            factor = 3 if (name, tolerance) in AT_A_STEP else 2
            check(f"{name} at {tolerance}: within a factor of {factor}",
                  [f"{k}: {predicted[k]}, {measured[k]}" for k in FORETOLD
                   if not 1 / factor <= predicted[k] / measured[k] <= factor])
            if tolerance:
                check(f"{name} at {tolerance}: reached", row["error_estimate"] <= tolerance)
    told = plan(command, os.path.join(scenes, "cornell_box.gltf"))
    check("nothing is measured unless asked", not any(s["measured"] for s in told["solves"]))
    given = plan(command, os.path.join(scenes, "cornell_box.gltf"), "--order", "1", "--subdivide", "0")
    check("and without tolerances nothing is tried", [str(given["stages"])] if {"assembly", "solver"} & {s["name"] for s in given["stages"]}
          else [])
    box = solve(command, os.path.join(scenes, "cornell_box.gltf"))["counts"]
    check("elements, coefficients and links of a box with obstacles are exact",
          [k for k in ("elements", "dofs", "links") if told["solves"][0]["predicted"][k] != box[k]])
    one = plan(command, os.path.join(scenes, "cornell_box.gltf"), "--tol", "0.05")
    check("--tol: this one alone", [s["tolerance"] for s in one["solves"]] == [.05])
    low = plan(command, os.path.join(scenes, "l_corner.gltf"), "--order", "1", "--subdivide", "3")
    check("degree 1 has no estimate, so no tolerance", len(low["solves"]) == 1 and low["solves"][0]["predicted"]["dofs"] == 512)


def check_too_large(command):
    write_scene(path_of(command, "large.gltf"), plates=1500)
    result = command("plan", "large.gltf", "--order", "16", "--report", "p.json")
    told = read(command, "p.json")
    check("too large: said, exit code 0", [] if result.returncode == 0 and "too large" in result.stdout else [str(result)])
    check("with predicted memory", told["solves"][0]["too_large"] and told["solves"][0]["predicted"]["memory_bytes"] > 1e10)
    check("pairs are drawn", 0 < told["pairs"]["drawn"] < told["pairs"]["all"])
    before = command.listing()
    check("solve refuses it", problems(command("solve", "large.gltf", "--order", "16", "-o", "s.glb"), 1,
                                       ["GB", "--max-memory", "--order"]))
    plates = ("solve", "plates.gltf", "--order", "1", "-o", "s.glb", "--quiet")  # a block of 4 x 4 doubles
    write_scene(path_of(command, "plates.gltf"), plates=2)
    for method in ((), ("--method", "exact", "--order", "0", "--subdivide", "2")):
        check(f"and what needs more than it may {method}",
              problems(command(*plates, *method, "--max-memory", "100"), 1, ["GB", "--max-memory", "--subdivide"]))
    check("nothing is written", sorted(command.listing()) == sorted([*before, "plates.gltf"]))
    check("what fits is solved", problems(command(*plates, "--max-memory", "1M"), 0))


def check_usage(command):
    write_scene(path_of(command, "one.gltf"))
    before = command.listing()
    for arguments, code, texts in (((), 2, ["one scene"]),
                                   (("one.gltf", "--max-time", "3"), 2, ["--max-time", "--measure"]),
                                   (("one.gltf", "--max-memory", "3G"), 2, ["--max-memory", "--measure"]),
                                   (("one.gltf", "--method", "exact"), 2, ["--method", "unknown option"]),
                                   (("one.gltf", "--environment", "1,2"), 2, ["2 radiances"]),
                                   (("one.gltf", "--report", "one.gltf"), 2, ["input"]),
                                   (("one.gltf", "--report", "no/x"), 1, ["'no/x'"]),
                                   (("none.gltf",), 3, ["none.gltf"])):
        check(f"hprad plan {' '.join(arguments)}", problems(command("plan", *arguments), code, texts, ""))
    check("what is refused writes nothing", command.listing() == before)
    result = command("plan", "one.gltf")
    check("the plan goes to stdout", [*problems(result, 0), *(w for w in (*EFFECTS, "called for", "left out", "default", "1e-03")
                                                              if w not in result.stdout)])


def main():
    with tempfile.TemporaryDirectory() as folder:
        command, scenes = Command(sys.argv[1], folder), os.path.abspath(sys.argv[2])
        check_left_out(command, scenes)
        check_prediction(command, scenes)
        check_too_large(command)
        check_usage(command)
    return done()


sys.exit(main())
