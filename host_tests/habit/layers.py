#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Holds every #include of the project to the table of layers, and real-time code to its habits.

Usage: layers.py [--self-test] ROOT. Prints one line per offence (file:line: what) and exits with 1 if there is any.
"""
import pathlib
import re
import sys

CORE_MODEL = ["firmware/core/", "firmware/model/"]

# folder prefix -> prefixes (folders end with /) or single headers it may include besides its own folder.
# First match wins, so the narrower rule stands first.
LAYERS = [
    ("firmware/core/", []),
    ("firmware/model/", ["firmware/core/"]),
    ("firmware/log/", ["firmware/core/"]),
    ("protocol/", ["firmware/core/"]),
    ("hal/linux/", ["firmware/core/", "hal/*.h"]),
    ("hal/cortex_m/", ["firmware/core/", "hal/*.h"]),
    ("hal/mock/", ["firmware/core/", "hal/*.h"]),
    ("hal/", ["firmware/core/"]),
    ("firmware/est/", CORE_MODEL + ["firmware/ctl/command.h"]),
    ("firmware/ref/", CORE_MODEL),
    ("firmware/mpc/", CORE_MODEL),
    ("firmware/ctl/", CORE_MODEL + ["firmware/est/estimate.h", "firmware/ref/window.h", "firmware/mpc/"]),
    ("firmware/vrc/", CORE_MODEL + ["firmware/ctl/command.h"]),
    ("firmware/safety/", CORE_MODEL + ["firmware/ctl/command.h"]),
    ("firmware/sysid/", CORE_MODEL),
    ("firmware/app/main_linux", ["firmware/", "protocol/", "hal/*.h", "hal/linux/"]),
    ("firmware/app/linux/", ["firmware/", "protocol/", "hal/*.h", "hal/linux/"]),
    ("firmware/app/main_mps2", ["firmware/", "protocol/", "hal/*.h", "hal/cortex_m/"]),
    ("firmware/app/mps2/", ["firmware/", "protocol/", "hal/*.h", "hal/cortex_m/"]),
    ("firmware/app/", ["firmware/", "protocol/", "hal/*.h"]),
    ("host_tests/", ["firmware/", "protocol/", "hal/", "host_tests/"]),
]

# Linux-only parts of firmware/app: they run before the first tick or beside it and may use the whole library.
HOST_PARTS = re.compile(r"firmware/app/(main_linux|linux/|vehicle_file|replay|course|recorded_flight)|hal/linux/|hal/mock/|protocol/aes_mbedtls")
HEAP_HEADERS = re.compile(r"#include <(vector|string|map|set|list|deque|memory|functional|iostream|fstream|sstream|"
                          r"unordered_map|unordered_set|regex|thread|mutex|future|any|exception|stdexcept)>")
LIBM = re.compile(r"std::(sin|cos|tan|asin|acos|atan|atan2|exp|exp2|log|log2|log10|pow|hypot|cbrt|sinh|cosh|tanh)f?\(")
HEAP_WORDS = re.compile(r"\b(new\s+\w|delete\s|malloc\(|throw\b|dynamic_cast|std::chrono::(steady|system)_clock)")


def rule_of(path):
    for prefix, allowed in LAYERS:
        if path.startswith(prefix):
            return prefix, allowed
    return None, []


def permitted(path, included):
    if str(pathlib.PurePosixPath(included).parent) == str(pathlib.PurePosixPath(path).parent):
        return True
    prefix, allowed = rule_of(path)
    if included.startswith(prefix) and prefix != "hal/":
        return True
    for entry in allowed:
        if entry == "hal/*.h":
            if re.fullmatch(r"hal/\w+\.h", included):
                return True
        elif entry.endswith("/"):
            # what stands inside app is nobody's business below it, and generated tables only their users'
            if included.startswith(entry) and not (entry == "firmware/" and included.startswith("firmware/app/main")):
                return True
        elif included == entry:
            return True
    return False


def offences(path, lines):
    real_time = path.startswith(("firmware/", "protocol/", "hal/")) and not HOST_PARTS.match(path)
    for number, line in enumerate(lines, 1):
        code = line.split("//")[0]
        include = re.match(r'\s*#include "([^"]+)"', line)
        if include and not permitted(path, include.group(1)):
            yield number, f"may not include {include.group(1)}"
        if re.match(r"\s*#include <Eigen/", line) and path != "firmware/core/eigen.h" and not path.startswith("host_tests/"):
            yield number, "Eigen comes in through firmware/core/eigen.h only"
        if "Deviation:" in line or not real_time:
            continue
        if HEAP_HEADERS.match(line):
            yield number, f"header not for real-time code: {line.strip()}"
        if LIBM.search(code) and not path.startswith("firmware/core/maths"):
            yield number, "libm differs between machines: use firmware/core/maths.h"
        if HEAP_WORDS.search(code) and "= delete" not in code:
            yield number, f"not in real-time code: {HEAP_WORDS.search(code).group(0).strip()}"


def self_test():
    """The test of the test: each of these lines must be found."""
    planted = [
        ("firmware/est/x.h", '#include "protocol/telemetry.h"'),
        ("firmware/ctl/x.cpp", '#include "firmware/vrc/sticks.h"'),
        ("protocol/x.h", '#include "hal/uart.h"'),
        ("hal/linux/x.cpp", '#include "hal/mock/mock_uart.h"'),
        ("firmware/app/flight_controller.h", '#include "hal/linux/linux_uart.h"'),
        ("firmware/mpc/x.h", '#include "host_tests/tools/x.h"'),
        ("firmware/est/x.h", "#include <Eigen/Dense>"),
        ("firmware/est/x.h", "#include <vector>"),
        ("firmware/est/x.cpp", "  return std::sin(x);"),
        ("firmware/est/x.cpp", "  throw 3;"),
        ("firmware/est/x.cpp", "  auto* p = new int;"),
    ]
    missed = [p for p in planted if not list(offences(p[0], [p[1]]))]
    for path, line in missed:
        print(f"self-test: not found: {path}: {line}")
    return 1 if missed else 0


def main():
    if "--self-test" in sys.argv:
        return self_test()
    root = pathlib.Path(sys.argv[1])
    count = found = 0
    for folder in ("firmware", "hal", "protocol", "host_tests"):
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in (".h", ".cpp", ".c"):
                continue
            count += 1
            path = str(file.relative_to(root))
            for number, what in offences(path, file.read_text().splitlines()):
                print(f"{path}:{number}: {what}")
                found += 1
    print(f"{count} files read, {found} offences")
    return 1 if found or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
