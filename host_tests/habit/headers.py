#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that every header compiles alone, without another include before it.

Usage: headers.py BUILD_FOLDER [--all | --self-test] [--base COMMIT]. Without --all, those that a change touches
(changed.py). Takes the flags from compile_commands.json in the build folder. Prints the compiler's messages and exits
with 1 if there are any.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile

import changed

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Headers for one machine only, which are compiled with its image.
LEFT_OUT = ("linker/mbedtls_aes_config.h",)


def flags_of(build):
    """Compiler, search paths and definitions that most of the project's files are compiled with."""
    commands = json.loads((pathlib.Path(build) / "compile_commands.json").read_text())
    words = [shlex.split(entry["command"]) for entry in commands if entry["file"].endswith((".cpp", ".cxx"))]
    shared = [word for word in words[0] if all(word in other for other in words)]
    pairs = [pair for other in words for pair in zip(other, other[1:])]
    paths = dict.fromkeys(f"-isystem{path}" for word, path in pairs if word == "-isystem")
    paths.update(dict.fromkeys(word for other in words for word in other if word.startswith("-I")))  # made headers
    # Definitions of paths to a test's programs and files, which only its own command line has.
    paths.update(dict.fromkeys(word for other in words for word in other if word.startswith("-DM100_") and '="' in word))
    kept = [word for word in shared if word.startswith(("-D", "-std", "-f", "-W")) and word != "-Werror"]
    return [words[0][0], *kept, "-Wno-psabi", "-Wno-pragma-once-outside-header", f"-I{ROOT}", *paths]


def compiled(header, flags):
    command = [*flags, "-fsyntax-only", "-Werror", "-x", "c++", "-include", str(ROOT / header), os.devnull]
    return subprocess.run(command, capture_output=True, text=True).stderr


def self_test(flags):
    """The check must report a header that lacks an include, and must not report the same header with it."""
    text = "#pragma once\n{}inline std::string word() {{ return {{}}; }}\n"
    with tempfile.TemporaryDirectory() as folder:
        for include, good in (("", False), ("#include <string>\n", True)):
            header = pathlib.Path(folder) / "header.h"
            header.write_text(text.format(include))
            if (compiled(header, flags) == "") != good:
                print("self-test: a good header does not compile" if good else "self-test: a header without its include compiles")
                return 1
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--base")
    parser.add_argument("--self-test", action="store_true")
    asked = parser.parse_args()
    if asked.self_test:
        return self_test(flags_of(asked.build))
    headers = [name for name in changed.files(ROOT, (".h",), asked.all, asked.base) if name not in LEFT_OUT]
    flags = flags_of(asked.build)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        said = list(pool.map(lambda header: compiled(header, flags), headers))
    for header, text in zip(headers, said):
        if text:
            print(f"{header} does not compile alone:\n{text}")
    print(f"{len(headers)} headers checked, {sum(map(bool, said))} of them do not compile alone")
    return 1 if any(said) else 0


if __name__ == "__main__":
    sys.exit(main())
