#!/usr/bin/env python3
"""Asks for tolerances and measures what comes: coefficients, true and estimated error, CPU seconds.

    measure_tolerance.py HPRAD SCENE.gltf... [--tol 1e-1,1e-2,1e-3] [--truth 1e-4]
                         [--variants plain,turned,scaled,shifted,rho0.5,rho0.9]

True errors are against a solution of --truth (as of `hprad study`). A run is good if the estimate is 0.7 to 10 times
the true error and that lies between a thirtieth of the tolerance and the tolerance. Exit code 1 if one is not."""
import argparse
import csv
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import vary_scene

VARIANTS = {"plain": {}, "turned": {"degrees": 37}, "scaled": {"scale": 1000}, "shifted": {"shift": 1},
            "rho0.5": {"reflectance": .5}, "rho0.9": {"reflectance": .9}}


def measure(command, scene, tolerances, truth, folder):
    table = os.path.join(folder, "study.csv")
    subprocess.run([command, "study", scene, "--orders", "0", "--subdivide", "0", "--tol", tolerances, "--truth", truth,
                    "--threads", "1", "--quiet", "-o", table], check=True)
    with open(table, encoding="utf-8", newline="") as file:
        return [row for row in csv.DictReader(file) if row["tolerance"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--tol", default="1e-1,1e-2,1e-3")
    parser.add_argument("--truth", default="1e-4")
    parser.add_argument("--variants", default="plain")
    a = parser.parse_args()
    bad = 0
    print("| scene | variant | tolerance | coefficients | error | estimate / error | tolerance / error | CPU seconds |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for scene in a.scenes:
            for variant in a.variants.split(","):
                name = os.path.splitext(os.path.basename(scene))[0]
                varied = os.path.join(folder, f"{name}_{variant}.gltf")
                vary_scene.vary(scene, varied, **VARIANTS[variant])
                for row in measure(a.command, varied, a.tol, a.truth, folder):
                    error, estimate, tolerance = (float(row[k]) for k in ("error_l2", "error_estimate", "tolerance"))
                    good = 0.7 <= estimate / error <= 10 and tolerance / 30 <= error <= tolerance
                    bad += not good
                    print(f"| {name} | {variant} | {tolerance:.0e} | {row['dofs']} | {error:.1e} | {estimate / error:.2f} "
                          f"| {tolerance / error:.1f} | {float(row['cpu_seconds']):.2f} |{'' if good else ' BAD'}", flush=True)
    print(f"{bad} runs are not as they should be" if bad else "all runs are as they should be", file=sys.stderr)
    return bad > 0


if __name__ == "__main__":
    sys.exit(main())
