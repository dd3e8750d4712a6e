#!/usr/bin/env python3
"""The table of hard cases: test_hard_cases.py ROOT PROGRAM [--write].

No case misses its bound, and the README shows the table that the program prints. What was reached depends on the
last bits of the machine, so there it may differ by one power of ten. --write puts the table into the README.
"""
import math
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from tap import check, done  # noqa: E402

BEGIN, END = "| case | F12 |", "\n\n"


def told(text):
    """Where the table begins and ends."""
    begin = text.index(BEGIN)
    return begin, text.index(END, begin)


def cells(table):
    return [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in table.strip().splitlines()]


def decades(a, b):
    """Powers of ten between what is reached, 0 if both say the same."""
    if a == b:
        return 0
    try:
        return abs(math.log10(float(a)) - math.log10(float(b)))
    except ValueError:
        return math.inf


def differences(told_table, printed):
    told_rows, rows = cells(told_table), cells(printed)
    if len(told_rows) != len(rows):
        yield f"the README has {len(told_rows) - 2} cases, the program {len(rows) - 2}"
    for theirs, ours in zip(told_rows, rows):
        if theirs[:-1] != ours[:-1] or decades(theirs[-1], ours[-1]) > 1.01:
            yield f"the README says {theirs}, the program {ours}; ./dev stability writes it anew"


def main():
    root, program = (os.path.abspath(path) for path in sys.argv[1:3])
    readme = os.path.join(root, "README.md")
    result = subprocess.run([program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                            check=False)
    with open(readme, encoding="utf-8") as file:
        text = file.read()
    begin, end = told(text)
    if sys.argv[3:] == ["--write"] and result.returncode == 0:
        text = text[:begin] + result.stdout.strip() + text[end:]
        with open(readme + ".new", "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(readme + ".new", readme)
        begin, end = told(text)
    check("every case keeps its bound",
          [result.stderr or f"exit code {result.returncode}"] if result.returncode or result.stderr else [])
    check("the README shows the table", differences(text[begin:end], result.stdout))
    return done()


sys.exit(main())
