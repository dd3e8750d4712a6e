#!/usr/bin/env python3
"""Textures in a closed room, from outside: test_textures.py HPRAD. Energy, points, pictures against path tracing, and
what textures of one colour must not change."""
import base64
import csv
import json
import os
import struct
import sys
import tempfile
import zlib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import exr  # noqa: E402
import z_test  # noqa: E402
from cli_support import Command  # noqa: E402
from tap import check, done  # noqa: E402

# Inner sides of the unit cube: origin, edge along u, edge along v.
WALLS = [((0, 0, 0), (0, 0, 1), (1, 0, 0)), ((0, 1, 0), (1, 0, 0), (0, 0, 1)), ((0, 0, 0), (0, 1, 0), (0, 0, 1)),
         ((1, 0, 0), (0, 0, 1), (0, 1, 0)), ((0, 0, 0), (1, 0, 0), (0, 1, 0)), ((0, 0, 1), (0, 1, 0), (1, 0, 0))]
NEAREST, LINEAR, REPEAT, MIRROR = 9728, 9729, 10497, 33648
WHITE, DARK = (255, 255, 255), (90, 60, 0)


def png(rows):
    """A PNG of these rows of (r, g, b)."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    raw = b"".join(b"\0" + bytes(x for pixel in row for x in pixel) for row in rows)
    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")


def chequers(side, colours=(WHITE, DARK)):
    return [[colours[(x + y) % 2] for x in range(side)] for y in range(side)]


def uri(kind, data):
    return f"data:{kind};base64," + base64.b64encode(data).decode()


def linear(code):
    s = code / 255
    return s / 12.92 if s <= .04045 else ((s + .055) / 1.055) ** 2.4


def write_cube(path, picture, sampler=None, transform=None, factor=(1, 1, 1), lamp=False, triangles=False):
    """The cube from inside; every wall emits, or only the second, which is then black, without texture. `triangles`:
    coordinates that bend over each wall, so that its two triangles stay two."""
    data, views, accessors, meshes = b"", [], [], []
    for index, (o, e1, e2) in enumerate(WALLS):
        corners = [[o[k] + s * e1[k] + t * e2[k] for k in range(3)] for s, t in ((0, 0), (1, 0), (1, 1), (0, 1))]
        coordinates = [0, 0, 1, 0, 1, 1, 0, .75 if triangles else 1]
        for values, kind, width in ((sum(corners, []), "VEC3", 3), (coordinates, "VEC2", 2)):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": 4 * len(values)})
            accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": 4, "type": kind})
            if kind == "VEC3":
                accessors[-1].update(min=[min(c[k] for c in corners) for k in range(3)],
                                     max=[max(c[k] for c in corners) for k in range(3)])
            data += struct.pack(f"<{len(values)}f", *values)
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": 12})
        accessors.append({"bufferView": len(views) - 1, "componentType": 5123, "count": 6, "type": "SCALAR"})
        data += struct.pack("<6H", 0, 1, 2, 0, 2, 3)
        meshes.append({"primitives": [{"attributes": {"POSITION": 3 * index, "TEXCOORD_0": 3 * index + 1},
                                       "indices": 3 * index + 2, "material": int(lamp and index == 1)}]})
    use = {"index": 0, **({"extensions": {"KHR_texture_transform": transform}} if transform else {})}
    painted = {"baseColorFactor": [*factor, 1], "metallicFactor": 0}
    if picture:
        painted["baseColorTexture"] = use
    scene = {
        "asset": {"version": "2.0"}, "scene": 0, "extensionsUsed": ["KHR_texture_transform"],
        "scenes": [{"nodes": list(range(7))}],
        "nodes": [{"mesh": i} for i in range(6)] + [{"camera": 0, "translation": [.55, .5, .97]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.5, "znear": .01, "aspectRatio": 1}}],
        "meshes": meshes,
        "materials": [{"pbrMetallicRoughness": painted, "emissiveFactor": [0, 0, 0] if lamp else [1, .5, .2]},
                      {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0},
                       "emissiveFactor": [1, 1, 1]}],
        "buffers": [{"byteLength": len(data), "uri": uri("application/octet-stream", data)}],
        "bufferViews": views, "accessors": accessors}
    if picture:
        scene.update(textures=[{"source": 0, "sampler": 0}], samplers=[sampler or {"magFilter": NEAREST}],
                     images=[{"uri": uri("image/png", png(picture))}])
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)


def run(command, *arguments):
    result = command(*arguments, "--quiet")
    if result.returncode:
        check(f"hprad {' '.join(arguments)}: {result.stderr}", False)
    return result


def imbalance(command):
    with open(os.path.join(command.folder, "r.json"), encoding="utf-8") as file:
        energy = json.load(file)["energy"]
    return max(abs(e["relative"]) for e in energy)


CASES = {
    "nearest": {"picture": chequers(4)},
    "bilinear, turned": {"picture": chequers(3), "sampler": {"magFilter": LINEAR, "wrapS": MIRROR, "wrapT": REPEAT},
                         "transform": {"rotation": .4, "scale": [1.3, .8], "offset": [.1, .2]}},
    "triangles, one lamp": {"picture": chequers(5), "triangles": True, "lamp": True},
    "many texels": {"picture": chequers(96), "factor": (.9, .8, .7)},
}


def check_case(command, name, cube):
    """Energy to 1e-6, as the issue asks: B is what the mass blocks make of H, however exact they are. The picture to
    path tracing: 0.7% per block, and blocks of 16 x 16 pixels cross texels of every case."""
    write_cube(os.path.join(command.folder, "cube.gltf"), **cube)
    run(command, "solve", "cube.gltf", "-o", "s.glb", "--order", "2", "--subdivide", "2", "--report", "r.json")
    off = imbalance(command)
    check(f"{name}: energy balances ({off:.1e})", off < 1e-6)
    run(command, "render", "s.glb", "-o", "s.exr", "--size", "64x64", "--samples", "64")
    run(command, "reference", "cube.gltf", "-o", "t.exr", "--size", "64x64", "--samples", "48")
    traced, picture = (exr.read(os.path.join(command.folder, f)) for f in ("t.exr", "s.exr"))
    verdict = z_test.compare(traced, picture, .007)
    print(f"# {name}: |z| <= {abs(verdict.worst.z):.2f}, limit {verdict.limit:.2f}; standard error of a block "
          f"{max(verdict.error):.3%}; picture / reference {', '.join(f'{x:.5f}' for x in verdict.mean_ratio)}")
    check(f"{name}: agrees with path tracing", verdict.problems)


def solved(command, **cube):
    """The points that probe gives, as text, and the energy terms."""
    write_cube(os.path.join(command.folder, "cube.gltf"), lamp=True, **cube)
    run(command, "solve", "cube.gltf", "-o", "s.glb", "--order", "2", "--subdivide", "1", "--report", "r.json")
    with open(os.path.join(command.folder, "points.csv"), "w", encoding="utf-8") as file:
        file.write("x,y,z,nx,ny,nz\n")
        for x in (.1, .3, .6, .9):  # on the floor, in row 0 of four; u runs along z, v along x
            file.write(f".1,0,{x},0,1,0\n")
    points = run(command, "probe", "s.glb", "points.csv").stdout
    with open(os.path.join(command.folder, "r.json"), encoding="utf-8") as file:
        return points, json.load(file)["energy"]


def check_one_colour(command):
    """255 is 1, so a white picture is no picture; and a grey one is its colour as a factor."""
    plain = solved(command, picture=None, factor=(.5, .25, 1))
    check("a white texture changes no number", solved(command, picture=[[WHITE] * 3] * 2, factor=(.5, .25, 1)) == plain)
    grey = linear(100)
    check("a texture of one colour changes no number",
          solved(command, picture=[[(100, 100, 100)] * 3] * 2) == solved(command, picture=None, factor=(grey,) * 3))


def check_points(command):
    """B = rho(x) H on surfaces that do not emit, to the rounding of float32 texels."""
    points, _ = solved(command, picture=chequers(4))
    off = 0
    for i, row in enumerate(csv.DictReader(points.splitlines())):
        for channel, name in enumerate("rgb"):
            rho = linear((WHITE, DARK)[i % 2][channel])
            off = max(off, abs(float(row["radiosity_" + name]) / float(row["irradiance_" + name]) - rho))
    check(f"points show their texel ({off:.1e})", off <= 2 ** -24)


def main():
    with tempfile.TemporaryDirectory() as folder:
        command = Command(sys.argv[1], folder)
        for name, cube in CASES.items():
            check_case(command, name, cube)
        check_one_colour(command)
        check_points(command)
    return done()


sys.exit(main())
