#!/usr/bin/env python3
"""What `meson install` leaves is enough: test_install.py SOURCE_ROOT BUILD_ROOT SANITIZE, CC and MESON in the
environment. A small program finds the installed library through pkg-config alone, is compiled and runs."""
import os
import re
import shlex
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from tap import check, done  # noqa: E402

PROGRAM = r"""
#include <hprad/hprad.h>
#include <stdio.h>
int main(void)
{
    hpr_context *context;
    hpr_status status = hpr_context_create(NULL, &context);
    if (status != HPR_OK)
        return 1;
    printf("%s %s %d\n", hpr_status_string(status), hpr_context_isa(context), hpr_context_threads(context));
    hpr_context_destroy(&context);
    return context != NULL;
}
"""


def run(command, **environment):
    """(problems, stdout); a problem if the command fails."""
    try:
        result = subprocess.run(command, env={**os.environ, **environment}, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, universal_newlines=True, check=False)
    except OSError as error:
        return [str(error)], ""
    if result.returncode == 0:
        return [], result.stdout
    return [f"{shlex.join(command)}: exit code {result.returncode}", result.stdout, result.stderr], result.stdout


def find(root, name):
    """Path of the one file of this name below root, or None; name may begin with a folder's."""
    found = [os.path.join(place, entry) for place, _, names in os.walk(root) for entry in names
             if os.path.join(place, entry).endswith(os.sep + name)]
    return found[0] if len(found) == 1 else None


def check_headers(source, root):
    installed = find(root, "hprad.h")
    names = set(os.listdir(os.path.dirname(installed))) if installed else set()
    expected = {name for name in os.listdir(os.path.join(source, "include", "hprad")) if name.endswith(".h")}
    check("exactly the public headers are installed", sorted(names ^ expected))


def check_pkgconfig(file):
    """A shared library needs nothing else to be compiled against, and its .pc file names no static parts."""
    with open(file, encoding="utf-8") as stream:
        text = stream.read()
    check("hprad.pc asks for no other package's headers or libraries",
          [line for line in text.splitlines() if line.startswith("Requires")])
    libraries = re.findall(r"^Libs:.*", text, re.MULTILINE)
    check("hprad.pc links with hprad only", [] if libraries == ["Libs: -L${libdir} -lhprad"] else libraries)
    check("hprad.pc names no library that is not installed",
          [line for line in text.splitlines() if "hprad_core" in line])


def check_program(root, pc_file, sanitize, folder):
    pkgconfig = {"PKG_CONFIG_PATH": os.path.dirname(pc_file), "PKG_CONFIG_SYSROOT_DIR": root}
    problems, flags = run(["pkg-config", "--cflags", "--libs", "hprad"], **pkgconfig)
    check("pkg-config finds hprad", problems)
    source, program = os.path.join(folder, "user.c"), os.path.join(folder, "user")
    with open(source, "w", encoding="utf-8") as file:
        file.write(PROGRAM)
    sanitizer = [] if sanitize == "none" else ["-fsanitize=" + sanitize]
    command = shlex.split(os.environ["CC"]) + sanitizer + ["-std=c17", "-Wall", "-Werror", source, "-o", program]
    check("a program compiles against it", run(command + shlex.split(flags))[0])
    libraries = {"LD_LIBRARY_PATH": os.path.dirname(find(root, "libhprad.so"))}
    problems, output = run([program], **libraries)
    check("and runs", problems or ([] if re.fullmatch(r"ok \w+ [1-9]\d*\n", output) else [output]))
    problems, output = run([find(root, "bin/hprad"), "--help"], LD_LIBRARY_PATH="")
    check("the installed command runs and finds the library by itself", problems or ([] if output else ["no output"]))


def main():
    source, build, sanitize = sys.argv[1:4]
    with tempfile.TemporaryDirectory() as folder:
        root = os.path.join(folder, "root")
        install = shlex.split(os.environ["MESON"]) + ["install", "-C", build, "--no-rebuild", "--destdir", root]
        check("meson install", run(install)[0])
        check_headers(source, root)
        check("manual and completion are installed",
              [name for name in ("man1/hprad.1", "bash-completion/completions/hprad") if not find(root, name)])
        pc_file = find(root, "hprad.pc")
        check("hprad.pc is installed", pc_file is not None)
        if pc_file:
            check_pkgconfig(pc_file)
            check_program(root, pc_file, sanitize, folder)
    return done()


sys.exit(main())
