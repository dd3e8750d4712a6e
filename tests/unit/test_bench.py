#!/usr/bin/env python3
"""The benchmark's own parts, without a measurement: test_bench.py ROOT."""
import json
import os
import sys
import tempfile

ROOT = os.path.abspath(sys.argv[1])
for folder in ("support", "bench"):
    sys.path.insert(0, os.path.join(ROOT, "tests", folder))
import bench  # noqa: E402
import factors  # noqa: E402
from measure import Row  # noqa: E402
from rectangle_digits import exchange, view_factor  # noqa: E402
from tap import check, done  # noqa: E402

FLOOR, CEILING, WALL = ((0, 0, 0), (1, 1, 0)), ((0, 0, 1), (1, 1, 1)), ((0, 0, 0), (1, 0, 1))
ROWS = [Row("fast", 2e-6, 1e-12), Row("slow", 3.0, 1e-3, 5_000_000, {"rays": 12_000}, 2.0, "given up")]


def wrong(cases):
    for got, wanted, bound in cases:
        if not abs(got - wanted) <= bound:
            yield f"{got!r}, expected {wanted!r}"


def check_digits():
    """Howell C-11 and C-14; pieces sum to the whole, where a closed form in doubles has lost all its digits."""
    check("squares face to face and on an edge", wrong([(float(view_factor(FLOOR, CEILING)), 0.19982489569838738, 1e-17),
                                                        (float(view_factor(FLOOR, WALL)), 0.20004377607540316, 1e-17)]))
    ends = factors.uneven(3)
    pieces = [((a, c, 1), (b, d, 1)) for a, b in zip(ends, ends[1:]) for c, d in zip(ends, ends[1:])]
    check("pieces", wrong([(float(sum(exchange(FLOOR, piece) for piece in pieces) - exchange(FLOOR, CEILING)), 0, 1e-50)]))
    far = view_factor(((0, 0, 0), (1, 1, 0)), ((0, 0, 1e6), (1, 1, 1e6)))
    check("a million sizes apart", wrong([(float(far * 10 ** 12), 1 / 3.14159265358979, 1e-11)]))


def check_models():
    squares = list(factors.squares(*factors.CUBE, factors.uneven(4), True))
    check("squares of a cube", len(squares) == 96 and len({p for square in squares for p in square}) == 98)


def check_tables():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "before.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump({"areas": {"solve": [{"case": "slow", "cpu_seconds": 6.0}]}}, file)
        text = bench.table("solve", ROWS, bench.read_before(path)["solve"])
    check("a table", text.splitlines()[2:] == [
        "| fast | 2 us |  | 1.0e-12 |  |  | - |",
        "| slow (given up) | 3 s | 2 s | 0.001 | 5 | 12k rays | 0.50 |"] or [text])
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
        readme = file.read()
    for area in bench.AREAS:
        new = bench.replaced(readme, area, bench.table(area, ROWS, None))
        check(f"the README has a place for {area}", new.count("| slow (given up) |") == 1 and
              len(new.split("\n\n")) == len(readme.split("\n\n")))


check_digits()
check_models()
check_tables()
sys.exit(done())
