#!/usr/bin/env python3
"""The manual page and the completion know what the command knows: test_manual.py HPRAD PAGE COMPLETION."""
import os
import re
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from tap import check, done  # noqa: E402


def run(*line):
    return subprocess.run(line, check=False, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)


def options_of(text):
    return sorted(set(re.findall(r"^ {2}(?:-\w, | {4})(--[\w-]+)", text, re.MULTILINE)))


def complete(completion, hprad, *words):
    """What bash would offer for the last of the words."""
    script = f"""source {completion}
COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
_hprad
printf '%s\\n' "${{COMPREPLY[@]}}" """
    return run("bash", "-c", script, "-", hprad, *words).stdout.split()


def main():
    hprad, page, completion = (os.path.abspath(path) for path in sys.argv[1:4])
    text = run(hprad, "--help").stdout
    verbs = re.findall(r"or: hprad (\w+) ", text)
    with open(page, encoding="utf-8") as file:
        manual = file.read().replace("\\-", "-")
    parts = dict(zip(["", *verbs], re.split(r"^\.SH HPRAD \w+$", manual, flags=re.MULTILINE)))
    check("there are verbs", len(verbs) >= 6 and len(parts) == len(verbs) + 1)
    common = set(options_of(text)) & set(options_of(run(hprad, "probe", "--help").stdout)) - {"--output"}
    for verb, part in parts.items():
        options = options_of(run(hprad, *filter(None, [verb]), "--help").stdout)
        missing = [option for option in options if (option not in common or not verb) and not re.search(rf"^\.B .*{option}\b", part, re.MULTILINE)]
        check(f"the page has every option of hprad {verb}", missing)
        offered = complete(completion, hprad, *filter(None, [verb]), "--")
        check(f"completion offers every option of hprad {verb}", [o for o in options if o not in offered])
    check("completion offers the verbs", [v for v in verbs if v not in complete(completion, hprad, "")])
    check("completion offers what begins like the word", complete(completion, hprad, "render", "--orb") == ["--orbit", "--orbit-centre"])
    check("completion offers values", complete(completion, hprad, "render", "--filter", "g") == ["gaussian"])
    helped = {verb: run(hprad, verb, "--help").stdout for verb in ("solve", "render")}
    for verb, option in (("solve", "--direct"), ("render", "--filter"), ("solve", "--isa"), ("solve", "--metallic"),
                         ("solve", "--method"), ("solve", "--refine"), ("solve", "--solver")):
        text = re.search(rf"^ +{option}=(.*?)(?=^ +-|^$)", helped[verb], re.MULTILINE | re.DOTALL)[1]
        values = complete(completion, hprad, verb, option, "")
        check(f"the help of {option} has the values that completion offers",
              [value for value in values if not re.search(rf"\b{value}\b", text)] if values else ["no value"])
    if shutil.which("groff"):
        result = run("groff", "-man", "-Tutf8", "-ww", page)
        check("the page is sound troff", [] if not result.stderr and not result.returncode else [result.stderr])
    return done()


sys.exit(main())
