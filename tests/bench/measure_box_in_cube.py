#!/usr/bin/env python3
"""View factors of a box in a cube, every face in squares, the README's table:

    measure_box_in_cube.py HPRAD TOLERANCE EXACT M [M ...]

The unit cube's faces in 2M x 2M squares, those of a box of 0.4 x 0.4 x 0.55 in it in M x M: 30 M^2 surfaces. Prints one
Markdown row each: CPU seconds and memory of `hprad formfactors --tol TOLERANCE` with one thread, the row sum that is
farthest from 1, and the largest difference of an entry from a run with `--tol EXACT`, relative to the largest entry.
"""
import csv
import os
import subprocess
import sys
import tempfile

CUBE = ((0, 0, 0), (1, 1, 1))
BOX = ((.3, .25, .2), (.4, .4, .55))


def faces(corner, size, cells, inside):
    """Each square as four points, counter-clockwise from its front."""
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for far in (0, 1):
            for cell in range(cells * cells):
                square = []
                for turn in range(4):
                    c = turn if (far == 0) == inside else 3 - turn
                    point = list(corner)
                    point[axis] += far * size[axis]
                    point[a] += (cell % cells + (c in (1, 2))) / cells * size[a]
                    point[b] += (cell // cells + (c >= 2)) / cells * size[b]
                    square.append(tuple(point))
                yield square


def write_model(path, m):
    squares = [*faces(*CUBE, 2 * m, True), *faces(*BOX, m, False)]
    vertices = {point: i + 1 for i, point in enumerate(dict.fromkeys(p for square in squares for p in square))}
    with open(path, "w", encoding="ascii") as file:
        file.write("T box in a cube\nC encl=1\nF 3\n")
        for point, i in vertices.items():
            file.write("V {} {:.17g} {:.17g} {:.17g}\n".format(i, *point))
        for i, square in enumerate(squares):
            file.write("S {} {} {} {} {} 0 0 0.5 s{}\n".format(i + 1, *(vertices[p] for p in square), i))
        file.write("E\n")
    return len(squares)


def factors(hprad, model, tolerance, target):
    """(rows, CPU seconds, peak memory in bytes)"""
    process = subprocess.Popen([hprad, "formfactors", model, "--tol", tolerance, "--threads", "1", "--quiet", "-o", target])
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit("hprad formfactors failed")
    with open(target, encoding="ascii", newline="") as file:
        rows = [[float(x) for x in row] for row in csv.reader(file)]
    return rows, usage.ru_utime + usage.ru_stime, 1024 * usage.ru_maxrss


def main():
    hprad, tolerance, exact = sys.argv[1:4]
    for m in map(int, sys.argv[4:]):
        with tempfile.TemporaryDirectory() as folder:
            model = os.path.join(folder, "box.vs3")
            count = write_model(model, m)
            rows, seconds, memory = factors(hprad, model, tolerance, os.path.join(folder, "f.csv"))
            truth, _, _ = factors(hprad, model, exact, os.path.join(folder, "exact.csv"))
        row = max(abs(sum(row) - 1) for row in rows)
        entry = max(abs(a - b) for x, y in zip(rows, truth) for a, b in zip(x, y)) / max(map(max, truth))
        print(f"| {count} | {seconds:.2f} | {memory / 1e6:.0f} | {row:.1e} | {entry:.1e} |", flush=True)


main()
