#!/usr/bin/env python3
"""Counts single test facts: count_tests.py TESTLOG.json STATUS, after `meson test` ended with STATUS.

The last line is `N passed, N failed`, with `, N skipped` if there are any; the exit code is 0 only if nothing
failed. A fact is a cmocka test, a TAP line, or, of a program that prints neither, the program itself. Meson's
verdict and the printed facts are both heard, and the worse one counts: a program that crashed, ran out of
time, was cut short or claims success after printing a failure adds at least one failure.
"""
import json
import re
import sys

RESULTS_THAT_PASS = ("OK", "SKIP")


def sum_of(pattern, text):
    return sum(int(number) for number in re.findall(pattern, text))


def count_cmocka(text):
    # No anchors: a test may have printed half a line. cmocka 2 puts the group's name before the number.
    passed = sum_of(r"\[  PASSED  \] (?:.*: )?(\d+) test\(s\)", text)
    failed = sum_of(r"\[  FAILED  \] (?:.*: )?(\d+) test\(s\)", text)
    skipped = sum_of(r"\[  SKIPPED \] (?:.*: )?(\d+) test\(s\)", text)
    begun = sum_of(r"\[==========\] (?:.*: )?Running (\d+) test\(s\)", text)
    lost = max(0, begun - passed - failed - skipped)  # the program ended before them
    return passed, failed + lost, skipped


def count_tap(text):
    plan = re.search(r"^1\.\.(\d+)", text, re.MULTILINE)
    if not plan:
        return 0, 0, 0
    failed = len(re.findall(r"^not ok\b", text, re.MULTILINE))
    skipped = len(re.findall(r"^ok\b[^#\n]*# *skip", text, re.MULTILINE | re.IGNORECASE))
    passed = len(re.findall(r"^ok\b", text, re.MULTILINE)) - skipped
    lost = max(0, int(plan.group(1)) - passed - failed - skipped)
    return passed, failed + lost, skipped


def count_program(record):
    """(passed, failed, skipped) of one line of Meson's testlog.json."""
    stdout, stderr = (record.get(key) or "" for key in ("stdout", "stderr"))
    pairs = zip(count_cmocka(stdout + "\n" + stderr), count_tap(stdout))
    passed, failed, skipped = (a + b for a, b in pairs)
    result = record.get("result")
    if result not in RESULTS_THAT_PASS:
        failed = max(failed, 1)
    elif passed + failed + skipped == 0:
        passed, skipped = (0, 1) if result == "SKIP" else (1, 0)
    return passed, failed, skipped


def count_log(lines, meson_status):
    """(passed, failed, skipped) of a whole run; a run without any test counts as one failure."""
    totals = [0, 0, 0]
    for line in lines:
        try:
            counts = count_program(json.loads(line))
        except (ValueError, AttributeError, TypeError):
            counts = (0, 1, 0)  # a log that was cut off
        totals = [total + count for total, count in zip(totals, counts)]
    if totals[1] == 0 and (meson_status != 0 or sum(totals) == 0):
        totals[1] = 1
    return tuple(totals)


def main():
    path, meson_status = sys.argv[1], int(sys.argv[2])
    try:
        with open(path, encoding="utf-8", errors="replace") as log:
            lines = [line for line in log.read().split("\n") if line]
    except OSError as error:
        print(f"no test has run: {error}")
        lines = []
    passed, failed, skipped = count_log(lines, meson_status)
    print(f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
