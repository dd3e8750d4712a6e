#!/usr/bin/env python3
"""How links, memory and time grow with the patches that a scene itself has, the README's table:

    measure_input_patches.py HPRAD N [N ...]

A closed room with N boxes on a grid on its floor, each of its own size: 6 + 5 N patches, one element each. Prints one
Markdown row each: patches, links, partly blocked among them, memory and CPU seconds of `hprad solve --order 0 --subdivide
0 --feet 0 --link-tol 1e-2 --block-tol 1e-2` with one thread, in all and of the assembly, the estimated error and the
energy balance. Exponents in patches follow.
"""
import base64
import json
import math
import os
import random
import struct
import subprocess
import sys
import tempfile


def box(low, high, inside):
    """Faces as four corners each, counter-clockwise from the side that is seen; of a box outside all but the bottom."""
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for far in (0, 1):
            if not inside and axis == 1 and far == 0:
                continue
            corners = []
            for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                point = [0, 0, 0]
                point[axis], point[a], point[b] = (low, high)[far][axis], (low, high)[u][a], (low, high)[v][b]
                corners.append(tuple(point))
            yield corners if (far == 1) != inside else corners[::-1]


def write_scene(path, boxes):
    numbers, side = random.Random(1), math.ceil(math.sqrt(boxes))
    meshes = [list(box((0, 0, 0), (side, 0.8 * side, side), True))]
    for i in range(boxes):
        x, z, width, height = i % side, i // side, 0.25 + 0.5 * numbers.random(), 0.2 + 1.5 * numbers.random()
        meshes.append(list(box((x + 0.5 - width / 2, 0, z + 0.5 - width / 2),
                               (x + 0.5 + width / 2, height, z + 0.5 + width / 2), False)))
    data, views, accessors, items = b"", [], [], []

    def add(values, code, kind, component, bounds):
        nonlocal data
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(values) * struct.calcsize(code)})
        accessors.append(dict({"bufferView": len(views) - 1, "componentType": component, "type": kind,
                               "count": len(values) // (3 if kind == "VEC3" else 1)}, **bounds))
        data += struct.pack(f"<{len(values)}{code}", *values)
        return len(accessors) - 1

    for m, mesh in enumerate(meshes):
        points = [p for face in mesh for p in face]
        bounds = {"min": [min(p[k] for p in points) for k in range(3)], "max": [max(p[k] for p in points) for k in range(3)]}
        for material in ((0, 1) if m == 0 else (0,)):  # the room's ceiling shines
            chosen = [f for f in range(len(mesh)) if (m == 0 and f == 3) == (material == 1)]
            indices = [4 * f + k for f in chosen for k in (0, 1, 2, 0, 2, 3)]
            items.append({"primitives": [{"attributes": {"POSITION": add([c for p in points for c in p], "f", "VEC3", 5126, bounds)},
                                          "indices": add(indices, "H", "SCALAR", 5123, {}), "material": material}]})
            data += b"\0" * (-len(data) % 4)
    scene = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(items)))}],
             "nodes": [{"mesh": i} for i in range(len(items))], "meshes": items, "accessors": accessors, "bufferViews": views,
             "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0}},
                           {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0},
                            "emissiveFactor": [1, 1, 1]}],
             "buffers": [{"byteLength": len(data),
                          "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]}
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)


def solve(hprad, scene, target):
    subprocess.run([hprad, "solve", scene, "--order", "0", "--subdivide", "0", "--feet", "0", "--link-tol", "1e-2",
                    "--block-tol", "1e-2", "--threads", "1", "--quiet", "-o", target + ".glb", "--report", target + ".json"],
                   check=True)
    with open(target + ".json", encoding="utf-8") as file:
        return json.load(file)


def assembly_seconds(report):
    return sum(stage["cpu_seconds"] for stage in report["stages"] if stage["name"] == "assembly")


def main():
    hprad, *sizes = sys.argv[1:]
    reports = []
    with tempfile.TemporaryDirectory() as folder:
        for boxes in map(int, sizes):
            scene = os.path.join(folder, "room.gltf")
            write_scene(scene, boxes)
            report = solve(hprad, scene, os.path.join(folder, "room"))
            reports.append(report)
            print(f"| {report['counts']['patches']} | {report['counts']['links']} | {report['counters']['pairs_partial']} "
                  f"| {report['peak_memory_bytes'] / 1e6:.0f} | {report['cpu_seconds']:.1f} | {assembly_seconds(report):.1f} "
                  f"| {report['error_estimate']:.1e} | {report['energy'][0]['relative']:.0e} |", flush=True)
    for before, after in zip(reports, reports[1:]):
        growth = math.log(after["counts"]["patches"] / before["counts"]["patches"])
        for name, value in (("links", lambda r: r["counts"]["links"]), ("memory", lambda r: r["peak_memory_bytes"]),
                            ("CPU seconds", lambda r: r["cpu_seconds"]), ("of the assembly", assembly_seconds)):
            print(f"to {after['counts']['patches']}: {name}: exponent {math.log(value(after) / value(before)) / growth:.2f}")


if __name__ == "__main__":
    main()
