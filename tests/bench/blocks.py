"""Kernel blocks, from build/tests/bench_blocks."""
import json
import os
import subprocess

from measure import Row

# CPU seconds that a case is to keep.
AIMS = {"on an edge, 5 to 150 degrees, degree 0, 1e-12": 50e-6, "on an edge, 5 to 150 degrees, degree 3, 1e-12": 2e-3,
        "4 sizes apart, degree 3, 1e-10": 4e-6}


def rows(bench):
    result = subprocess.run([os.path.join(bench.build, "tests", "bench_blocks")], stdout=subprocess.PIPE, check=True,
                            universal_newlines=True)
    for line in result.stdout.splitlines():
        it = json.loads(line)
        aim = next((seconds for name, seconds in AIMS.items() if it["case"].endswith(name)), None)
        speed = it["kernel_evaluations"] / it["cpu_seconds"]
        yield Row(it["case"], it["cpu_seconds"], it["error"], target_seconds=aim,
                  counters={"kernels": it["kernel_evaluations"], "kernels/s": speed})
