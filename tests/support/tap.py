"""The Test Anything Protocol for the script tests: check(fact, problems) per fact, then sys.exit(done()).

Problems go to stderr, for Meson keeps a TAP program's stdout to itself when it shows what failed.
"""
import sys

_count = 0
_failed = 0


def check(fact, problems=()):
    """One fact; it holds if `problems` (an iterable of texts, or a bool: does it hold?) is empty or True."""
    global _count, _failed
    if isinstance(problems, bool):
        problems = [] if problems else ["does not hold"]
    problems = list(problems)
    _count += 1
    _failed += bool(problems)
    print(f"{'not ok' if problems else 'ok'} {_count} - {fact}")
    for problem in problems:
        for line in str(problem).splitlines():
            print(f"{fact}: {line}", file=sys.stderr)


def done():
    """Prints the plan; returns the exit code."""
    print(f"1..{_count}")
    return 1 if _failed or not _count else 0
