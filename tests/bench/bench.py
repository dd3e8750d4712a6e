#!/usr/bin/env python3
"""What hprad costs, and what error goes with it: bench.py ROOT BUILD [options]; ./dev bench runs it.

One table per area on stdout, all rows as JSON in out/bench/, and with --write the tables of the README. With --against
FILE, one of those of an earlier run, each row says by what factor its CPU seconds have changed.
"""
import argparse
import dataclasses
import json
import os
import platform
import sys
import tempfile
import time

import blocks
import factors
import pictures
import solves
from measure import Bench

AREAS = {"blocks": blocks.rows, "view factors": factors.rows, "solve": solves.rows, "pictures": pictures.rows}


def number_text(value, digits=2):
    return "-" if value is None else f"{value:.{digits}g}" if 1e-3 <= abs(value) < 1e3 else f"{value:.{digits - 1}e}"


def count_text(value):
    for unit, name in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= unit:
            return f"{value / unit:.3g}{name}"
    return str(value)


def seconds_text(seconds):
    return f"{1e6 * seconds:.3g} us" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def cells(row, before):
    counters = ", ".join(f"{count_text(value)} {name}" for name, value in row.counters.items() if value)
    line = [row.case + (f" ({row.note})" if row.note else ""), seconds_text(row.cpu_seconds),
            seconds_text(row.target_seconds) if row.target_seconds else "", number_text(row.error),
            "" if row.memory_bytes is None else f"{row.memory_bytes / 1e6:.0f}", counters]
    if before is not None:
        line.append(f"{row.cpu_seconds / before[row.case]:.2f}" if before.get(row.case) else "-")
    return line


def table(area, rows, before):
    head = [area, "CPU time", "aim", "error", "memory, MB", "counted"] + ([] if before is None else ["time / before"])
    lines = [head, ["---"] * len(head), *(cells(row, before) for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def replaced(text, area, new):
    """The README with the table whose first cell is the area's."""
    begin = text.index(f"| {area} | CPU time |")
    end = text.index("\n\n", begin)
    return text[:begin] + new + text[end:]


def write_readme(root, tables):
    path = os.path.join(root, "README.md")
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for area, new in tables.items():
        text = replaced(text, area, new)
    with open(path + ".new", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(path + ".new", path)


def read_before(path):
    """CPU seconds of an earlier run by area and case."""
    with open(path, encoding="utf-8") as file:
        areas = json.load(file)["areas"]
    return {area: {row["case"]: row["cpu_seconds"] for row in rows} for area, rows in areas.items()}


def keep(root, bench, measured, seconds):
    folder = os.path.join(root, "out", "bench")
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, time.strftime("%Y%m%d-%H%M%S.json"))
    record = {"machine": platform.processor() or platform.machine(), "commit": bench.commit(), "seconds": seconds,
              "areas": {area: [dataclasses.asdict(row) for row in rows] for area, rows in measured.items()}}
    with open(path, "w", encoding="utf-8") as file:
        json.dump(record, file, indent=1)
    return path


def arguments():
    parser = argparse.ArgumentParser(prog="./dev bench", description="CPU time, error, memory and counters per area.")
    parser.add_argument("root", help=argparse.SUPPRESS)
    parser.add_argument("build", help=argparse.SUPPRESS)
    parser.add_argument("--against", metavar="FILE", help="print the ratio to this earlier run (out/bench/*.json)")
    parser.add_argument("--area", action="append", choices=AREAS, help="only this area (may be repeated)")
    parser.add_argument("--repeats", type=int, default=3, help="runs of which the median counts (3)")
    parser.add_argument("--large", action="store_true", help="also what takes minutes and gigabytes")
    parser.add_argument("--write", action="store_true", help="write the tables into the README")
    return parser.parse_args()


def main():
    options = arguments()
    root, build = os.path.abspath(options.root), os.path.abspath(options.build)
    before = read_before(options.against) if options.against else None
    measured, tables, start = {}, {}, time.monotonic()
    with tempfile.TemporaryDirectory(dir=build) as folder:
        bench = Bench(root, build, folder, options.repeats, options.large)
        for area in options.area or AREAS:
            measured[area] = list(AREAS[area](bench))
            print(table(area, measured[area], before and before.get(area, {})), end="\n\n", flush=True)
            tables[area] = table(area, measured[area], None)
        path = keep(root, bench, measured, time.monotonic() - start)
    if options.write:
        write_readme(root, tables)
    print(f"kept as {os.path.relpath(path)}", file=sys.stderr)


if __name__ == "__main__":
    main()
