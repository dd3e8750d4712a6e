#!/usr/bin/env python3
"""The manual page, made of what the command says of itself: make_manual.py HPRAD OUTPUT.

So it cannot fall out of step with --help. Plain Python, run by Meson at build time.
"""
import re
import subprocess
import sys

TITLE = "hprad \\- diffuse global illumination by higher-order radiosity"
EXIT_CODES = [("0", "done"), ("1", "failed"), ("2", "wrong usage"), ("3", "bad input; the message names the file and the fault"),
              ("4", "the tolerance was not reached; the result is written"), ("130, 143", "interrupted")]


def ask(command, *arguments):
    return subprocess.run([command, *arguments], check=True, stdout=subprocess.PIPE, universal_newlines=True).stdout


def escape(text):
    """Text for troff: no line may begin with a dot or an apostrophe."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\n".join("\\&" + line if line[:1] in (".", "'") else line for line in text.split("\n"))


def read_help(text):
    """(usage lines, [(group, [(option, description)])], text about it, examples) of one --help."""
    head, _, rest = text.partition("\nExample")
    examples = [line.strip() for line in rest.split("\n")[1:] if line.strip()]
    lines = head.split("\n")
    usage = []
    while lines and not re.match(r"\s+(-\w, )?\s*--", lines[0]):
        usage.append(lines.pop(0))
    groups, about = [("", [])], []
    for line in lines:
        option = re.match(r" {2}(-\w, |    )(--\S.*?)(?: {2,}(\S.*))?$", line)
        if option:
            name = (option.group(1).strip() + " " if option.group(1).strip() else "") + option.group(2)
            groups[-1][1].append([name, option.group(3) or ""])
        elif re.match(r" {8,}\S", line) and groups[-1][1]:
            groups[-1][1][-1][1] += " " + line.strip()
        elif line.endswith(":") and not any(about) and not line.startswith(" ") and len(line) < 40:
            groups.append((line[:-1], []))
        else:
            about.append(line)
    return usage, [group for group in groups if group[1]], "\n".join(about).strip(), examples


def options_of(groups, known):
    """troff of the options that `known` has not, which takes them up."""
    for group, options in groups:
        fresh = [(name, said) for name, said in options if (group, name) not in known]
        if not fresh:
            yield f".P\n{escape(group)} options: as above."
            continue
        if group:
            yield f".P\n.B {escape(group)}"
        for name, said in fresh:
            if group == "Common":
                known.add((group, name))
            yield f".TP\n.B {escape(name)}\n{escape(said)}"


def manual(command):
    text = ask(command, "--help")
    verbs = re.findall(r"or: hprad (\w+) ", text)
    version = ask(command, "--version").split("\n")[0]
    usage, groups, about, examples = read_help(text)
    known = set()
    yield f".TH HPRAD 1 \"\" \"{version.split(' (')[0]}\" \"User commands\"\n.SH NAME\n{TITLE}\n.SH SYNOPSIS\n.nf"
    yield "\n".join(escape(re.sub(r"^(Usage:|\s+or:)\s*", "", line)) for line in usage if "VERB --help" not in line and line.strip())
    yield f".fi\n.SH DESCRIPTION\n{escape(about)}"
    yield from options_of(groups, known)
    for verb in verbs:
        usage, groups, about, shown = read_help(ask(command, verb, "--help"))
        yield f".SH HPRAD {verb.upper()}\n.nf\n{escape(re.sub('^Usage: ', '', usage[0]))}\n.fi\n.P\n{escape(about)}"
        yield from options_of(groups, known)
        examples += shown
    yield ".SH EXIT STATUS"
    for code, meaning in EXIT_CODES:
        yield f".TP\n.B {code}\n{meaning}"
    yield ".SH EXAMPLES\n.nf\n" + "\n".join(escape(line) for line in examples) + "\n.fi"


def main():
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write("\n".join(manual(sys.argv[1])) + "\n")
    return 0


sys.exit(main())
