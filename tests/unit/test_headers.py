#!/usr/bin/env python3
"""Public headers: test_headers.py SOURCE_ROOT LIBRARY, with CC and CXX in the environment.

Each compiles alone in C17 and C++17 without a warning, and what they declare is what the library exports.
"""
import os
import re
import shlex
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from tap import check, done  # noqa: E402

# Declared, but not written yet. Whoever writes one removes it here.
PENDING = set()

STRICT = ["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only"]
LANGUAGES = {"C17": ("CC", ["-std=c17", "-x", "c"]), "C++17": ("CXX", ["-std=c++17", "-x", "c++"])}


def compile_alone(include, header, language):
    """What the compiler says to a file that includes only this header; empty if it is content."""
    variable, arguments = LANGUAGES[language]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "alone")
        with open(path, "w", encoding="utf-8") as file:
            # twice: the guard; the last line: in ISO C a file must declare something
            file.write(f"#include <{header}>\n#include <{header}>\nint alone(void);\n")
        command = shlex.split(os.environ[variable]) + arguments + STRICT + ["-I", include, path]
        run = subprocess.run(command, stderr=subprocess.STDOUT, stdout=subprocess.PIPE, universal_newlines=True,
                             check=False)
    if run.returncode == 0 and not run.stdout:
        return []
    return [run.stdout or f"exit code {run.returncode}"]


def headers_in(include):
    for place, _, names in sorted(os.walk(include)):
        for name in sorted(names):
            if name.endswith(".h"):
                yield os.path.relpath(os.path.join(place, name), include)


def without_comments(text):
    return re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.DOTALL)


def declared(include):
    """(all functions that the headers declare, those of them that are marked HPR_API)"""
    functions, marked = set(), set()
    for header in headers_in(include):
        with open(os.path.join(include, header), encoding="utf-8") as file:
            text = without_comments(file.read())
        functions.update(re.findall(r"\b(hpr_\w+)\s*\((?!\s*\*)[^;{}]*\)\s*;", text))
        marked.update(re.findall(r"\bHPR_API\b[^;{}(]*?\b(hpr_\w+)\s*\(", text))
    return functions, marked


def exported(library):
    run = subprocess.run(["nm", "-D", "--defined-only", library], stdout=subprocess.PIPE, check=True,
                         universal_newlines=True)
    names = [line.split()[-1].split("@")[0] for line in run.stdout.splitlines()]
    return {name for name in names if name.startswith("hpr_")}


def check_compiling(include):
    headers = list(headers_in(include))
    check("there are public headers", len(headers) > 0)
    for header in headers:
        for language in LANGUAGES:
            check(f"{header} compiles alone in {language}", compile_alone(include, header, language))
    with open(os.path.join(include, "hprad", "hprad.h"), encoding="utf-8") as file:
        umbrella = set(re.findall(r"#include <(.*)>", file.read())) | {"hprad/hprad.h"}
    check("hprad/hprad.h includes every public header", (h for h in headers if h not in umbrella))


def check_symbols(include, library):
    functions, marked = declared(include)
    symbols = exported(library)
    check("there are public functions", len(functions) > 0)
    check("every public function is marked HPR_API", sorted(functions ^ marked))
    check("every public function is exported", sorted(functions - symbols - PENDING))
    check("every exported hpr_ name is public", sorted(symbols - functions))
    check("what is pending is declared and not yet exported", sorted(PENDING - (functions - symbols)))


def check_oneself():
    """A test that cannot fail says nothing: each fault below must be seen."""
    faults = {"C17": "size_t f(void);\n", "C++17": "struct s { int class; };\n"}
    for language, text in faults.items():
        with tempfile.TemporaryDirectory() as include:
            with open(os.path.join(include, "bad.h"), "w", encoding="utf-8") as file:
                file.write("#ifndef BAD\n#define BAD\n" + text + "#endif\n")
            problems = compile_alone(include, "bad.h", language)
            check(f"a header that is not {language} by itself is seen", bool(problems))
    with tempfile.TemporaryDirectory() as include:
        with open(os.path.join(include, "bad.h"), "w", encoding="utf-8") as file:
            file.write("/* HPR_API int hpr_no(void); */\nHPR_API int\nhpr_a(int (*f)(void));\nint hpr_b(void);\nhpr_c (*g)(int);\n")
        check("marked and unmarked declarations are told apart",
              declared(include) == ({"hpr_a", "hpr_b"}, {"hpr_a"}))


def main():
    include = os.path.join(sys.argv[1], "include")
    check_compiling(include)
    check_symbols(include, sys.argv[2])
    check_oneself()
    return done()


sys.exit(main())
