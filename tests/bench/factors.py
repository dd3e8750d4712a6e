"""View factors of many squares, as the command writes them."""
import array
import os
import random
import struct
import sys

from measure import Row

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from rectangle_digits import view_factor  # noqa: E402

CUBE = ((0, 0, 0), (1, 1, 1))
BOX = ((.3, .25, .2), (.4, .4, .55))
ENTRIES = 200


def uniform(cells):
    return [i / cells for i in range(cells + 1)]


def uneven(cells):
    """Steps between 1 and 1.5 in no order."""
    ends = [0.0]
    for i in range(cells):
        ends.append(ends[-1] + 1 + 0.5 * (7 * i % cells) / cells)
    return [end / ends[-1] for end in ends]


def squares(corner, size, ends, inside):
    """Each square of the faces of a box as four points, counter-clockwise from its front."""
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for far in (0, 1):
            for j, i in ((j, i) for j in range(len(ends) - 1) for i in range(len(ends) - 1)):
                square = []
                for turn in range(4):
                    c = turn if (far == 0) == inside else 3 - turn
                    point = list(corner)
                    point[axis] += far * size[axis]
                    point[a] += ends[i + (c in (1, 2))] * size[a]
                    point[b] += ends[j + (c >= 2)] * size[b]
                    square.append(tuple(point))
                yield square


def write_model(path, surfaces):
    vertices = {point: i + 1 for i, point in enumerate(dict.fromkeys(p for square in surfaces for p in square))}
    with open(path, "w", encoding="ascii") as file:
        file.write("T squares\nC encl=1\nF 3\n")
        for point, i in vertices.items():
            file.write("V {} {:.17g} {:.17g} {:.17g}\n".format(i, *point))
        for i, square in enumerate(surfaces):
            file.write("S {} {} {} {} {} 0 0 0.5 s{}\n".format(i + 1, *(vertices[p] for p in square), i))
        file.write("E\n")


def bounds(square):
    return tuple(min(p[k] for p in square) for k in range(3)), tuple(max(p[k] for p in square) for k in range(3))


class Matrix:
    """A square matrix in an .npy file, row by row from there: 24,576 squares make 5 GB."""

    def __init__(self, path, count):
        self.file, self.count = open(path, "rb"), count
        self.start = 10 + struct.unpack("<8xH", self.file.read(10))[0]

    def row(self, i):
        self.file.seek(self.start + 8 * i * self.count)
        return array.array("d", self.file.read(8 * self.count))

    def entry(self, i, j):
        self.file.seek(self.start + 8 * (i * self.count + j))
        return struct.unpack("<d", self.file.read(8))[0]


def error_of_entries(matrix, surfaces):
    """The largest relative error of random entries, against closed forms; those within a face are 0."""
    numbers, worst, flat = random.Random(1), 0.0, 0
    for _ in range(ENTRIES):
        i, j = numbers.randrange(len(surfaces)), numbers.randrange(len(surfaces))
        if i * 6 // len(surfaces) == j * 6 // len(surfaces):
            flat = max(flat, abs(matrix.entry(i, j)))
            continue
        exact = view_factor(bounds(surfaces[i]), bounds(surfaces[j]))
        worst = max(worst, abs(matrix.entry(i, j) / float(exact) - 1))
    return worst if flat == 0 else 1.0


def difference(matrix, exact):
    """The largest of an entry, relative to the largest entry."""
    off = largest = 0.0
    for i in range(exact.count):
        row, truth = matrix.row(i), exact.row(i)
        off = max(off, max(abs(a - b) for a, b in zip(row, truth)))
        largest = max(largest, max(truth))
    return off / largest


def measured(bench, name, surfaces, tolerance, aim):
    write_model(bench.path("model.vs3"), surfaces)
    seconds, _ = bench.run("formfactors", "model.vs3", "--tol", tolerance, "-o", "f.npy", "--report", "f.json")
    report = bench.report("f.json")
    counters = {"pairs": report["counts"]["pairs"], "kernels": report["counters"]["kernel_evaluations"],
                "clips": report["counters"]["clips"]}
    return Row(f"{name}, {len(surfaces)} squares, {tolerance}", seconds, None, report["peak_memory_bytes"], counters, aim,
               f"rows off by {report['closure']['defect']:.0e}")


def cube(bench, name, ends, aim=None):
    surfaces = list(squares(*CUBE, ends, True))
    row = measured(bench, name, surfaces, "1e-9", aim)
    row.error = error_of_entries(Matrix(bench.path("f.npy"), len(surfaces)), surfaces)
    return row


def box_in_cube(bench, cells, aim=None):
    """Errors are those of entries against a run with a hundredth of the tolerance, relative to the largest."""
    surfaces = [*squares(*CUBE, uniform(2 * cells), True), *squares(*BOX, uniform(cells), False)]
    row = measured(bench, "box in a cube", surfaces, "1e-6", aim)
    bench.once("formfactors", "model.vs3", "--tol", "1e-8", "-o", "exact.npy")
    row.error = difference(*(Matrix(bench.path(name), len(surfaces)) for name in ("f.npy", "exact.npy")))
    return row


def rows(bench):
    for cells in (4, 8, 16, 32, 64) if bench.large else (4, 8, 16, 32):
        yield cube(bench, "cube", uniform(cells), 4 if cells == 32 else None)
    yield cube(bench, "cube, uneven", uneven(32), 4)
    for cells in (4, 8):
        yield box_in_cube(bench, cells, 8 if cells == 8 else None)
