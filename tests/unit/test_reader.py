#!/usr/bin/env python3
"""notebooks/hprad_reader.py and the notebooks: test_reader.py ROOT HPRAD. Needs numpy; where this interpreter has none,
Debian's takes over, and if that has none either the test is skipped."""
import json
import math
import os
import struct
import sys
import tempfile

ROOT, HPRAD = (os.path.abspath(path) for path in sys.argv[1:3])
sys.path[:0] = [os.path.join(ROOT, "tests", "support"), os.path.join(ROOT, "notebooks")]
try:
    import numpy as np
except ImportError:
    if sys.executable != "/usr/bin/python3" and os.path.exists("/usr/bin/python3"):
        os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv])
    print("1..0 # SKIP numpy is missing")
    sys.exit(0)
sys.dont_write_bytecode = True
import exr  # noqa: E402
import hprad_reader  # noqa: E402
from cli_support import Command, problems, write_scene  # noqa: E402
from png import png, uri  # noqa: E402
from tap import check, done  # noqa: E402


def refused(function, path):
    try:
        function(path)
    except ValueError as error:
        return os.path.basename(path) in str(error)
    return False


ROWS = [[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (255, 255, 255)]]  # 0 and 255 are the same in sRGB and linear


def write_textured(plain, path):
    """The floor of write_scene with a picture on it."""
    with open(plain, encoding="utf-8") as file:
        scene = json.load(file)
    places = struct.pack("<8f", 0, 0, 1, 0, 1, 1, 0, 1)
    scene["buffers"].append({"byteLength": len(places), "uri": uri("application/octet-stream", places)})
    scene["bufferViews"].append({"buffer": 1, "byteLength": len(places)})
    scene["accessors"].append({"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"})
    floor = scene["meshes"][0]["primitives"][0]
    floor["attributes"] = dict(floor["attributes"], TEXCOORD_0=2)
    scene["materials"][0]["pbrMetallicRoughness"] = {"baseColorTexture": {"index": 0}, "metallicFactor": 0}
    scene.update(textures=[{"source": 0}], images=[{"uri": uri("image/png", png(ROWS))}])
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)


def check_reader(folder):
    command = Command(HPRAD, folder)
    write_scene(os.path.join(folder, "one.gltf"))

    def run(*arguments):
        check("hprad " + " ".join(arguments), problems(command(*arguments, "--quiet"), 0))

    def path(name):
        return os.path.join(folder, name)

    run("solve", "one.gltf", "--order", "2", "--subdivide", "1", "--direct", "galerkin", "-o", "s.glb", "--report", "s.json")
    solution, report = hprad_reader.solution(path("s.glb")), hprad_reader.report(path("s.json"))
    e, s = solution["elements"], solution["solution"]
    check("a solution: shapes", bool(s["irradiance"].shape == (report["counts"]["dofs"], 3) and e["origin"].shape == (e["count"], 3)
          and s["leaf"].dtype == np.uint32 and s["firstCoefficient"][-1, 0] == report["counts"]["dofs"]))
    first = s["firstCoefficient"][:-1, 0]
    leaf = s["leaf"][:, 0]
    mean = s["irradiance"][first] * np.sqrt(e["area"][leaf])  # T_0 = 1 / sqrt(A)
    rho = solution["patches"]["reflectance"][e["patch"][leaf, 0]]
    absorbed = ((1 - rho) * mean).sum(axis=0)
    check("a solution: what is absorbed is what the report says",
          np.allclose(absorbed, [channel["absorbed"] for channel in report["energy"]], rtol=1e-12))
    run("render", "s.glb", "-o", "s.exr", "--size", "37x29", "--aov", "degree,error,patchId,elementId")
    image = hprad_reader.picture(path("s.exr"))
    shown = image["elementId"] < len(leaf)
    node = leaf[image["elementId"][shown]]
    rms = s["error"][image["elementId"][shown], 0] / np.sqrt(e["area"][node, 0])
    check("layers: elements that are shown have their patch, degree and estimated error", bool(
        shown.any() and (rms > 0).all() and np.array_equal(image["patchId"][shown], e["patch"][node, 0])
        and (image["degree"][shown] == 2).all() and np.allclose(image["error"][shown], rms, rtol=1e-6)))
    write_textured(path("one.gltf"), path("painted.gltf"))
    run("solve", "painted.gltf", "--order", "2", "--subdivide", "1", "-o", "painted.glb")
    solution = hprad_reader.solution(path("painted.glb"))
    e, s, leaf = solution["elements"], solution["solution"], solution["solution"]["leaf"][:, 0]
    check("a solution: texels of textures", np.array_equal(solution["textures"][0]["texels"], np.reshape(ROWS, (4, 3)) / np.float32(255)))
    run("solve", "one.gltf", "--method", "raycast", "--subdivide", "1", "-o", "classical.glb")
    classical = hprad_reader.solution(path("classical.glb"))
    check("a solution: what is not known is NaN, a number", all(math.isnan(channel["escaped"]) for channel in classical["energy"])
          and bool(np.isnan(classical["solution"]["error"]).all()))
    layers = "irradiance,direct,indirect,emission,albedo,N,P,Z,degree,error,patchId,elementId"
    for name, options, kind in (("plain", (), "f4"), ("layers", ("--aov", layers), "f4"), ("half", ("--half", "--aov", layers), "f2"),
                                ("tiled", ("--tiled", "--size", "97x71"), "f4"), ("crop", ("--crop", "5,6,20,25"), "f4")):
        run("render", "painted.glb", "-o", name + ".exr", "--size", "37x29", *options)
        mine, plain = hprad_reader.picture(path(name + ".exr")), exr.read(path(name + ".exr"))
        wrong = [c for c in plain.channels if c not in mine or mine[c].shape != (plain.height, plain.width)
                 or not np.array_equal(mine[c].ravel().astype(np.float64), np.array(plain.channels[c], np.float64), equal_nan=True)]
        check(f"a picture, {name}: as the plain reader has it",
              wrong + ([] if sorted(mine) == sorted(plain.channels) else [f"channels {sorted(mine)}"]))
        check(f"a picture, {name}: kinds", mine["R"].dtype == kind
              and all(mine[c].dtype == np.uint32 for c in mine if c.endswith("Id")))
    run("study", "one.gltf", "--orders", "0,1", "--subdivide", "0,1", "-o", "t.csv", "--json", "t.json")
    table, rows = hprad_reader.study(path("t.csv")), hprad_reader.report(path("t.json"))["rows"]
    check("a study: as its JSON has it", [f"{key}: {row[key]} and {table[key][i]}" for i, row in enumerate(rows) for key in row
                                          if table[key][i] != row[key] and not (row[key] is None and math.isnan(table[key][i]))])
    check("a study: text stays text", table["method"].tolist() == ["galerkin"] * 4 and table["p"].dtype == np.float64)
    check("what is no solution or picture is refused by name", refused(hprad_reader.solution, path("plain.exr"))
          and refused(hprad_reader.picture, path("s.glb")))


def notebook_problems(path):
    with open(path, encoding="utf-8") as file:
        notebook = json.load(file)
    for i, cell in enumerate(notebook["cells"]):
        if cell["cell_type"] == "code" and (cell["outputs"] or cell["execution_count"] is not None):
            yield f"cell {i} has outputs"
        if cell["cell_type"] == "code":
            compile("".join(cell["source"]), f"{path}, cell {i}", "exec")


def main():
    with tempfile.TemporaryDirectory() as folder:
        check_reader(folder)
    folder = os.path.join(ROOT, "notebooks")
    names = sorted(name for name in os.listdir(folder) if name.endswith(".ipynb"))
    check("there are notebooks", len(names) > 0)
    for name in names:
        check(f"{name}: code that compiles, no outputs", notebook_problems(os.path.join(folder, name)))
    return done()


sys.exit(main())
