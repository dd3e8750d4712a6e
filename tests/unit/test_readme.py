#!/usr/bin/env python3
"""The README tells the truth: test_readme.py ROOT HPRAD.

Its commands run as they stand, one after the other in one folder; what it says of the default, of reports, of
tables and of the solution is compared with what the command writes.
"""
import csv
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from tap import check, done  # noqa: E402

PATIENCE_S = 120 * int(os.environ.get("HPR_TEST_PATIENCE", "1"))


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def commands(text):
    """The lines of the sh blocks that run hprad."""
    lines = [line for block in blocks(text, "sh") for line in block.splitlines()]
    return [line for line in lines if line.startswith(("hprad ", "build/hprad "))]


def code_words(text):
    return re.findall(r"`([^`]+)`", text)


def run(line, folder, hprad):
    """Problems of one command line, which a shell runs as a reader's would."""
    environment = dict(os.environ, PATH=os.path.dirname(hprad) + os.pathsep + os.environ["PATH"])
    before = set(os.listdir(folder))
    result = subprocess.run(["sh", "-c", line], cwd=folder, env=environment, stdin=subprocess.DEVNULL, check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
                            timeout=PATIENCE_S)
    if result.returncode:
        yield f"exit code {result.returncode}: {result.stderr}"
    words = shlex.split(line)
    for option in ("-o", "--report"):
        if option in words:
            name = re.sub(r"{[\w:]+}", "*", words[words.index(option) + 1])
            pattern = re.compile(re.escape(name).replace(r"\*", ".+") + "$")
            if not any(pattern.match(new) for new in set(os.listdir(folder)) - before):
                yield f"{name} was not written: {result.stdout}"


def report_rows(text):
    """{key: words of the content} of the table of the report."""
    table = text[text.index("**A report**"):text.index("**A solution**")]
    for line in table.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if line.startswith("| `"):
            for key in code_words(cells[0]):
                yield key, code_words(cells[1])


def section_rows(text, begin, end):
    """The same for the report of another verb, told between two headings: its own table, and the keys that it shares."""
    section = text[text.index(begin):text.index(end)]
    section = section[re.search(r"report( of a reference)? has the keys", section).start():]
    shared = section[:section.index("[any report]")]
    common = dict(report_rows(text))
    for key in code_words(shared):
        if key in common:
            yield key, common[key]
        elif key + "[]" in common:
            yield key + "[]", common[key + "[]"]
    for line in section.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if line.startswith("| `"):
            yield code_words(cells[0])[0], code_words(cells[1])


def report_problems(told, report):
    for key, value in report.items():
        array = isinstance(value, list)
        name = key + "[]" if array else key
        if name not in told:
            yield f"the README does not know `{name}`"
            continue
        inner = value[0] if array and value else value
        if isinstance(inner, dict) and sorted(inner) != sorted(told[name]):
            yield f"`{name}` has {sorted(inner)}, the README says {sorted(told[name])}"
    for name in told:
        if name.replace("[]", "") not in report:
            yield f"the report has no `{name}`"


def table_problems(text, folder):
    told = text[text.index("**A probe table**"):text.index("**A report**")]
    with open(os.path.join(folder, "light.csv"), encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    told = [word for group in code_words(told) for word in group.split(",")]
    for column in rows[0]:
        if column not in told:
            yield f"the README does not know the column `{column}`"
    for row in rows:
        if row["status"] != "ok":
            yield f"a point of the README lies on no surface: {row}"
        if float(row["irradiance_r"]) <= 0:
            yield f"a point of the README is dark: {row}"


def study_problems(text, folder):
    begin = text.index("### Study")
    told = re.findall(r"`(\w+)`", "".join(line.split("|")[1] for line in text[begin:text.index("### Batches")].splitlines()
                                          if line.startswith("| `")))
    with open(os.path.join(folder, "plates.csv"), encoding="utf-8") as file:
        columns = next(csv.reader(file))
    return [f"`{name}` is not in both" for name in set(told) ^ set(columns)]


def python_problems(text, folder):
    try:
        import numpy  # noqa: F401
    except ImportError:
        return
    for block in blocks(text, "python"):
        script = block + "\nassert irradiance.shape[1] == 3 and np.isfinite(irradiance).all()\n"
        result = subprocess.run([sys.executable, "-c", script], cwd=folder, stderr=subprocess.PIPE, check=False,
                                universal_newlines=True)
        if result.returncode:
            yield result.stderr


def missing_files(text, root):
    for link in re.findall(r"\]\(([^)#]+)\)", text) + re.findall(r"`((?:src|scenes|tests)/[\w./]+)`", text):
        if "://" not in link and not os.path.exists(os.path.join(root, link)):
            yield f"there is no {link}"


def main():
    root, hprad = (os.path.abspath(path) for path in sys.argv[1:3])
    with open(os.path.join(root, "README.md"), encoding="utf-8") as file:
        text = file.read()
    lines = commands(text)
    check("the README has commands for every verb",
          [f"none for {verb}" for verb in ("solve", "render", "probe", "reference", "study") if not any(f" {verb} " in x for x in lines)])
    with tempfile.TemporaryDirectory() as folder:
        os.symlink(os.path.join(root, "scenes"), os.path.join(folder, "scenes"))
        os.symlink(os.path.dirname(hprad), os.path.join(folder, "build"))
        with open(os.path.join(folder, "points.csv"), "w", encoding="utf-8") as file:
            file.write(blocks(text, "csv")[0])
        for line in lines:
            check(line, run(line, folder, hprad))
        with open(os.path.join(folder, "box.json"), encoding="utf-8") as file:
            report = json.load(file)
        check("the default is what the README says",
              [f"not in the README: {words}" for words in
               ["--order {order} --subdivide {subdivide} --feet {feet}".format(**report["settings"])]
               if f"`{words}`: polynomials of degree {report['settings']['order']}" not in " ".join(text.split())])
        check("the keys of a report", report_problems(dict(report_rows(text)), report))
        for name, begin, end in (("truth.json", "### Reference", "### Study"),
                                 ("room.json", "### View factors", "### Reference")):
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                check("the keys of " + name,
                      report_problems(dict(section_rows(text, begin, end)), json.load(file)))
        check("the columns of a study", study_problems(text, folder))
        check("the columns of a probe table, and its points", table_problems(text, folder))
        check("the Python example reads a solution", python_problems(text, folder))
    check("files that the README names are there", missing_files(text, root))
    return done()


sys.exit(main())
