"""Runs the command from a notebook, into one folder, and hands its tables and pictures over. Nothing is computed here.

The environment sets HPRAD (the command, else ../build/hprad), HPRAD_OUT (the folder, else ../out/notebooks),
HPRAD_SMALL (anything: a quick run, to see that everything works) and HPRAD_REPEATS (timed solves of each row of a study).
"""
import os
import subprocess

import matplotlib.pyplot as plt
import numpy as np

import hprad_reader as reader

command = os.environ.get("HPRAD", "../build/hprad")
out = os.environ.get("HPRAD_OUT", "../out/notebooks")
small = "HPRAD_SMALL" in os.environ
repeats = os.environ.get("HPRAD_REPEATS", "1" if small else "3")
os.makedirs(out, exist_ok=True)


def file(name):
    return os.path.join(out, name)


def bundled(scene):
    """A scene of ../scenes."""
    return os.path.join("..", "scenes", scene + ".gltf")


def run(*arguments, codes=(0,)):
    """hprad with these arguments; complains unless it ends with one of the codes (4: a tolerance was missed)."""
    result = subprocess.run([command, *map(str, arguments), "--quiet"], stderr=subprocess.PIPE, universal_newlines=True, check=False)
    if result.returncode not in codes:
        raise RuntimeError(f"hprad {' '.join(map(str, arguments))}: exit code {result.returncode}: {result.stderr}")


def study(scene, name, *options):
    """The table of `hprad study` of a scene file. What stands in it already, of the same program, is not solved again."""
    run("study", scene, *options, "-o", file(name + ".csv"), "--resume")
    return reader.study(file(name + ".csv"))


def solve(scene, name, *options):
    """The report of `hprad solve`; the solution is NAME.glb."""
    run("solve", scene, *options, "-o", file(name + ".glb"), "--report", file(name + ".json"), codes=(0, 4))
    return reader.report(file(name + ".json"))


def select(rows, **wanted):
    """The rows of a table whose columns have these values."""
    keep = np.ones(len(next(iter(rows.values()))), bool)
    for column, value in wanted.items():
        keep &= rows[column] == value
    return {column: values[keep] for column, values in rows.items()}


def joined(tables):
    return {column: np.concatenate([rows[column] for rows in tables]) for column in tables[0]}


def spread(rows):
    """Error bars of the CPU seconds: from the least to the most of the repeats."""
    return [rows["cpu_seconds"] - rows["cpu_seconds_least"], rows["cpu_seconds_most"] - rows["cpu_seconds"]]


def axes_of(axes, xlabel, ylabel, title="", x="log", y="log"):
    axes.set(xscale=x, yscale=y, xlabel=xlabel, ylabel=ylabel, title=title)
    axes.grid(True, which="both", alpha=.3)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8)


def save(figure, name):
    figure.tight_layout()
    figure.savefig(file(name + ".png"), dpi=80)
