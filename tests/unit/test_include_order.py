#!/usr/bin/env python3
"""The rules of the house: test_include_order.py SOURCE_ROOT checks every source file against them.

A module is a folder under src; it includes only itself and modules that stand before it in MODULES. Adding a
module means adding its name there. Some libraries have one user only (OWNERS); the command and the public
headers see only <hprad/...>; no source file is longer than MAX_LINES.
"""
import fnmatch
import os
import re
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from tap import check, done  # noqa: E402

MODULES = ["base", "math", "scene", "patch", "basis", "visibility", "direct", "quadrature", "link", "solver",
           "reconstruct", "render", "baseline", "io", "app", "cli"]

# library: (pattern of the header's name, pattern of the only files that may include it)
OWNERS = {
    "Embree": (r"embree\d*/|rtcore", "src/visibility/*"),
    "tinygltf": (r"tiny_?gltf", "src/io/gltf*"),
    "OpenEXR": (r"openexr|Imf|Imath", "src/io/exr_*.c"),
}

# headers that Meson makes in the build folder, and the module that includes them
GENERATED = {"version_values.h": "base"}

STANDARD_HEADERS = {name + ".h" for name in (
    "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg "
    "stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar "
    "wctype").split()}

MAX_LINES = 600
SOURCE_ENDINGS = (".c", ".h", ".cpp", ".hpp", ".cc", ".inc")


def sources(root, *folders):
    """Paths of the C and C++ files in these folders, relative to the root, with slashes."""
    for folder in folders:
        for place, _, names in sorted(os.walk(os.path.join(root, folder))):
            for name in sorted(names):
                if name.endswith(SOURCE_ENDINGS):
                    yield os.path.relpath(os.path.join(place, name), root).replace(os.sep, "/")


def lines_of(root, path):
    with open(os.path.join(root, path), encoding="utf-8") as file:
        return file.read().split("\n")


def includes(root, folder):
    """(path, "path:line", opening sign, name) of every #include; the sign is '<', '"' or '' for a macro."""
    for path in sources(root, folder):
        for number, line in enumerate(lines_of(root, path), 1):
            directive = re.match(r'\s*#\s*include(?:_next)?\b\s*(?:([<"])([^">]*)[">])?', line)
            if directive:
                yield path, f"{path}:{number}", directive.group(1) or "", directive.group(2) or line


def unknown_modules(root):
    for name in sorted(os.listdir(os.path.join(root, "src"))):
        if os.path.isdir(os.path.join(root, "src", name)):
            if name not in MODULES:
                yield f"src/{name} is not in the table of modules"
        elif name.endswith(SOURCE_ENDINGS):
            yield f"src/{name} belongs to no module"


def module_order(root):
    for path, place, sign, name in includes(root, "src"):
        own = path.split("/")[1]
        if sign == "<" or own not in MODULES or GENERATED.get(name) == own:
            continue
        module, slash, _ = name.partition("/")
        if sign != '"' or not slash or module not in MODULES or ".." in name:
            yield f'{place}: {name}: a header of hprad is included as "module/file.h"'
        elif not name.endswith((".h", ".hpp")):
            yield f"{place}: {name} is not a header"
        elif not os.path.isfile(os.path.join(root, "src", name)):
            yield f"{place}: src/{name} does not exist"
        elif MODULES.index(module) > MODULES.index(own):
            yield f"{place}: {own} must not include {name}, {module} comes later"


def command_is_thin(root):
    for _, place, sign, name in includes(root, "src/cli"):
        if sign == '"' and not name.startswith("cli/"):
            yield f"{place}: the command includes only <hprad/...> and its own files, not {name}"


def one_user(root, library):
    header, owner = OWNERS[library]
    for folder in ("src", "include"):
        for path, place, _, name in includes(root, folder):
            if re.match(header, name, re.IGNORECASE) and not fnmatch.fnmatch(path, owner):
                yield f"{place}: only {owner} includes {library}, here: {name}"


def public_headers(root):
    for _, place, sign, name in includes(root, "include/hprad"):
        if sign != "<" or (name not in STANDARD_HEADERS and not name.startswith("hprad/")):
            yield f"{place}: a public header includes only <hprad/...> and standard headers, not {name}"


def file_length(root):
    for path in sources(root, "src", "include", "tests"):
        count = len(lines_of(root, path)) - 1
        if count > MAX_LINES:
            yield f"{path} has {count} lines, more than {MAX_LINES}"


RULES = {
    "every folder under src is a known module": unknown_modules,
    "modules include only what stands before them": module_order,
    "the command uses public headers only": command_is_thin,
    "public headers include only public and standard headers": public_headers,
    f"no source file is longer than {MAX_LINES} lines": file_length,
}
for _library in OWNERS:
    RULES[f"{_library} has one user"] = lambda root, library=_library: one_user(root, library)


GOOD_TREE = {
    "include/hprad/a.h": "#include <stdint.h>\n#include <hprad/b.h>\n",
    "src/meson.build": "",
    "src/version.h.in": "",
    "src/base/a.h": "",
    "src/base/version.c": '#include "version_values.h"\n',
    "src/link/a.c": '#include "base/a.h"\n#include "link/a.h"\n#include <stdio.h>\n#include <lapacke.h>\n',
    "src/link/a.h": "#include <hprad/a.h>\n",
    "src/visibility/a.c": "#include <embree3/rtcore.h>\n",
    "src/io/gltf.hpp": "#include <tiny_gltf.h>\n",
    "src/io/gltf_read.cpp": '#include "io/gltf.hpp"\n',
    "src/io/exr_write.c": "#include <openexr.h>\n",
    "src/cli/a.c": '#include "cli/a.h"\n#include <hprad/a.h>\n#include <popt.h>\n',
    "src/cli/a.h": "",
    "tests/unit/a.c": "int x;\n" * MAX_LINES,
}

# what is wrong: (file, its text, the rule that must say so)
BAD_FILES = {
    "a later module": ("src/base/b.c", '#include "link/a.h"\n', "modules include only what stands before them"),
    "a later module, oddly spaced": ("src/base/b.c", ' #\tinclude"link/a.h"\n',
                                     "modules include only what stands before them"),
    "a neighbour without its module": ("src/link/b.c", '#include "a.h"\n',
                                       "modules include only what stands before them"),
    "a way around": ("src/base/b.c", '#include "base/../link/a.h"\n',
                     "modules include only what stands before them"),
    "a name made by a macro": ("src/base/b.c", "#include LINK\n", "modules include only what stands before them"),
    "a source file as a template": ("src/link/b.c", '#include "link/a.c"\n',
                                    "modules include only what stands before them"),
    "a header that is not there": ("src/link/b.c", '#include "link/b.h"\n',
                                   "modules include only what stands before them"),
    "a generated header elsewhere": ("src/link/b.c", '#include "version_values.h"\n',
                                     "modules include only what stands before them"),
    "an unknown module": ("src/misc/b.c", "", "every folder under src is a known module"),
    "a file outside the modules": ("src/b.c", "", "every folder under src is a known module"),
    "internals in the command": ("src/cli/b.c", '#include "base/a.h"\n', "the command uses public headers only"),
    "Embree elsewhere": ("src/render/b.c", "#include <embree4/rtcore.h>\n", "Embree has one user"),
    "tinygltf elsewhere": ("src/io/solution_read.cpp", '#include "tiny_gltf.h"\n', "tinygltf has one user"),
    "OpenEXR elsewhere": ("src/io/png_write.c", "#include <OpenEXR/openexr.h>\n", "OpenEXR has one user"),
    "an internal name in a public header": ("include/hprad/c.h", '#include "base/a.h"\n',
                                            "public headers include only public and standard headers"),
    "a library in a public header": ("include/hprad/c.h", "#include <cjson/cJSON.h>\n",
                                     "public headers include only public and standard headers"),
    "a long file": ("tests/unit/b.c", "int x;\n" * (MAX_LINES + 1),
                    f"no source file is longer than {MAX_LINES} lines"),
}


def broken_rules(files):
    """Names of the rules that a tree of these files breaks."""
    with tempfile.TemporaryDirectory() as root:
        for path, text in files.items():
            os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(text)
        return [name for name, rule in RULES.items() if list(rule(root))]


def main():
    root = sys.argv[1]
    check("there are files to look at", len(list(sources(root, "src", "include"))) > 10)
    for name, rule in RULES.items():
        check(name, rule(root))
    check("a good tree breaks no rule", broken_rules(GOOD_TREE))
    for what, (path, text, rule) in BAD_FILES.items():
        broken = broken_rules({**GOOD_TREE, path: text})
        check(f"seen: {what}", [] if rule in broken else [f"'{rule}' did not fail, only {broken}"])
    return done()


sys.exit(main())
