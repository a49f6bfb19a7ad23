#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Finds words that the word list (vocabulary.toml) replaces, in the project's C++ and Python files and in file names.

Usage: vocabulary.py ROOT | vocabulary.py --self-test. Prints one line per offence (file:line: word, what to say instead) and
exits with 1 if there is any.
"""
import pathlib
import re
import subprocess
import sys
import tomllib

LIST = pathlib.Path(__file__).with_name("vocabulary.toml")
SOURCES = (".h", ".cpp", ".inc", ".c", ".py")
SELF = ("host_tests/habit/vocabulary.toml", "host_tests/habit/vocabulary.py")


def entries():
    """-> the word list: (pattern of a whole word, what to say instead, files that may hold it)."""
    read = tomllib.loads(LIST.read_text())["entry"]
    return [(re.compile(rf"(?<!\w)(?:{entry['word']})(?!\w)"), entry["say"], entry.get("allowed", [])) for entry in read]


def offences(path, lines, words):
    for pattern, say, allowed in words:
        if path in allowed:
            continue
        stem = pattern.search(pathlib.PurePath(path).stem)
        if stem:
            yield 0, stem.group(0), say
        for number, line in enumerate(lines, 1):
            for found in pattern.finditer(line):
                yield number, found.group(0), say


def self_test():
    words = entries()
    planted = [("firmware/x.h", "enum class Rung { kTop };"), ("firmware/x.cpp", "  // the ladder steps down"),
               ("firmware/x.h", "constexpr int kMostRows = 3;"), ("host_tests/x.py", "told_m = 3"),
               ("firmware/est/cross.h", "class CrossCheck {"), ("host_tests/lab/tape.cpp", "")]
    sound = [("firmware/x.h", "enum class FailsafeState { kNominal };"), ("firmware/x.h", "constexpr int kMaxRows = 3;"),
             ("firmware/x.cpp", "values.push_back(1);")]
    missed = [text for path, text in planted if not list(offences(path, [text], words))]
    wrong = [text for path, text in sound if list(offences(path, [text], words))]
    print(*(f"self-test: not found: {text}" for text in missed), *(f"self-test: refused: {text}" for text in wrong), sep="\n")
    return 1 if missed or wrong else 0


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    root = pathlib.Path(sys.argv[1])
    words = entries()
    tracked = subprocess.run(["git", "ls-files"], cwd=root, capture_output=True, text=True, check=True).stdout.split("\n")
    names = [name for name in tracked if name.endswith(SOURCES) and name not in SELF]
    found = 0
    for name in names:
        for number, word, say in offences(name, (root / name).read_text().splitlines(), words):
            print(f"{name}:{number}: '{word}': say {say}")
            found += 1
    print(f"{len(names)} files read, {found} offences")
    return 1 if found or not names else 0


if __name__ == "__main__":
    sys.exit(main())
