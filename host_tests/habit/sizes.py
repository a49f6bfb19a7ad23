#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks lengths: at most four hand-written files have more than 400 lines, at most six functions more than 60.

A function of more than 60 lines gives the reason after "Deviation:", in the comment above it or on its first line.
Usage: sizes.py ROOT | sizes.py --self-test. Needs universal-ctags, which finds the ends of functions. Prints one line
per file and function that is too long and exits with 1 if one is not allowed.
"""
import collections
import json
import pathlib
import subprocess
import sys
import tempfile

FILE_LINES, FILES_PAST = 400, 4
FUNCTION_LINES, FUNCTIONS_PAST = 60, 6
SOURCES = (".h", ".cpp", ".inc", ".c", ".py", ".sh")
GENERATED = "/generated/"

Function = collections.namedtuple("Function", "path line lines name explained")


def tracked(root):
    names = subprocess.run(["git", "ls-files"], cwd=root, capture_output=True, text=True, check=True).stdout.split()
    return [name for name in names if name.endswith(SOURCES) and GENERATED not in name]


def explained(lines, first):
    """Whether the function that begins at line `first` (counted from 1) gives a reason for its length."""
    at = first - 2
    said = [lines[first - 1]]
    while at >= 0 and lines[at].lstrip().startswith(("//", "template", "#")):
        said.append(lines[at])
        at -= 1
    return any("Deviation:" in line for line in said)


def functions(root, names):
    command = ["ctags", "--output-format=json", "--fields=+ne", "--kinds-c++=f", "--language-force=C++", "-f-", "-L-"]
    cpp = [name for name in names if name.endswith((".h", ".cpp", ".inc", ".c"))]
    tags = subprocess.run(command, cwd=root, input="\n".join(cpp), capture_output=True, text=True, check=True).stdout
    for text in tags.splitlines():
        tag = json.loads(text)
        lines = tag.get("end", tag["line"]) - tag["line"] + 1
        if lines > FUNCTION_LINES and not tag["name"].startswith("__anon"):  # a lambda is not counted: it may be a list
            source = (pathlib.Path(root) / tag["path"]).read_text().splitlines()
            yield Function(tag["path"], tag["line"], lines, tag["name"], explained(source, tag["line"]))


def check(root, names):
    """Prints the long files and functions. @returns those that are not allowed, one line each."""
    wrong = []
    long_files = []
    for name in names:
        count = len((pathlib.Path(root) / name).read_text().splitlines())
        if count > FILE_LINES:
            long_files.append(f"{name}: {count} lines")
    long_functions = sorted(functions(root, names))
    for found in long_functions:
        text = f"{found.path}:{found.line}: {found.name} has {found.lines} lines"
        print(text)
        if not found.explained:
            wrong.append(f"{text}, more than {FUNCTION_LINES}, and no 'Deviation:' gives a reason")
    print(*long_files, sep="\n")
    if len(long_files) > FILES_PAST:
        wrong.append(f"{len(long_files)} files have more than {FILE_LINES} lines; at most {FILES_PAST} may")
    if len(long_functions) > FUNCTIONS_PAST:
        wrong.append(f"{len(long_functions)} functions have more than {FUNCTION_LINES} lines; at most {FUNCTIONS_PAST} may")
    return wrong


def self_test():
    def function(number, lines, comment=""):
        return f"{comment}int f{number}() {{\n" + "  g();\n" * (lines - 3) + "  return 0;\n}\n"

    why = "// Deviation: it is a list.\n"
    cases = {  # description: (planted files, expected number of offences)
        "a function of 60 lines": ({"a.cpp": function(1, 60)}, 0),
        "a function of 61 lines without a reason": ({"a.cpp": function(1, 61)}, 1),
        "a function of 61 lines with a reason": ({"a.cpp": function(1, 61, why)}, 0),
        "seven such functions with a reason": ({f"{n}.cpp": function(n, 61, why) for n in range(7)}, 1),
        "four long files": ({f"{n}.h": "//\n" * 401 for n in range(4)}, 0),
        "five long files": ({f"{n}.h": "//\n" * 401 for n in range(5)}, 1),
    }
    failed = 0
    for what, (files, offences) in cases.items():
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                (pathlib.Path(folder) / name).write_text(text)
            found = check(folder, list(files))
        if len(found) != offences:
            print(f"{what}: {len(found)} offences, not {offences}: {found}")
            failed = 1
    return failed


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    wrong = check(sys.argv[1], tracked(sys.argv[1]))
    print(*wrong, sep="\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
