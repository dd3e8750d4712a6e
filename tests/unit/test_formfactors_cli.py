#!/usr/bin/env python3
"""hprad formfactors from outside: test_formfactors_cli.py HPRAD. Formats, tables, blocks, refusals, exit codes."""
import ast
import csv
import json
import math
import os
import stat
import struct
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from cli_support import Command, problems, write_scene  # noqa: E402
from tap import check, done  # noqa: E402

CUBE = [[0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0], [0, 0, 1, 0, 1, 1, 1, 1, 1, 1, 0, 1],
        [0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1], [1, 0, 0, 1, 0, 1, 1, 1, 1, 1, 1, 0],
        [0, 0, 0, 0, 0, 1, 1, 0, 1, 1, 0, 0], [0, 1, 0, 1, 1, 0, 1, 1, 1, 0, 1, 1]]
OPPOSITE, ADJACENT = 0.19982489569838738, 0.20004377607540316  # Howell C-11, C-14

# id, degree, recv and send as polygons, {(k, l): K_kl}: open.json of the reference cases, all digits of a double
MOMENTS = [
    ("mom_parallel_gap1", 3, [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0], [0, 0, 1, 0, 1, 1, 1, 1, 1, 1, 0, 1],
     {(0, 0): 0.19982489569838738, (0, 8): -0.016120521809799615, (1, 4): 0.040745887400465336,
      (4, 3): -0.0046007573153047359, (7, 13): 0.00051618388196833769, (15, 7): -8.8382373345200494e-05}),
    ("mom_edge_90deg", 3, [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0], [0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1],
     {(0, 0): 0.20004377607540316, (2, 9): -0.076098665821160955, (5, 14): 0.01104479929698653,
      (14, 11): 0.072478373607191018, (15, 5): -0.0016300965489245843}),
    ("mom_tri_general", 2, [0, 0, 0, 1, 0, 0, .25, 1.5, 0], [.5, .25, 1, .25, 1.25, 1.5, 1.5, .5, .75],
     {(0, 0): 0.10021865905296853, (0, 5): -0.0091335458655191371, (1, 4): -0.0040340029392878212,
      (5, 0): -0.015414038247021214, (5, 5): 0.0023123298049718358}),
    ("mom_tri_vertex", 2, [0, 0, 0, 1, 0, 0, 0, 1, 0], [0, 0, 0, -.25, 1, 1, 1, -.25, 1],
     {(0, 0): 0.20644585140771429, (1, 5): -0.052563414497215438, (4, 2): -0.015883153685355311}),
]


def vs3(polygons, control="", kinds=None, tail=None):
    """A .vs3 text of these polygons (flat lists of coordinates)."""
    lines, surfaces, count = [f"C {control}" if control else "", "F 3"], [], 0
    for i, flat in enumerate(polygons):
        ids = []
        for k in range(0, len(flat), 3):
            count += 1
            ids.append(count)
            lines.append(f"V {count} {flat[k]} {flat[k + 1]} {flat[k + 2]}")
        ids += [0] * (4 - len(ids))
        end = (tail or {}).get(i, "0 0 .5")
        surfaces.append(f"{(kinds or {}).get(i, 'S')} {i + 1} {' '.join(map(str, ids))} {end} s{i + 1}")
    return "\n".join(lines + surfaces) + "\n"


def read_npy(path):
    """(shape, flat tuple) of a little-endian float64 file of format 1.0."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == b"\x93NUMPY\x01\x00", data[:8]
    begin = 10 + struct.unpack("<H", data[8:10])[0]
    header = ast.literal_eval(data[10:begin].decode("ascii"))
    assert begin % 64 == 0 and data[begin - 1:begin] == b"\n"
    assert header["descr"] == "<f8" and header["fortran_order"] is False
    count = math.prod(header["shape"])
    assert len(data) == begin + 8 * count
    return header["shape"], struct.unpack(f"<{count}d", data[begin:])


def wrong_cube(rows):
    for i, row in enumerate(rows):
        for j, value in enumerate(row):
            expected = 0 if i == j else OPPOSITE if i // 2 == j // 2 else ADJACENT
            if not abs(value - expected) <= 1e-9 * expected:
                yield f"F[{i}][{j}] = {value!r}, expected {expected!r}"


def check_formats(hprad, folder):
    def path(name):
        return os.path.join(folder, name)
    with open(path("cube.vs3"), "w", encoding="ascii") as file:
        file.write(vs3(CUBE, "encl=1"))
    result = hprad("formfactors", "cube.vs3")
    check("a cube is done", problems(result, 0))
    check("what it will take is said first", result.stdout.startswith("surfaces  6\nmemory    "))
    shape, flat = read_npy(path("cube.npy"))
    check("npy is square", shape == (6, 6))
    check("npy holds the closed forms", wrong_cube([flat[6 * i:6 * i + 6] for i in range(6)]))
    with open(path("cube.surfaces.csv"), encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    check("the table has its columns", list(table[0]) == ["index", "name", "node", "primitive", "side", "area_m2",
                                                          "emissivity", "row_sum", "surroundings"])
    check("the table has its rows", [(r["index"], r["name"], r["node"], r["side"], float(r["area_m2"]),
                                      float(r["emissivity"])) for r in table]
          == [(str(i), f"s{i + 1}", "", "front", 1, .5) for i in range(6)])
    check("a closed model closes", all(abs(float(r["surroundings"])) < 2e-9 and
                                       float(r["surroundings"]) == 1 - float(r["row_sum"]) for r in table))
    check("csv", problems(hprad("formfactors", "cube.vs3", "-o", "c.csv", "--quiet"), 0, stdout=""))
    with open(path("c.csv"), encoding="ascii") as file:
        rows = [tuple(map(float, line.split(","))) for line in file]
    check("csv has the same bits as npy", [flat[6 * i:6 * i + 6] for i in range(6)] == rows)
    check("txt", problems(hprad("formfactors", "cube.vs3", "-o", "c.txt", "--quiet", "--threads", "1"), 0, stdout=""))
    with open(path("c.txt"), encoding="ascii") as file:
        lines = file.read().split("\n")
    check("txt has View3D's layout", lines[:2] == ["View3D 4.0.0 0 1 0 6", "1 1 1 1 1 1"] and
          lines[8:] == ["0.5 0.5 0.5 0.5 0.5 0.5", ""])
    check("txt has the same bits", [tuple(map(float, line.split())) for line in lines[2:8]] == rows)


def check_control(hprad, folder):
    def write(name, text):
        with open(os.path.join(folder, name), "w", encoding="ascii") as file:
            file.write(text)
    write("open.vs3", vs3(CUBE[:5], "encl=1 maxU=3"))
    check("an open model that says it is closed is warned about",
          problems(hprad("formfactors", "open.vs3", "--quiet"), 0,
                   ["without effect: maxU", "encl=1", "nothing was adjusted"], ""))
    write("emit.vs3", vs3(CUBE, "emit=1"))
    check("script-F", problems(hprad("formfactors", "emit.vs3", "-o", "e.csv", "--quiet"), 0, stdout=""))
    with open(os.path.join(folder, "e.csv"), encoding="ascii") as file:
        rows = [list(map(float, line.split(","))) for line in file]
    # eigenvalues of F: 1 (once), OPPOSITE - 2 ADJACENT (twice), -OPPOSITE (three times); e^2 l / (1 - (1 - e) l)
    values = [(1 / 6, 1), (1 / 3, OPPOSITE - 2 * ADJACENT), (1 / 2, -OPPOSITE)]
    expected = sum(weight * .25 * value / (1 - .5 * value) for weight, value in values)
    check("script-F of a cube has its closed form on the diagonal", abs(rows[3][3] - expected) < 1e-9)
    write("eps.vs3", vs3(CUBE, "eps=1e-2"))
    hprad("formfactors", "eps.vs3", "-o", "own.npy")
    hprad("formfactors", "eps.vs3", "-o", "eps.npy", "--use-eps")
    hprad("formfactors", "eps.vs3", "-o", "tol.npy", "--tol", "1e-2")
    own, eps, tol = (read_npy(os.path.join(folder, name + ".npy"))[1] for name in ("own", "eps", "tol"))
    check("eps counts only when asked for", eps == tol and eps != own)


def wrong_moments(hprad, folder, name, degree, polygons, entries):
    with open(os.path.join(folder, "m.vs3"), "w", encoding="ascii") as file:
        file.write(vs3(polygons))
    yield from problems(hprad("formfactors", "m.vs3", "--order", str(degree), "--tol", "1e-13", "--quiet"), 0, stdout="")
    shape, flat = read_npy(os.path.join(folder, "m.npy"))
    n = (degree + 1) * (degree + 2) // 2 if "tri" in name else (degree + 1) ** 2
    if shape != (2, 2, n, n):
        yield f"shape {shape}"
        return
    largest = max(map(abs, flat))
    for (k, l), value in entries.items():
        for i, j, row, column in ((0, 1, k, l), (1, 0, l, k)):
            found = flat[((2 * i + j) * n + row) * n + column]
            if not abs(found - value) <= 1e-12 * largest:
                yield f"K_{i}{j}[{row}][{column}] = {found!r}, expected {value!r}"


REFUSED = [  # arguments, exit code, texts
    (("cube.vs3", "-o", "f.dat"), 2, ["'f.dat'", ".npy, .csv or .txt"]),
    (("cube.vs3", "-o", "f.csv", "--order", "1"), 2, ["'f.csv'", ".npy only"]),
    (("cube.vs3", "--order", "17"), 2, ["--order '17'"]),
    (("cube.vs3", "--tol", "1"), 2, ["--tol '1'"]),
    (("cube.vs3", "-o", "none/f.npy"), 1, ["none"]),
    (("none.vs3",), 3, ["none.vs3"]),
    (("bad.vs3",), 3, ["bad.vs3: line 2:", "'nine'"]),
    (("x.vs3",), 3, ["x.vs3: line 2:", "(X)"]),
    (("trapezoid.vs3", "--order", "1"), 3, ["trapezoid.vs3", "row 0 's1'"]),
    (("window.vs3", "--order", "0"), 3, ["window.vs3", "row 0 's1'"]),
    (("combined.vs3", "--order", "0"), 3, ["combined.vs3", "row 0 's1'"]),
    (("huge.vs3", "--order", "16"), 1, ["GB", "this machine has"]),
]


def check_refusals(hprad, folder):
    window = [.25, .25, 0, .75, .25, 0, .75, .75, 0, .25, .75, 0]
    texts = {"bad.vs3": "F 3\nV nine 0 0 0\n", "x.vs3": "F 3\nX 1\n",
             "trapezoid.vs3": vs3([[0, 0, 0, 1, 0, 0, .5, 1, 0, 0, 1, 0]]),
             "window.vs3": vs3([CUBE[0], window], tail={1: "1 0 .5"}),
             "combined.vs3": vs3(CUBE[:3], tail={2: "0 1 .5"}),
             "huge.vs3": vs3([[0, 0, i, 1, 0, i, 1, 1, i, 0, 1, i] for i in range(3000)])}
    for name, text in texts.items():
        with open(os.path.join(folder, name), "w", encoding="ascii") as file:
            file.write(text)
    for arguments, code, said in REFUSED:
        before = hprad.listing()
        check("refused: " + " ".join(arguments), problems(hprad("formfactors", *arguments), code, said, ""))
        check("nothing left by: " + " ".join(arguments), hprad.listing() == before)


def holds(fact, said, condition):
    check(fact, [] if condition else [said])


def check_report(hprad, folder):
    def report(name, polygons, *arguments, control="", code=0):
        with open(os.path.join(folder, name + ".vs3"), "w", encoding="ascii") as file:
            file.write(vs3(polygons, control))
        check("a report: " + name, problems(hprad("formfactors", name + ".vs3", "--quiet", "--report", name + ".json",
                                                  *arguments), code, stdout=""))
        with open(os.path.join(folder, name + ".json"), encoding="utf-8") as file:
            return json.load(file)
    # Five blocks demanded to 1e-13 of their largest entry; worst seen 7e-16 and 4e-15.
    for order in (None, 3):
        said = report("told", CUBE, "--tol", "1e-13", *([] if order is None else ["--order", str(order)]),
                      control="encl=1")
        holds(f"what is closed closes to rounding, order {order}", said["closure"],
              said["closure"]["closed"] is True and 0 <= said["closure"]["defect"] < 5e-14)
        holds(f"the error is within what was asked, order {order}", said,
              0 < said["quadrature"]["relative_error"] <= 1e-13 and said["settings"]["tolerance"] == 1e-13 and
              said["settings"]["order"] == order)
        holds(f"nothing is short, rounded or outside [0, 1], order {order}", said["quadrature"],
              [said["quadrature"][key] for key in ("pairs_short", "pairs_rounded", "outside", "sampled_error")] ==
              [0, 0, 0, 0])
        check(f"pairs are counted, order {order}", said["counts"] == {"surfaces": 6, "pairs": 15, "pairs_blocked": 0})
    said = report("lidless", CUBE[:5])
    holds("the defect of what is open is what is open", said["closure"],
          said["closure"]["closed"] is False and abs(said["closure"]["defect"] - ADJACENT) < 1e-9)
    # what is 0.001 high is known to 1e-16 / 0.001 of itself
    kerb = [0, 0, 0, 0, 1, 0, 0, 1, .001, 0, 0, .001]
    said = report("kerb", [CUBE[0], kerb], "--tol", "1e-13")
    holds("rounding of the coordinates is told from a quadrature that stops short", said["quadrature"],
          said["quadrature"]["pairs_rounded"] == 1 and said["quadrature"]["pairs_short"] == 0 and
          said["quadrature"]["relative_error"] > 1e-13)
    before = hprad.listing()
    check("a report over the model is refused", problems(hprad("formfactors", "cube.vs3", "--report", "cube.vs3"), 2,
                                                         ["cube.vs3"], ""))
    check("nothing left of that", hprad.listing() == before)


def check_short(hprad, folder):
    """Past more than 256 blockers visibility is sampled: less than the tolerance, written all the same."""
    tiles = [[x / 17, y / 17, .5, x / 17 + .03, y / 17, .5, x / 17 + .03, y / 17 + .03, .5, x / 17, y / 17 + .03, .5]
             for x in range(17) for y in range(17)]
    with open(os.path.join(folder, "short.vs3"), "w", encoding="ascii") as file:
        file.write(vs3(CUBE[:2] + tiles, kinds={2 + i: "O" for i in range(len(tiles))}))
    check("short of the tolerance", problems(hprad("formfactors", "short.vs3", "--order", "1", "--quiet", "--report",
                                                   "short.json"), 4, ["1 of 1 pairs", "is written"], ""))
    with open(os.path.join(folder, "short.json"), encoding="utf-8") as file:
        said = json.load(file)["quadrature"]
    holds("the report says so", said, said["pairs_short"] == 1 and said["sampled_error"] > 1e-9)
    check("written all the same", read_npy(os.path.join(folder, "short.npy"))[0] == (2, 2, 4, 4))


def split(polygon, cells):
    """A parallelogram in cells x cells."""
    first, second, last = polygon[0:3], polygon[3:6], polygon[9:12]
    for s, t in ((s, t) for t in range(cells) for s in range(cells)):
        yield [first[k] + (a * (second[k] - first[k]) + b * (last[k] - first[k])) / cells
               for a, b in ((s, t), (s + 1, t), (s + 1, t + 1), (s, t + 1)) for k in range(3)]


def check_tiles(hprad, folder):
    """The .npy file is written tile by tile, text from the whole matrix, and so is what goes into a pipe."""
    def path(name):
        return os.path.join(folder, name)
    with open(path("many.vs3"), "w", encoding="ascii") as file:
        file.write(vs3([square for face in CUBE for square in split(face, 3)], "encl=1"))
    check("54 squares", problems(hprad("formfactors", "many.vs3", "--quiet"), 0, stdout=""))
    check("54 squares as text", problems(hprad("formfactors", "many.vs3", "-o", "many.csv", "--quiet", "--threads", "3"), 0,
                                         stdout=""))
    _, flat = read_npy(path("many.npy"))
    with open(path("many.csv"), encoding="ascii") as file:
        rows = [tuple(map(float, line.split(","))) for line in file]
    check("the same bits", [flat[54 * i:54 * i + 54] for i in range(54)] == rows)
    with open(path("many.surfaces.csv"), encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    check("row sums", all(abs(float(r["row_sum"]) - math.fsum(row)) < 1e-15 * 54 for r, row in zip(table, rows)))
    os.mkfifo(path("pipe.npy"))
    with hprad.start("formfactors", "many.vs3", "-o", "pipe.npy", "--quiet") as process:
        with open(path("pipe.npy"), "rb") as pipe, open(path("many.npy"), "rb") as file:
            check("a pipe gets the same bytes", pipe.read() == file.read())
        process.communicate()
        check("and is left in place", process.returncode == 0 and stat.S_ISFIFO(os.stat(path("pipe.npy")).st_mode))


def check_gltf(hprad, folder):
    write_scene(os.path.join(folder, "plates.gltf"), plates=2)
    check("a glTF scene", problems(hprad("formfactors", "plates.gltf", "--quiet"), 0, stdout=""))
    with open(os.path.join(folder, "plates.surfaces.csv"), encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    check("rows by node and side", [(r["node"], r["primitive"], r["side"]) for r in table] ==
          [("0", "0", "front"), ("1", "0", "front"), ("1", "0", "back"), ("2", "0", "front"), ("2", "0", "back")])
    shape, flat = read_npy(os.path.join(folder, "plates.npy"))
    areas = [float(r["area_m2"]) for r in table]
    n = len(areas)
    check("reciprocal", shape == (n, n) and
          all(abs(areas[i] * flat[n * i + j] - areas[j] * flat[n * j + i]) <= 1e-16 for i in range(n)
              for j in range(n)))


def main():
    with tempfile.TemporaryDirectory() as folder:
        hprad = Command(sys.argv[1], folder)
        check_formats(hprad, folder)
        check_control(hprad, folder)
        for name, degree, recv, send, entries in MOMENTS:
            check(name, wrong_moments(hprad, folder, name, degree, (recv, send), entries))
        check_refusals(hprad, folder)
        check_report(hprad, folder)
        check_short(hprad, folder)
        check_tiles(hprad, folder)
        check_gltf(hprad, folder)
    return done()


sys.exit(main())
