#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that the programs know every subcommand and every option of the command lines in the guide.

Usage: guide_commands.py M100 LAB PAGE... Prints one line per offence and exits with 1 if there is any.
"""
import pathlib
import re
import shlex
import subprocess
import sys

LINE = re.compile(r"^(m100|m100-lab) (\S.*)$")
OPTION = re.compile(r"^\s+(?:-\w,)?(--[\w-]+)", re.MULTILINE)


def commands(page):
    """The lines of the page's code blocks that call one of the programs, with their numbers."""
    inside = False
    for number, line in enumerate(page.splitlines(), 1):
        if line.startswith("```"):
            inside = not inside
        elif inside and (found := LINE.match(line.split("  #")[0])):
            yield number, found[1], shlex.split(found[2])


def known_options(program, subcommand):
    """The options that --help of a subcommand lists; None if there is no such subcommand."""
    run = subprocess.run([program, subcommand, "--help"], capture_output=True, text=True, check=False)
    return set(OPTION.findall(run.stdout)) if run.returncode == 0 else None


def offences(page, programs, known):
    for number, name, words in commands(page):
        place = (name, words[0])
        if place not in known:
            known[place] = known_options(programs[name], words[0])
        if known[place] is None:
            yield f"{number}: {name} has no subcommand '{words[0]}'"
            continue
        for word in words[1:]:
            if word.startswith("--") and word.split("=")[0] not in known[place]:
                yield f"{number}: {name} {words[0]} has no option '{word}'"


def self_test(programs, known):
    page = "```\nm100 probe --port x\nm100 probe --prot x\nm100 prob\n```\nm100 no block\n"
    found = list(offences(page, programs, known))
    return [] if len(found) == 2 and "--prot" in found[0] and "'prob'" in found[1] else [f"self-test: found {found}"]


def main():
    programs, known, found, count = {"m100": sys.argv[1], "m100-lab": sys.argv[2]}, {}, [], 0
    found += self_test(programs, known)
    for name in sys.argv[3:]:
        page = pathlib.Path(name).read_text()
        count += len(list(commands(page)))
        found += [f"{name}:{one}" for one in offences(page, programs, known)]
    for one in found:
        print(one)
    print(f"{count} command lines, {len(found)} offences")
    return 1 if found or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
