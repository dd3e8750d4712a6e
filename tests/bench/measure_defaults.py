#!/usr/bin/env python3
"""What order and subdivision cost and give on the Cornell box, the README's table:

    measure_defaults.py HPRAD SCENE FINE P,N,F [P,N,F ...]

FINE and P,N,F are order,subdivide,feet. Prints one Markdown row each: CPU seconds and memory of `hprad solve`, and the
irradiance's RMS difference from FINE, relative to its RMS, at 500 points spread over the surfaces by area (of the
channels, the worst).
"""
import csv
import json
import math
import os
import random
import struct
import subprocess
import sys
import tempfile

POINTS = 500


def settings_text(setting):
    return setting.replace(",", " --subdivide ", 1).replace(",", " --feet ")


def solve(hprad, scene, setting, target):
    order, subdivide, feet = setting.split(",")
    subprocess.run([hprad, "solve", scene, "--order", order, "--subdivide", subdivide, "--feet", feet, "--quiet",
                    "-o", target + ".glb", "--report", target + ".json"], check=True)
    with open(target + ".json", encoding="utf-8") as file:
        return json.load(file)


def read_patches(path):
    """(shape, origin, edge1, edge2, normal, area, opposite) of each patch of a solution."""
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<I", data, 12)[0]
    gltf = json.loads(data[20:20 + length])
    patches = gltf["extensions"]["HPRAD_radiosity"]["patches"]

    def items(key):
        array = patches.get(key)
        if array is None:  # opposite, of a solution without quadrilaterals
            return [(1, 1)] * patches["count"]
        start = 28 + length + gltf["bufferViews"][array["bufferView"]].get("byteOffset", 0)
        code = f"<{array['components']}{'B' if array['componentType'] == 'uint8' else 'd'}"
        return [struct.unpack_from(code, data, start + i * struct.calcsize(code)) for i in range(array["count"])]

    return list(zip(*(items(key) for key in ("shape", "origin", "edge1", "edge2", "normal", "area", "opposite"))))


def point_of(shape, opposite, u, v):
    """Parameters, uniform over the patch if (u,v) is over the unit square."""
    first, second = (1, 0), (0, 1)
    if shape == 2:  # one of the triangles beside the diagonal
        share = opposite[1] / sum(opposite)
        if u < share:
            u, second = u / share, opposite
        else:
            u, first = (u - share) / (1 - share), opposite
    if shape != 0 and u + v > 1:
        u, v = 1 - u, 1 - v
    return u * first[0] + v * second[0], u * first[1] + v * second[1]


def write_points(patches, path):
    numbers = random.Random(1)
    with open(path, "w", encoding="utf-8") as file:
        file.write("x,y,z,nx,ny,nz\n")
        for patch in numbers.choices(patches, weights=[patch[5][0] for patch in patches], k=POINTS):
            (shape,), origin, edge1, edge2, normal, _, opposite = patch
            s, t = point_of(shape, opposite, numbers.random(), numbers.random())
            point = [o + s * a + t * b for o, a, b in zip(origin, edge1, edge2)]
            file.write(",".join(f"{x:.17g}" for x in (*point, *normal)) + "\n")


def probe(hprad, target, points):
    result = subprocess.run([hprad, "probe", target + ".glb", points], stdout=subprocess.PIPE, check=True,
                            universal_newlines=True)
    rows = list(csv.DictReader(result.stdout.splitlines()))
    assert all(row["status"] == "ok" for row in rows)
    return [[float(row["irradiance_" + channel]) for row in rows] for channel in "rgb"]


def difference(values, fine):
    return max(math.sqrt(sum((a - b) ** 2 for a, b in zip(v, f)) / sum(b * b for b in f))
               for v, f in zip(values, fine))


def main():
    hprad, scene, fine_setting, *settings = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        target, points = os.path.join(folder, "x"), os.path.join(folder, "points.csv")
        solve(hprad, scene, "0,0,0", target)
        write_points(read_patches(target + ".glb"), points)
        solve(hprad, scene, fine_setting, target)
        fine = probe(hprad, target, points)
        for setting in settings:
            report = solve(hprad, scene, setting, target)
            rms = difference(probe(hprad, target, points), fine)
            print(f"| `--order {settings_text(setting)}` | {report['counts']['dofs']} "
                  f"| {report['cpu_seconds']:.1f} | {report['peak_memory_bytes'] / 1e6:.0f} | {100 * rms:.1f} % |",
                  flush=True)


if __name__ == "__main__":
    main()
