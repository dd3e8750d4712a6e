#!/usr/bin/env python3
"""Views and pictures through the command: test_pictures_cli.py HPRAD. Orbits, windows, filters, layers, kinds of EXR,
false colours, comparison."""
import json
import math
import os
import struct
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import exr  # noqa: E402
from cli_support import Command, problems, write_scene  # noqa: E402
from tap import check, done  # noqa: E402

COARSE = ("--order", "1", "--subdivide", "1", "--quiet")
SIZE = ("--size", "24x20", "--samples", "5")
LAYERS = "irradiance,direct,indirect,emission,albedo,N,P,Z,degree,patchId,elementId"
NONE = 0xffffffff


class Pictures:
    def __init__(self, command):
        self.command = command

    def __call__(self, name, *arguments, solution="one.glb", size=SIZE, code=0):
        """The bytes of the EXR, and what was said."""
        result = self.command("render", solution, *size, "-o", name, *arguments)
        check(f"render {solution} {' '.join(arguments)}", problems(result, code))
        return result.stdout

    def bytes(self, name):
        with open(os.path.join(self.command.folder, name), "rb") as file:
            return file.read()

    def read(self, name):
        return exr.read(os.path.join(self.command.folder, name))


def check_orbit(pictures):
    pictures("turn/{frame:04}.exr", "--orbit", "7", "--report", "r.json")
    names = pictures.command.listing("turn")
    check("an orbit gives its pictures", names == [f"{i:04}.exr" for i in range(7)])
    pictures("alone.exr", "--orbit", "7", "--frames", "5", "--threads", "1")
    check("a picture of an orbit is the same alone", pictures.bytes("alone.exr") == pictures.bytes("turn/0005.exr"))
    pictures("plain.exr")
    check("an orbit begins at the camera", pictures.bytes("plain.exr") == pictures.bytes("turn/0000.exr"))
    check("no two views are the same", len({pictures.bytes("turn/" + name) for name in names}) == 7)
    with open(os.path.join(pictures.command.folder, "r.json"), encoding="utf-8") as file:
        stages = [stage["name"] for stage in json.load(file)["stages"]]
    check("a report of views has no stage of solving", stages == ["read", "render", "write"])
    # The camera is at (0, 2, 0) and looks straight down, up is -z; the floor ends at +-0.5. Turned about x = 0.25 by
    # 90 degrees, counter-clockwise from above, it stands over (0.25, 0.25), up is -x, so that 0.75 of the floor is
    # up and to the right of the middle and 0.25 down and to the left: at this size 7 and 2 pixels.
    square = ("--size", "16x16", "--samples", "4")
    pictures("c{frame}.exr", "--orbit", "4", "--orbit-centre", "0.25,0,0", "--frames", "1-2", size=square)
    covered = pictures.read("c1.exr").channels["A"]
    check("a quarter turn, counter-clockwise from above",
          [covered[16 * row + column] for row, column in ((8, 4), (8, 14), (1, 8), (12, 8))] == [0, 1, 1, 0])
    row = pictures.read("c2.exr").channels["A"][16 * 8:16 * 9]
    check("half a turn", row[6] == 0 and row[9] == 1)


def check_cameras(pictures):
    write_scene(os.path.join(pictures.command.folder, "eyes.gltf"), cameras=("left", "right"))
    pictures("e_{camera}.exr", "--camera-file", "eyes.gltf")
    pictures("plain.exr")
    wrong = [name for name in ("e_left.exr", "e_right.exr")
             if pictures.read(name).channels != pictures.read("plain.exr").channels]
    check("cameras of a file take the place of the scene's", wrong)
    check("the EXR names them", pictures.read("e_right.exr").attributes["camera"] == b"right")
    pictures("f{frame}.exr", "--camera-file", "eyes.gltf", "--frames", "1")
    check("--frames chooses among cameras", pictures.bytes("f1.exr") == pictures.bytes("e_right.exr"))


def check_window(pictures):
    for filter_options in ((), ("--filter", "gaussian")):
        pictures("whole.exr", *filter_options, "--aov", LAYERS)
        pictures("part.exr", *filter_options, "--aov", LAYERS, "--crop", "5,7,16,19")
        whole, part = pictures.read("whole.exr"), pictures.read("part.exr")
        check("a window knows its place", part.window == (5, 7, 15, 18) and part.display == whole.window)
        wrong = [name for name, values in part.channels.items() for y in range(12)
                 if values[11 * y:11 * y + 11] != whole.channels[name][24 * (7 + y) + 5:24 * (7 + y) + 16]]
        check("a window has the pixels of the whole", wrong)


def check_filter(pictures):
    """Where all is even the filter makes no difference; across an edge a wide one takes more."""
    pictures("box.exr", "--samples", "64")
    pictures("same.exr", "--samples", "64", "--filter", "box", "--filter-width", "1")
    check("the box is one pixel wide by default", pictures.bytes("box.exr") == pictures.bytes("same.exr"))
    box = pictures.read("box.exr").channels["A"]
    partly = {}
    for name, options in {"gaussian": ("--filter", "gaussian"), "wide": ("--filter-width", "3")}.items():
        pictures("soft.exr", "--samples", "64", *options)
        soft = pictures.read("soft.exr").channels["A"]
        partly[name] = sum(0 < a < 1 for a in soft)
        light = abs(sum(soft) - sum(box)) / sum(box)
        check(f"{name}: coverage is kept", [] if light < 1e-2 else [f"off by {light:.3}"])
    check("a wide filter softens edges, the Gaussian less than a box as wide",
          sum(0 < a < 1 for a in box) < partly["gaussian"] <= partly["wide"])


def check_layers(pictures):
    pictures("all.exr", "--aov", LAYERS)
    pictures("plain.exr")
    picture, plain = pictures.read("all.exr"), pictures.read("plain.exr")
    c = picture.channels
    check("layers change no other channel", [name for name in "RGBA" if c[name] != plain.channels[name]])
    wrong, parts, places = [], [], []
    for i, covered in enumerate(c["A"]):
        for k in "RGB":
            one_surface = covered == 0 or (covered == 1 and c["emission." + k][i] in (0, c[k][i]))
            light = c["emission." + k][i] + c["albedo." + k][i] * c["irradiance." + k][i] / math.pi
            if one_surface and abs(light - c[k][i]) > 1e-6 * (1 + c[k][i]):
                wrong.append(f"pixel {i} {k}: {c[k][i]}, its layers make {light}")
            if abs(c["direct." + k][i] + c["indirect." + k][i] - c["irradiance." + k][i]) > 1e-6:
                parts.append(f"pixel {i} {k}")
        x, y, z = (c["P." + axis][i] for axis in "XYZ")
        normal = tuple(c["N." + axis][i] for axis in "XYZ")
        column, row = i % 24, i // 24
        if c["patchId"][i] == NONE:
            if c["elementId"][i] != NONE or c["Z"][i] != math.inf or normal != (0, 0, 0):
                places.append(f"pixel {i} shows nothing but {c['elementId'][i]}, {c['Z'][i]}, {normal}")
            continue
        half = math.tan(.4) * c["Z"][i]  # the camera is at (0, 2, 0), looks down, up is -z, yfov 0.8
        if abs(2 - y - c["Z"][i]) > 1e-6 or abs(x - half * (2 * (column + .5) - 24) / 20) > 1e-6 \
                or abs(z - half * (2 * (row + .5) - 20) / 20) > 1e-6:
            places.append(f"pixel {i}: P = {x, y, z}, Z = {c['Z'][i]}")
        if normal != (0, 1, 0) or c["degree"][i] != 1 or c["elementId"][i] >= 8:
            places.append(f"pixel {i}: N = {normal}, degree {c['degree'][i]}, element {c['elementId'][i]}")
    check("radiance = emission + albedo irradiance / pi", wrong)
    check("irradiance = direct + indirect", parts)
    check("there is direct light", max(c["direct.R"]) > .1)
    check("N, P, Z, degree and numbers are of the pixel's centre", places)
    check("patches and elements are told apart", len(set(c["patchId"])) > 1 and len(set(c["elementId"])) > 4)
    pictures.command("solve", "one.gltf", *COARSE, "--direct", "galerkin", "-o", "through.glb")
    result = pictures.command("render", "through.glb", "-o", "x.exr", "--aov", "direct")
    check("no direct light where it went through the basis", problems(result, 3, ["direct and indirect", "galerkin"]))


def leaf_errors(path):
    """sqrt(area) and error of each leaf element of a solution file."""
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<I", data, 12)[0]
    root = json.loads(data[20:20 + length])
    extension = root["extensions"]["HPRAD_radiosity"]

    def column(group, key, code):
        array = extension[group][key]
        place = 28 + length + root["bufferViews"][array["bufferView"]].get("byteOffset", 0)
        return struct.unpack_from(f"<{array['count']}{code}", data, place)

    area = column("elements", "area", "d")
    return [(math.sqrt(area[node]), error) for node, error in
            zip(column("solution", "leaf", "I"), column("solution", "error", "d"))]


def check_error(pictures):
    """The layer `error`: what the solution says of each element, as a root mean square over its area."""
    grey = {"baseColorFactor": [.5, .5, .5, 1], "metallicFactor": 0}
    write_scene(os.path.join(pictures.command.folder, "grey.gltf"), materials=[
        {"pbrMetallicRoughness": grey}, {"pbrMetallicRoughness": grey, "emissiveFactor": [1, 1, .5]}])
    solved = pictures.command("solve", "grey.gltf", "--tol", "1e-3", "--refine", "h", "--order", "2", "-o", "tol.glb",
                              "--report", "tol.json", "--quiet")
    check("a solution with an estimate", problems(solved, 0))
    pictures("e.exr", "--aov", "error,elementId", solution="tol.glb")
    c = pictures.read("e.exr").channels
    leaves = leaf_errors(os.path.join(pictures.command.folder, "tol.glb"))
    expected = [0 if i == NONE else leaves[i][1] / leaves[i][0] for i in c["elementId"]]
    check("error is the element's estimate over the root of its area, 0 where nothing is",
          [f"pixel {i}: {got}, expected {want}" for i, (got, want) in enumerate(zip(c["error"], expected))
           if abs(got - want) > 2 ** -24 * want])
    check("elements differ in it", len(set(c["error"])) > 3 and NONE in c["elementId"])
    # The squares add up to that of the whole: discretisation * |H| of the worst channel; |H| <= max H sqrt(area).
    with open(os.path.join(pictures.command.folder, "tol.json"), encoding="utf-8") as file:
        report = json.load(file)
    pictures("h.exr", "--aov", "irradiance", solution="tol.glb")
    brightest = max(pictures.read("h.exr").channels["irradiance.R"])
    total = math.sqrt(sum(error * error for _, error in leaves))
    most = brightest * math.sqrt(sum(side * side for side, _ in leaves))
    part = report["error_parts"]["discretisation"]
    check("the whole is as large as the report says", 0 < total <= part * most or [f"{total} > {part} * {most}"])
    pictures.command("solve", "one.gltf", "--method", "exact", "-o", "exact.glb", "--quiet")
    result = pictures.command("render", "exact.glb", "-o", "x.exr", "--aov", "error")
    check("no layer error without an estimate", problems(result, 3, ["one.gltf", "no estimate"]))


def check_kinds(pictures):
    pictures("float.exr", "--aov", LAYERS, "--size", "150x70")
    whole = pictures.read("float.exr")
    for options in (("--tiled",), ("--half",), ("--half", "--tiled")):
        pictures("other.exr", "--aov", LAYERS, "--size", "150x70", *options)
        other = pictures.read("other.exr")
        exact = set(whole.channels) if "--half" not in options else {"P.X", "P.Y", "P.Z", "Z", "patchId", "elementId"}
        wrong = [name for name in exact if other.channels[name] != whole.channels[name]]
        wrong += [name for name in set(whole.channels) - exact
                  for a, b in zip(other.channels[name], whole.channels[name]) if abs(a - b) > 2 ** -11 * abs(b) + 2 ** -25]
        check(f"{' '.join(options)} holds the same", wrong)
        check(f"{' '.join(options)}: the file says so", ("tiles" in other.attributes) == ("--tiled" in options))
    check("attributes", [name for name, value in {"colorInteropID": b"lin_rec709_scene", "scene": b"one.gltf",
                                                  "camera": b"camera"}.items() if whole.attributes.get(name) != value]
          + [name for name in ("chromaticities", "software") if name not in whole.attributes])


def check_false_colour(pictures):
    said = pictures("f.exr", "--false-colour", "auto", "--png")
    check("the legend's top is stated", "irradiance 0 to " in said)
    size = pictures.bytes("f_irradiance.png")[16:24]
    check("the legend is beside the picture", int.from_bytes(size[:4], "big") > 24)
    auto = pictures.bytes("f_irradiance.png")
    top = said.split("irradiance 0 to ")[1].split()[0]
    pictures("f.exr", "--false-colour", top)
    check("the same top, the same picture", pictures.bytes("f_irradiance.png") == auto)
    pictures("f.exr", "--false-colour", "1e3")
    check("another top, another picture", pictures.bytes("f_irradiance.png") != auto)


def check_compare(pictures):
    pictures("ref.exr", "--samples", "1")
    said = pictures("new.exr", "--samples", "64", "--compare", "ref.exr", size=())
    new, ref, difference = (pictures.read(name) for name in ("new.exr", "ref.exr", "new_difference.exr"))
    check("the size is that of the reference", (new.width, new.height) == (24, 20))
    pairs = [(x, r) for k in "RGB" for x, r in zip(new.channels[k], ref.channels[k])]
    rmse = math.sqrt(sum((x - r) ** 2 for x, r in pairs) / len(pairs))
    relative = sum((x - r) ** 2 / (r * r + .01) for x, r in pairs) / len(pairs)
    psnr = 20 * math.log10(max(r for _, r in pairs) / rmse)
    numbers = [float(said.split(word)[1].strip().split(" ")[0].strip(",)")) for word in ("RMSE", "relMSE", "PSNR")]
    check("RMSE, relMSE and PSNR", [f"{got}, expected {want}" for got, want in zip(numbers, (rmse, relative, psnr))
                                    if abs(got - want) > 1e-3 * want])
    check("the difference picture", [k for k in "RGB" for x, r, d in
                                     zip(new.channels[k], ref.channels[k], difference.channels[k]) if abs(x - r - d) > 1e-7])
    said = pictures("again.exr", "--samples", "64", "--crop", "2,3,9,8", "--compare", "new.exr", size=())
    check("a window is compared with its place in the reference", "RMSE 0," in said and "PSNR inf" in said)
    result = pictures.command("render", "one.glb", "-o", "x.exr", "--size", "24x21", "--compare", "ref.exr")
    check("pictures of different sizes are not compared", problems(result, 2, ["24 x 21", "24 x 20"]))


def main():
    with tempfile.TemporaryDirectory() as folder:
        command = Command(sys.argv[1], folder)
        write_scene(os.path.join(folder, "one.gltf"))
        os.mkdir(os.path.join(folder, "turn"))
        check("a solution to look at", problems(command("solve", "one.gltf", *COARSE, "-o", "one.glb"), 0))
        pictures = Pictures(command)
        for part in (check_orbit, check_cameras, check_window, check_filter, check_layers, check_error, check_kinds,
                     check_false_colour, check_compare):
            part(pictures)
    return done()


sys.exit(main())
