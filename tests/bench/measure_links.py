#!/usr/bin/env python3
"""How links, memory and time grow with the elements, the README's table:

    measure_links.py HPRAD SCENE ORDER TOLERANCE COMPARED N [N ...]

Prints one Markdown row for each subdivision N: elements, links, memory, CPU seconds of `hprad solve --link-tol
TOLERANCE` with one thread, in all and of the operator (assembly and solver), and the irradiance's RMS difference from
`--link-tol TOLERANCE/100`, relative to its RMS, at 500 random points, up to COMPARED elements. Exponents of links and
CPU seconds in elements follow.
"""
import json
import math
import os
import subprocess
import sys
import tempfile

from measure_defaults import difference, probe, read_patches, write_points


def solve(hprad, scene, order, subdivide, tolerance, target):
    environment = dict(os.environ, OMP_NUM_THREADS="1")
    subprocess.run([hprad, "solve", scene, "--order", order, "--subdivide", subdivide, "--link-tol", f"{tolerance:g}",
                    "--quiet", "-o", target + ".glb", "--report", target + ".json"], check=True, env=environment,
                   stdout=subprocess.DEVNULL)
    with open(target + ".json", encoding="utf-8") as file:
        return json.load(file)


def operator_seconds(report):
    return sum(stage["cpu_seconds"] for stage in report["stages"] if stage["name"] in ("assembly", "solver"))


def exponent(first, last, value):
    return math.log(value(last) / value(first)) / math.log(last["counts"]["elements"] / first["counts"]["elements"])


def main():
    hprad, scene, order, tolerance, compared, *levels = sys.argv[1:]
    reports = []
    with tempfile.TemporaryDirectory() as folder:
        target, points = os.path.join(folder, "x"), os.path.join(folder, "points.csv")
        for subdivide in levels:
            report = solve(hprad, scene, order, subdivide, float(tolerance), target)
            reports.append(report)
            elements, error = report["counts"]["elements"], "-"
            if elements <= int(compared):
                write_points(read_patches(target + ".glb"), points)
                values = probe(hprad, target, points)
                solve(hprad, scene, order, subdivide, float(tolerance) / 100, target)
                error = f"{difference(values, probe(hprad, target, points)):.1e}"
            print(f"| {os.path.basename(scene)} | {elements} | {report['counts']['links']} "
                  f"| {report['peak_memory_bytes'] / 1e6:.0f} | {report['cpu_seconds']:.1f} "
                  f"| {operator_seconds(report):.1f} | {error} |", flush=True)
    for name, value in (("links", lambda r: r["counts"]["links"]), ("memory", lambda r: r["peak_memory_bytes"]),
                        ("CPU seconds", lambda r: r["cpu_seconds"]), ("of the operator", operator_seconds)):
        print(f"{name}: exponent {exponent(reports[0], reports[-1], value):.2f}, "
              f"at the end {exponent(reports[-2], reports[-1], value):.2f}")


if __name__ == "__main__":
    main()
