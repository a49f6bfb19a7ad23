#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks the shape of the tree: one class in one file, small classes, small folders, and how much there is to read.

Usage: structure.py ROOT [--table] | structure.py --self-test. Prints every number beside its bar and each offence; --table prints the
numbers as the table of host_tests/README.md. Needs universal-ctags. Exits with 1 if a number is past its bar.
"""
import collections
import json
import pathlib
import re
import subprocess
import sys
import tempfile

PRODUCT = ("firmware/", "protocol/", "hal/", "host_tests/lab/", "host_tests/sim/")
NO_HEADER_NEEDED = ("command.cpp", "main.cpp")
MAX_MEMBERS, MAX_FOLDER = 20, 25
# number -> (most that is let through today, goal, value when the goal was set). The first only ever shrinks.
BARS = {"sources without a header of their name": (15, 15, 54), "classes with more than 20 data members": (0, 0, 8),
        "folders with more than 25 sources": (0, 0, 8), "words of README.md": (900, 900, 3596),
        "words of all Markdown": (40456, 35000, 79403), "words of Markdown outside generated figures": (28082, 24000, 48078),
        "lines of C++ without generated code": (158269, 128000, 129815)}
# The lines rose five times: vibration and lever arm before a flight, what limits an aircraft; then unsigned poses on the
# loopback (791), streamed set points (1030) and what false headings and attitudes do in the air (223).
# Then came the names that both parts of a log settle (425) and, last, what a log says of its own sticks and of effects
# that unseen data do not test (454); what they make unnecessary is to be found by ablation. The law and the world of the
# paper's authors (616), which may add, and the type that keeps the JSON library in one source (407) came next.
GENERATED = re.compile(r"<!-- figure: .*?<!-- end -->", re.DOTALL)
PARTS = {"flight code": ("firmware/", "protocol/", "hal/"), "lab": "host_tests/lab/", "simulation": "host_tests/sim/"}


def cpp_of(names):
    """-> the hand-written sources and headers."""
    return [name for name in names if name.endswith((".h", ".cpp")) and "/generated/" not in name]


def lines_of(root, name):
    return len((pathlib.Path(root) / name).read_text().splitlines())


def members_by_class(root, names):
    """-> {class: data members} of every class that hides at least one of them: plain records of values do not count."""
    command = ["ctags", "--output-format=json", "--fields=+aSp", "--kinds-c++=m", "--language-force=C++", "-f-", "-L-"]
    tags = subprocess.run(command, cwd=root, input="\n".join(names), capture_output=True, text=True, check=True).stdout
    count, hides = collections.Counter(), set()
    for text in tags.splitlines():
        tag = json.loads(text)
        owner = (tag["path"], tag.get("scope", ""))
        if "__anon" in owner[1]:
            continue
        count[owner] += 1
        if tag.get("access") == "private":
            hides.add(owner)
    return {owner: number for owner, number in count.items() if owner in hides}


def measure(root, names):
    """-> {number: (value, offences)}."""
    root = pathlib.Path(root)
    product = [name for name in names if name.startswith(PRODUCT)]
    cpp = cpp_of(names)
    known = set(names)
    bare = [name for name in product if name.endswith(".cpp") and not name.endswith(tuple("/" + end for end in NO_HEADER_NEEDED))
            and name[:-4] + ".h" not in known]
    headers = [name for name in product if name.endswith((".h", ".cpp")) and "/generated/" not in name]
    wide = [f"{path}: {owner} has {number}" for (path, owner), number in sorted(members_by_class(root, headers).items())
            if number > MAX_MEMBERS]
    folders = collections.Counter(str(pathlib.PurePath(name).parent) for name in cpp)
    full = [f"{folder}: {number}" for folder, number in sorted(folders.items()) if number > MAX_FOLDER]
    pages = [name for name in names if name.endswith(".md")]
    texts = {name: (root / name).read_text() for name in pages}
    words = {name: len(text.split()) for name, text in texts.items()}
    by_hand = sum(len(GENERATED.sub(" ", text).split()) for text in texts.values())
    lines = sum(lines_of(root, name) for name in cpp)
    return dict(zip(BARS, [(len(bare), bare), (len(wide), wide), (len(full), full), (words.get("README.md", 0), []),
                           (sum(words.values()), []), (by_hand, []), (lines, [])]))


def check(root, names):
    """Prints the numbers and what is past its bar. @returns how many numbers are past it."""
    past = 0
    for what, (value, offences) in measure(root, names).items():
        bar = BARS[what][0]
        print(f"{what}: {value} (at most {bar})")
        if value > bar:
            print(*(f"  {offence}" for offence in offences), sep="\n")
            past += 1
    return past


def table(root, names):
    print("| number | before | now | goal |\n|---|---|---|---|")
    for what, (value, _) in measure(root, names).items():
        print(f"| {what} | {BARS[what][2]} | {value} | {BARS[what][1]} |")
    count = collections.Counter()
    for name in cpp_of(names):
        count[next((part for part, folders in PARTS.items() if name.startswith(folders)), "tests")] += lines_of(root, name)
    print(f"| ({', '.join(f'{part} {lines}' for part, lines in count.most_common())}) | | | |")


def self_test():
    wide = "class Wide {\n" + "".join(f"  int m{n}_;\n" for n in range(21)) + "};\n"
    record = "struct Record {\n" + "".join(f"  int m{n};\n" for n in range(21)) + "};\n"
    cases = {  # description: (planted files, numbers past their bar)
        "nothing": ({"firmware/a.h": "\n", "firmware/a.cpp": "\n"}, 0),
        "too many sources without a header": ({f"firmware/{n}/a.cpp": "\n" for n in range(BARS["sources without a header of their name"][0] + 1)}, 1),
        "too many wide classes": ({f"firmware/{n}.h": wide for n in range(BARS["classes with more than 20 data members"][0] + 1)}, 1),
        "a wide record": ({"firmware/a.h": record}, 0),
        "a full folder": ({f"host_tests/unit/{n}.cpp": "\n" for n in range(26)}, 1),
        "a long first page": ({"README.md": "word " * 901}, 1),
    }
    failed = 0
    for what, (files, past) in cases.items():
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                path = pathlib.Path(folder) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            if check(folder, list(files)) != past:
                print(f"self-test: {what}: not {past} numbers past their bar")
                failed = 1
    return failed


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    root = sys.argv[1]
    names = subprocess.run(["git", "ls-files"], cwd=root, capture_output=True, text=True, check=True).stdout.split("\n")[:-1]
    if "--table" in sys.argv:
        table(root, names)
        return 0
    return 1 if check(root, names) else 0


if __name__ == "__main__":
    sys.exit(main())
