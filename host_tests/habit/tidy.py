#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs clang-tidy on the files that a change touches; .clang-tidy sets the rules for names, complexity and mistakes.

Usage: tidy.py [--all | --self-test] [--base COMMIT] [FILE...]. Without --all and files, the sources and headers that a
change touches (changed.py). Configures the preset host-tidy for its compile commands, without a build. Prints each
finding once and exits with 1 if there is any. A file costs some seconds.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import changed
import headers

ROOT = pathlib.Path(__file__).resolve().parents[2]
FINDING = re.compile(r"^(/[^:]+:\d+):\d+: (?:warning|error): (.*)$", re.MULTILINE)


def tidied(name, known, build, flags):
    """-> findings in one file: a source is compiled by its own command, a header with the common flags."""
    command = ["clang-tidy", "--quiet", str(ROOT / name)]
    if str(ROOT / name) in known:
        command += ["-p", build]
    else:
        command += ["--", "-x", "c++", *flags[1:]]
    said = subprocess.run(command, capture_output=True, text=True)
    found = [f"{place}: {text}" for place, text in FINDING.findall(said.stdout)]
    return found or ([f"{name}: clang-tidy failed: {said.stderr.strip()}"] if said.returncode != 0 else [])


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--base")
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("files", nargs="*")
    return parser.parse_args()


def configured():
    """-> the folder with the compile commands, configured again because files may be new. Nothing is built."""
    subprocess.run(["cmake", "--preset", "host-tidy"], cwd=ROOT, capture_output=True, check=True)
    return ROOT / "build" / "host-tidy"


def self_test(flags):
    """The check must report a function whose name breaks the rule, and must not report a good one."""
    with tempfile.TemporaryDirectory() as folder:
        for name, good in (("WrongName", False), ("right_name", True)):
            header = pathlib.Path(folder) / "header.h"
            header.write_text(f"#pragma once\ninline int {name}() {{ return 1; }}\n")
            (pathlib.Path(folder) / ".clang-tidy").write_text((ROOT / ".clang-tidy").read_text())
            found = tidied(header, set(), "", flags)
            if bool(found) == good:
                print(f"{name}: {found}")
                return 1
    return 0


def main():
    asked = arguments()
    build = configured()
    if asked.self_test:
        return self_test(headers.flags_of(build))
    known = {entry["file"] for entry in json.loads((build / "compile_commands.json").read_text())}
    names = asked.files or changed.files(ROOT, (".h", ".cpp"), asked.all, asked.base)
    # Not checked here: sources that this machine does not build (the image's), and the headers in headers.LEFT_OUT.
    alone = [name for name in names if name.endswith(".h") and name not in headers.LEFT_OUT]
    names = [name for name in names if str(ROOT / name) in known] + alone
    flags = headers.flags_of(build)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(lambda name: tidied(name, known, str(build), flags), names))
    findings = sorted({line.replace(f"{ROOT}/", "") for lines in found for line in lines})
    print(*findings, sep="\n")
    print(f"{len(names)} files, {len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
