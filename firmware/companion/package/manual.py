#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The manual page and the completion know every option of every subcommand, as the program has it now.

Usage: manual.py M100 FOLDER [--write]. FOLDER has m100.1.in and m100.bash; --write brings the page's options up to
date. Exits with 1 where one differs. M100 may be m100-lab, whose page is not kept: only the completion is compared.
       manual.py M100-LAB FOLDER --page VERSION    prints the page of m100-lab from m100-lab.1.in
"""
import os
import pathlib
import re
import subprocess
import sys

BEGIN = '.\\" The options are written by manual.py from the program; a test compares them.\n'
END = ".SH EXIT STATUS\n"
SUBCOMMAND = re.compile(r"^  ([a-z][a-z-]*)  ")
OPTION = re.compile(r"^  (?:(-\w),)?(--[\w-]+) ?(.*)$")
WORDS_COLUMN = 30


def said_by(m100, *words):
    return subprocess.run([m100, *words, "--help"], capture_output=True, text=True, check=True).stdout


def subcommands(m100, *words):
    """[words that call a subcommand]: one, or two as in `frames decode`."""
    lines = said_by(m100, *words).partition("Subcommands:")[2].splitlines()
    names = [(*words, found[1]) for found in map(SUBCOMMAND.match, lines) if found]
    return [deeper for name in names for deeper in subcommands(m100, *name) or [name]]


def options(m100, subcommand):
    """[(--name, what it takes, what it is for)] in the order of --help."""
    found = []
    inside = False
    for line in said_by(m100, *subcommand).splitlines():
        if not line.strip():
            inside = False
        elif line == "Options:":
            inside = True
        elif inside and (option := OPTION.match(line)):
            takes, _, words = option[3].partition("  ") if "  " in option[3] else (option[3], "", "")
            found.append([option[2], takes.strip(), words.strip()])
        elif inside and line.startswith(" " * WORDS_COLUMN) and found:
            found[-1][2] = (found[-1][2] + " " + line.strip()).strip()
    return [one for one in found if one[0] != "--help"]


def roff(words):
    """Plain words as roff: every hyphen one that can be typed again, no line that begins with a dot."""
    text = words.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text[:1] in (".", "'") else text


def section(m100, described=False):
    out = [BEGIN]
    for subcommand in subcommands(m100):
        out.append(f".SH OPTIONS OF {' '.join(subcommand).upper()}\n")
        if described:
            out.append(roff(said_by(m100, *subcommand).partition("\n\n")[0].partition("Usage:")[0].strip()) + "\n")
        for name, takes, words in options(m100, subcommand):
            out.append(f".TP\n.B {roff(name)}{' ' if takes else ''}{roff(takes)}\n{roff(words)}\n")
    return "".join(out)


def page_with(page, options_section):
    before, _, after = page.partition(END)
    return before.split(BEGIN, 1)[0] + options_section + END + after


def offered(m100, script, subcommand):
    """What the completion offers for an option that has just begun."""
    ask = '. "$0"; COMP_WORDS=("$@" --); COMP_CWORD=$#; _m100; printf "%s\\n" "${COMPREPLY[@]}"'
    program = pathlib.Path(m100).resolve()
    run = subprocess.run(["bash", "-c", ask, str(script), program.name, *subcommand], capture_output=True, text=True, check=True,
                         env=os.environ | {"PATH": f"{program.parent}:{os.environ['PATH']}"})
    return set(run.stdout.split())


def is_kept(m100):
    return pathlib.Path(m100).name == "m100"


def offences(m100, folder):
    page = (folder / "m100.1.in").read_text()
    if is_kept(m100) and page_with(page, section(m100)) != page:
        yield "m100.1.in: its options are not those of the program: run manual.py M100 FOLDER --write"
    for subcommand in subcommands(m100):
        missing = {name for name, _, _ in options(m100, subcommand)} - offered(m100, folder / "m100.bash", subcommand)
        if missing:
            yield f"m100.bash: does not offer {', '.join(sorted(missing))} of {' '.join(subcommand)}"


def self_test(m100):
    """The program has options at all, with words; and a page that lacks one differs."""
    flown = options(m100, ("fly",))
    whole = page_with("x\n" + END, section(m100))
    held = len(flown) > 20 and all(words for _, _, words in flown)
    for page in (whole, whole.replace(".B \\-\\-hold", ".B x")):
        held = held and page_with(page, section(m100)) == whole
    return [] if held else [f"self-test: the options of fly are read as {flown}"]


def main():
    m100, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    if "--page" in sys.argv:
        page = (folder / "m100-lab.1.in").read_text().replace("@PROJECT_VERSION@", sys.argv[4])
        print(page_with(page, section(m100, described=True)), end="")
        return 0
    if "--write" in sys.argv:
        page = folder / "m100.1.in"
        page.write_text(page_with(page.read_text(), section(m100)))
    found = (self_test(m100) if is_kept(m100) else []) + list(offences(m100, folder))
    for one in found:
        print(one)
    print(f"{sum(len(options(m100, one)) for one in subcommands(m100))} options, {len(found)} offences")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
