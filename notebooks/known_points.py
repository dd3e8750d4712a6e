#!/usr/bin/env python3
"""A table of irradiances to compare with: known_points.py SOL.glb COUNT OUT.csv. Takes a solution that is much finer than
what is to be compared with it, spreads COUNT points evenly over all its surfaces (as many on each as its area asks for)
and writes what `hprad probe` says there: to be given to `hprad study --points`. HPRAD is the command, else ../build/hprad."""
import csv
import os
import subprocess
import sys
import tempfile

import numpy as np

import hprad_reader as reader

COLUMNS = ["x", "y", "z", "nx", "ny", "nz", "irradiance_r", "irradiance_g", "irradiance_b"]


def inside(shape, opposite, s, t):
    """Is (s, t) in a parallelogram, a triangle, or the quadrilateral (0,0), (1,0), opposite, (0,1)?"""
    if shape == 0:
        return s <= 1 and t <= 1
    if shape == 1:
        return s + t <= 1
    a, b = opposite
    return (a - 1) * t - b * (s - 1) >= 0 and -a * (t - 1) + (b - 1) * s >= 0


def spread(patches, count):
    """Points and normals: of each patch those of a lattice (Roberts' R2) over the box about it that fall inside."""
    area, passed = patches["area"][:, 0], 0.0
    for i in range(len(area)):
        passed += area[i] / area.sum() * count
        wanted = round(passed) - round(passed - area[i] / area.sum() * count)
        shape, opposite = patches["shape"][i, 0], patches["opposite"][i] if "opposite" in patches else None
        box, k = np.maximum(1, opposite) if shape == 2 else np.ones(2), 0
        while wanted:
            k += 1
            s, t = box * ((0.5 + k * np.array([0.75487766624669276, 0.56984029099805327])) % 1)
            if inside(shape, opposite, s, t):
                yield [*(patches["origin"][i] + s * patches["edge1"][i] + t * patches["edge2"][i]), *patches["normal"][i]]
                wanted -= 1


def main(solution, count, out):
    patches = reader.solution(solution)["patches"]
    with tempfile.TemporaryDirectory() as folder:
        points, values = (os.path.join(folder, name) for name in ("points.csv", "values.csv"))
        with open(points, "w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(COLUMNS[:6])
            writer.writerows([f"{x:.9g}" for x in point] for point in spread(patches, int(count)))
        subprocess.run([os.environ.get("HPRAD", "../build/hprad"), "probe", solution, points, "-o", values, "--gather", "--quiet"], check=True)
        table = reader.study(values)
    with open(out, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for i in range(len(table["x"])):
            writer.writerow([f"{table[c][i]:.7g}" if c.startswith("irr") else f"{table[c][i]:.9g}" for c in COLUMNS])


if __name__ == "__main__":
    main(*sys.argv[1:])
