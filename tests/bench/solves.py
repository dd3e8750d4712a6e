"""Solves to a tolerance; the error is the report's own estimate, which convergence_tolerance holds to the truth."""
from measure import Row

# scene, options, aim in CPU seconds, seconds (by the clock, on a busy machine) after which a run is given up
CASES = (("cornell_box", ("--tol", "1e-1"), None, 300), ("cornell_box", ("--tol", "1e-2"), 0.7, 300),
         ("cornell_box", ("--tol", "1e-3"), 10, 60), ("cornell_box", (), None, 60),
         ("furnished_room", ("--tol", "1e-2"), 10, 60))


def solve(bench, scene, options, aim, limit):
    name = f"{scene} {' '.join(options) or 'as by default'}"
    if options:
        options = (*options, "--max-time", str(limit))
    seconds, code = bench.run("solve", bench.scene(scene), "-o", "s.glb", "--report", "s.json", *options,
                                      allowed=(0, 4))
    report = bench.report("s.json")
    counters = {"coefficients": report["counts"]["dofs"], "kernels": report["counters"]["kernel_evaluations"],
                "rays": report["counters"]["rays"], "clips": report["counters"]["clips"]}
    return Row(name, seconds, report["error_estimate"], report["peak_memory_bytes"], counters, aim,
               f"given up after {limit} s" if code == 4 else "")


def rows(bench):
    for case in CASES:
        yield solve(bench, *case)
