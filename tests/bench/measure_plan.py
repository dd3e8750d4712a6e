#!/usr/bin/env python3
"""What `hprad plan --measure` predicts and measures on the bundled scenes, the README's table:

    measure_plan.py HPRAD SCENES [SECONDS [SCENE ...]]

One Markdown row per solve that is measured: coefficients, memory and CPU seconds, predicted over measured.
"""
import json
import os
import subprocess
import sys
import tempfile

SCENES = ["parallel_plates", "parallel_plates_0.25", "parallel_plates_0.1", "l_corner", "furnace_cube", "furnace_box",
          "cube_mixed", "blocked_plates", "cornell_box"]


def rows_of(hprad, scenes, name, seconds, folder):
    report = os.path.join(folder, "plan.json")
    subprocess.run([hprad, "plan", os.path.join(scenes, name + ".gltf"), "--measure", "--max-time", seconds, "--quiet",
                    "--report", report], check=True)
    with open(report, encoding="utf-8") as file:
        return json.load(file)["solves"]


def main():
    hprad, scenes, *rest = sys.argv[1:]
    seconds, names = rest[0] if rest else "15", rest[1:] or SCENES
    print("| scene | `--tol` | coefficients | memory, MB | CPU seconds | predicted / measured |")
    print("| --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            for row in rows_of(hprad, scenes, name, seconds, folder):
                measured, predicted = row["measured"], row["predicted"]
                if measured:
                    ratios = ", ".join(f"{predicted[key] / measured[key]:.2f}" for key in ("dofs", "memory_bytes", "cpu_seconds"))
                    print(f"| `{name}` | {row['tolerance'] or 'default'} | {measured['dofs']:.0f} "
                          f"| {measured['memory_bytes'] / 1e6:.0f} | {measured['cpu_seconds']:.2f} | {ratios} |", flush=True)


if __name__ == "__main__":
    main()
