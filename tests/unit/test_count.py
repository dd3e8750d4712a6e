#!/usr/bin/env python3
"""The counter behind `./dev test` never prints 0 failed when something failed."""
import json
import os
import subprocess
import sys
import tempfile

SUPPORT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support")
sys.path.insert(0, SUPPORT)
from tap import check, done  # noqa: E402

CMOCKA_GOOD = ("[==========] Running 3 test(s).\n[ RUN      ] a\n[       OK ] a\n"
               "[==========] 3 test(s) run.\n[  PASSED  ] 3 test(s).\n")
CMOCKA_BAD = ("[==========] Running 3 test(s).\n[==========] 3 test(s) run.\n[  PASSED  ] 1 test(s).\n"
              "[  FAILED  ] 2 test(s), listed below:\n[  FAILED  ] a\n[  FAILED  ] b\n\n 2 FAILED TEST(S)\n")
CMOCKA_CUT = "[==========] Running 3 test(s).\n[ RUN      ] a\n[       OK ] a\n"
CMOCKA_SKIP = ("[==========] Running 2 test(s).\n[==========] 2 test(s) run.\n[  PASSED  ] 1 test(s).\n"
               "[  SKIPPED ] 1 test(s), listed below:\n[  SKIPPED ] a\n")
CMOCKA_2 = ("[==========] tests: Running 3 test(s).\n[==========] tests: 3 test(s) run.\n"
            "[  PASSED  ] 2 test(s).\n[  FAILED  ] tests: 1 test(s), listed below:\n")
TAP_GOOD = "ok 1 - a\nok 2 - b\n1..2\n"
TAP_BAD = "1..3\nok 1 - a\nnot ok 2 - b # TODO later\nok 3 - c # SKIP no tool\n"
TAP_CUT = "1..5\nok 1 - a\nok 2 - b\n"


def record(result="OK", stdout="", stderr=""):
    return json.dumps({"name": "x", "result": result, "stdout": stdout, "stderr": stderr})


def last_line(text, status=0):
    """(exit code, last line) for a log of this text; None: no such file."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "testlog.json")
        if text is not None:
            with open(path, "w", encoding="utf-8") as log:
                log.write(text)
        run = subprocess.run([sys.executable, os.path.join(SUPPORT, "count_tests.py"), path, str(status)],
                             stdout=subprocess.PIPE, universal_newlines=True, check=False)
    return run.returncode, run.stdout.splitlines()[-1]


def expect(fact, text, line, status=0):
    code, got = last_line(text, status)
    problems = []
    if got != line:
        problems.append(f"printed '{got}', expected '{line}'")
    if (code == 0) != (", 0 failed" in line):
        problems.append(f"exit code {code} after '{line}'")
    check(fact, problems)


GOOD = record(stdout=CMOCKA_GOOD)
expect("cmocka tests count one each", GOOD, "3 passed, 0 failed")
expect("the same on stderr", record(stderr=CMOCKA_GOOD), "3 passed, 0 failed")
expect("several groups add up", record(stdout=CMOCKA_GOOD + CMOCKA_GOOD), "6 passed, 0 failed")
expect("a half line before the sum", record(stdout=CMOCKA_GOOD.replace("[  P", "0.5[  P")), "3 passed, 0 failed")
expect("TAP lines count one each", record(stdout=TAP_GOOD), "2 passed, 0 failed")
expect("another program counts as one", record(stdout="hello\n"), "1 passed, 0 failed")
expect("programs add up", "\n".join([GOOD, record(stdout=TAP_GOOD), record()]), "6 passed, 0 failed")
expect("cmocka failures", record("FAIL", CMOCKA_BAD), "1 passed, 2 failed")
expect("cmocka 2 failures", record("FAIL", CMOCKA_2), "2 passed, 1 failed")
expect("TAP failures, TODO ones too", record("FAIL", TAP_BAD), "1 passed, 1 failed, 1 skipped")
expect("a skipped program", record("SKIP"), "0 passed, 0 failed, 1 skipped")
expect("a skipped cmocka test", record("OK", CMOCKA_SKIP), "1 passed, 0 failed, 1 skipped")
expect("printed failures beat exit code 0", record("OK", CMOCKA_BAD), "1 passed, 2 failed", 0)
expect("a failing TAP line beats exit code 0", record("OK", TAP_BAD), "1 passed, 1 failed, 1 skipped")
expect("printed failures beat a skip", record("SKIP", CMOCKA_BAD), "1 passed, 2 failed")
expect("cut short with exit code 0: cmocka", record("OK", CMOCKA_CUT), "0 passed, 3 failed")
expect("cut short with exit code 0: TAP", record("OK", TAP_CUT), "2 passed, 3 failed")
for bad in ("FAIL", "ERROR", "TIMEOUT", "INTERRUPT", "UNEXPECTEDPASS", "EXPECTEDFAIL", "PENDING", "new", None):
    expect(f"result {bad} without printed failures", record(bad, CMOCKA_GOOD), "3 passed, 1 failed")
expect("Meson failed, the log knows nothing of it", GOOD, "3 passed, 1 failed", 1)
expect("Meson was killed", GOOD, "3 passed, 1 failed", 137)
expect("no log", None, "0 passed, 1 failed")
expect("an empty log", "", "0 passed, 1 failed")
expect("a log that was cut off", GOOD + "\n" + GOOD[:40], "3 passed, 1 failed")
expect("a log of something else", GOOD + "\n[1, 2]", "3 passed, 1 failed")
expect("output that is not text", '{"name": "x", "result": "OK", "stdout": 5}', "0 passed, 1 failed")

sys.exit(done())
