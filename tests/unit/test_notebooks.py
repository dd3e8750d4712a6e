#!/usr/bin/env python3
"""Every notebook runs from end to end on small settings and leaves its figures: test_notebooks.py ROOT HPRAD. The cells
are executed here, in order, without Jupyter, so that this needs matplotlib alone; skipped without."""
import json
import os
import struct
import sys
import tempfile
import traceback

ROOT, HPRAD = (os.path.abspath(path) for path in sys.argv[1:3])
FOLDER = os.path.join(ROOT, "notebooks")
sys.path[:0] = [os.path.join(ROOT, "tests", "support"), FOLDER]
try:
    import matplotlib
    import numpy  # noqa: F401
except ImportError:
    if sys.executable != "/usr/bin/python3" and os.path.exists("/usr/bin/python3"):
        os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv])
    print("1..0 # SKIP matplotlib or numpy is missing")
    sys.exit(0)
sys.dont_write_bytecode = True
matplotlib.use("Agg")
from tap import check, done  # noqa: E402

NOTEBOOKS = ["01_parallel_plates", "02_edges_and_shadows", "03_accuracy_costs_time", "04_hard_cases", "05_your_scene"]


def execute(name):
    """What went wrong, with the cell and the line."""
    with open(os.path.join(FOLDER, name + ".ipynb"), encoding="utf-8") as file:
        cells = json.load(file)["cells"]
    space = {"__name__": "__main__"}
    for i, cell in enumerate(cells):
        if cell["cell_type"] == "code":
            try:
                exec(compile("".join(cell["source"]), f"{name}, cell {i}", "exec"), space)  # pylint: disable=exec-used
            except Exception:  # pylint: disable=broad-except
                return [traceback.format_exc()]
    return []


def unlabelled():
    """Axes of the figures at hand without what they show; those of a colour bar and of a picture say it in a title."""
    from matplotlib import pyplot
    for number in pyplot.get_fignums():
        for axes in pyplot.figure(number).axes:
            if not (axes.get_xlabel() or axes.get_title() or axes.get_label() == "<colorbar>"):
                yield f"figure {number} has an axis without a name"
    pyplot.close("all")


def png_problems(path):
    with open(path, "rb") as file:
        head = file.read(24)
    width, height = struct.unpack(">II", head[16:24]) if head[:8] == b"\x89PNG\r\n\x1a\n" else (0, 0)
    return [] if width > 300 and height > 150 else [f"{width} x {height} pixels"]


def main():
    check("these are the notebooks", sorted(n[:-6] for n in os.listdir(FOLDER) if n.endswith(".ipynb")) == NOTEBOOKS)
    os.chdir(FOLDER)
    with tempfile.TemporaryDirectory() as folder:
        os.environ.update(HPRAD=HPRAD, HPRAD_OUT=folder, HPRAD_SMALL="1")
        for variable in ("HPRAD_SCENE", "HPRAD_TOL", "HPRAD_SECONDS", "HPRAD_REPEATS"):
            os.environ.pop(variable, None)
        for name in NOTEBOOKS:
            before = set(os.listdir(folder))
            sys.stdout = sys.stderr  # what a notebook prints is no line of this test
            try:
                wrong = execute(name)
            finally:
                sys.stdout = sys.__stdout__
            check(f"{name} runs", wrong)
            check(f"{name}: its axes have names", unlabelled())
            figures = sorted(file for file in set(os.listdir(folder)) - before if file.endswith(".png"))
            check(f"{name} leaves figures", len(figures) > 0)
            for figure in figures:
                check(f"{figure} is a picture", png_problems(os.path.join(folder, figure)))
    return done()


sys.exit(main())
