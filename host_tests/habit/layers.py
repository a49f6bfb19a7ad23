#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks every #include of the project against the table of layers, and real-time code for what it must not use.

Usage: layers.py [--self-test] ROOT. Prints one line per offence (file:line: what) and exits with 1 if there is any.
"""
import pathlib
import re
import sys

CORE_MODEL = ["firmware/core/", "firmware/model/"]
FLIGHT_PARTS = CORE_MODEL + [f"firmware/{part}/" for part in
                             ("est", "ref", "mpc", "ctl", "vrc", "safety", "log", "sysid", "link")]

PRODUCT = ["firmware/", "protocol/", "hal/"]
LAB = PRODUCT + ["host_tests/lab/*.h", "host_tests/lab/logs/"]
ROOM = "host_tests/lab/identify/"
ANSWER = LAB + [ROOM + "request.h", ROOM + "output/result.h"]  # the question and the answer: values that every room knows
SHARED = [ROOM + "data/", ROOM + "model/*.h", ROOM + "residual_tests/*.h"]

# folder -> what its files may include besides the folder itself: prefixes (folders end with /), headers directly in a
# folder (*.h), or single headers. The longest folder that contains a file decides; a file without a row is an offence.
LAYERS = {
    "firmware/core/": [],
    "firmware/model/": ["firmware/core/"],
    "firmware/log/": ["firmware/core/"],
    "protocol/": ["firmware/core/"],
    "hal/": ["firmware/core/"],
    "hal/linux/": ["firmware/core/", "hal/*.h"],
    "hal/cortex_m/": ["firmware/core/", "hal/*.h"],
    "hal/mock/": ["firmware/core/", "hal/*.h"],
    "firmware/est/": CORE_MODEL + ["firmware/ctl/command.h"],
    "firmware/ref/": CORE_MODEL,
    "firmware/mpc/": CORE_MODEL,
    "firmware/ctl/": CORE_MODEL + ["firmware/est/estimate.h", "firmware/ref/time_optimal.h", "firmware/ref/window.h", "firmware/mpc/"],
    "firmware/vrc/": CORE_MODEL + ["firmware/ctl/command.h"],
    "firmware/safety/": CORE_MODEL + ["firmware/ctl/command.h", "firmware/ctl/law/geofence_status.h",
                                      "firmware/ctl/monitor/control_authority_status.h",
                                      "firmware/ctl/monitor/limit_cycle_status.h", "firmware/est/estimate_status.h",
                                      "firmware/est/consistency_status.h", "firmware/sysid/model_status.h"],
    "firmware/sysid/": CORE_MODEL,
    "firmware/link/": CORE_MODEL + ["protocol/", "firmware/safety/", "firmware/vrc/", "firmware/log/",
                                    "firmware/ctl/command.h", "hal/*.h"],
    "firmware/app/": FLIGHT_PARTS + ["protocol/", "hal/*.h"],
    "firmware/app/image/": FLIGHT_PARTS + ["firmware/app/", "protocol/", "hal/*.h", "hal/cortex_m/"],
    "firmware/companion/": FLIGHT_PARTS + ["firmware/app/", "protocol/", "hal/*.h", "hal/linux/"],
    "host_tests/": PRODUCT + ["host_tests/"],
    "host_tests/sim/world/": PRODUCT,
    "host_tests/sim/sensor_faults/": PRODUCT + ["host_tests/sim/world/"],
    "host_tests/sim/autopilot/": PRODUCT + ["host_tests/sim/world/", "host_tests/sim/sensor_faults/"],
    "host_tests/sim/ports/": PRODUCT + ["host_tests/sim/world/", "host_tests/sim/autopilot/", "host_tests/sim/sensor_faults/"],
    "host_tests/sim/body/": PRODUCT + ["host_tests/sim/world/"],
    "host_tests/lab/plot/": PRODUCT + ["host_tests/lab/*.h"],
    "host_tests/lab/logs/": PRODUCT + ["host_tests/lab/*.h"],
    ROOM: LAB + [ROOM],
    ROOM + "data/": ANSWER + [ROOM + "model/axis/axis_blocks.h"],
    ROOM + "model/": LAB,
    ROOM + "model/axis/": ANSWER + SHARED + [ROOM + "selection/selection.h", ROOM + "axis_problem.h"],
    ROOM + "model/translation/": ANSWER + SHARED + [ROOM + "residual_tests/translation/"],
    ROOM + "residual_tests/": PRODUCT + [ROOM + "model/*.h", ROOM + "model/axis/free_run.h", "host_tests/lab/printed.h"],
    ROOM + "residual_tests/axis/": ANSWER + SHARED + [ROOM + "model/axis/", ROOM + "axis_problem.h"],
    ROOM + "residual_tests/translation/": ANSWER + SHARED + [ROOM + "model/translation/"],
    ROOM + "selection/": ANSWER + SHARED,
    ROOM + "output/": LAB + [ROOM + "request.h", "host_tests/lab/plot/"],
    ROOM + "paper/": LAB + [ROOM + "model/*.h"],
}

# A library whose headers cost more than what uses them -> the only file that may include them; others use its header.
ONE_FILE = {"CLI/": "firmware/companion/command_line.cpp", "toml++/": "firmware/companion/files/text/toml_text.cpp",
            "nlohmann/": "firmware/companion/files/text/json.cpp"}

# Parts that run before the first tick or beside it, on a host: they may use the whole library.
HOST_PARTS = ("firmware/companion/", "hal/linux/", "hal/mock/")
ROOMS = ("firmware/", "protocol/", "hal/", "host_tests/", "linker/")
SOURCES = (".h", ".hpp", ".hh", ".inc", ".ipp", ".tpp", ".cpp", ".cc", ".cxx", ".c")
INCLUDE = re.compile(r'\s*#\s*include\s*["<]([^">]+)[">]')
# Includes that this line-by-line check cannot judge: a macro instead of the name, include_next, import and modules.
OTHER_INCLUDE = re.compile(r'\s*#\s*(?:include(?!\s*["<])|include_next|import)\b|\s*(?:export\s+)?import\s+["<\w]')
HEAP_HEADERS = re.compile(r"\s*#\s*include\s*<(vector|string|map|set|list|deque|memory|functional|iostream|fstream|sstream|"
                          r"unordered_map|unordered_set|regex|thread|mutex|future|any|exception|stdexcept)>")
LIBM = re.compile(r"std::(sin|cos|tan|asin|acos|atan|atan2|exp|exp2|log|log2|log10|pow|hypot|cbrt|sinh|cosh|tanh)f?\(")
HEAP_WORDS = re.compile(r"\b(new\s+\w|delete\s|malloc\(|throw\b|dynamic_cast|std::chrono::(steady|system)_clock)")


def rule_of(path):
    """-> the longest folder of the table that contains the file, or None."""
    folders = [folder for folder in LAYERS if path.startswith(folder)]
    return max(folders, key=len) if folders else None


def permitted(path, included):
    folder = rule_of(path)
    if folder is None or ".." in included.split("/"):
        return False
    if rule_of(included) == folder:
        return True
    for entry in LAYERS[folder]:
        if entry.endswith("/*.h"):
            if re.fullmatch(re.escape(entry[:-3]) + r"\w+\.h", included):
                return True
        elif included == entry or (entry.endswith("/") and included.startswith(entry)):
            return True
    return False


def offences(path, lines):
    real_time = path.startswith(("firmware/", "protocol/", "hal/")) and not path.startswith(HOST_PARTS)
    for number, line in enumerate(lines, 1):
        code = line.split("//")[0]
        include = INCLUDE.match(line)
        if include and "<" not in include.group(0) and not permitted(path, include.group(1)):
            yield number, f"may not include {include.group(1)}"
        if include and "<" in include.group(0) and include.group(1).startswith(ROOMS):
            yield number, f"includes {include.group(1)} as a system header: write it in quotes"
        if OTHER_INCLUDE.match(line) and "Deviation:" not in line:
            yield number, f"include that the table of layers cannot check: {line.strip()}"
        eigen = include and include.group(1).startswith("Eigen/")
        if eigen and path != "firmware/core/eigen.h" and not path.startswith("host_tests/"):
            yield number, "include Eigen through firmware/core/eigen.h only"
        for library, only in ONE_FILE.items():
            if include and include.group(1).startswith(library) and path != only:
                yield number, f"only {only} may include {include.group(1)}"
        if "Deviation:" in line or not real_time:
            continue
        if HEAP_HEADERS.match(line):
            yield number, f"header not allowed in real-time code: {line.strip()}"
        if LIBM.search(code) and not path.startswith("firmware/core/maths"):
            yield number, "libm differs between machines: use firmware/core/maths.h"
        if HEAP_WORDS.search(code) and "= delete" not in code:
            yield number, f"not allowed in real-time code: {HEAP_WORDS.search(code).group(0).strip()}"


def self_test():
    """Tests the check itself: it must find each of these lines."""
    planted = [
        ("firmware/est/x.h", '#include "protocol/dji/telemetry.h"'),
        ("firmware/ctl/x.cpp", '#include "firmware/vrc/sticks.h"'),
        ("protocol/x.h", '#include "hal/uart.h"'),
        ("hal/linux/x.cpp", '#include "hal/mock/mock_uart.h"'),
        ("hal/x.h", '#include "hal/linux/serial_port.h"'),
        ("firmware/app/flight_controller.h", '#include "hal/linux/linux_uart.h"'),
        ("firmware/app/x.cpp", '#include "firmware/companion/files/vehicle_file.h"'),
        ("firmware/app/x.cpp", '#include "hal/mock/uart_pair.h"'),
        ("firmware/app/x.cpp", '#include "hal/cortex_m/cmsdk_uart.h"'),
        ("firmware/app/x.cpp", '#include "firmware/app/image/board_course.h"'),
        ("firmware/link/x.cpp", '#include "firmware/app/sensor_adapter.h"'),
        ("firmware/link/x.cpp", '#include "firmware/est/estimate.h"'),
        ("firmware/link/x.cpp", '#include "firmware/ctl/law/flight_law.h"'),
        ("firmware/link/x.cpp", '#include "firmware/mpc/problem.h"'),
        ("firmware/companion/x.cpp", '#include "hal/cortex_m/uart.h"'),
        ("firmware/companion/x.cpp", '#include "host_tests/sim/world/plant.h"'),
        ("firmware/ctl/x.cpp", '#include "protocol/dji/commands.h"'),
        ("firmware/new_room/x.cpp", '#include "firmware/core/time.h"'),
        ("host_tests/sim/world/x.h", '#include "host_tests/sim/autopilot/n1_autopilot.h"'),
        ("host_tests/sim/autopilot/x.h", '#include "host_tests/sim/ports/world.h"'),
        ("host_tests/lab/logs/x.h", '#include "host_tests/lab/identify/request.h"'),
        ("host_tests/lab/identify/model/axis/x.cpp", '#include "host_tests/lab/identify/model/translation/translation_family.h"'),
        ("host_tests/lab/identify/selection/x.h", '#include "host_tests/lab/identify/translation_problem.h"'),
        ("host_tests/lab/identify/residual_tests/axis/x.h", '#include "host_tests/lab/identify/translation_problem.h"'),
        ("host_tests/lab/identify/residual_tests/x.h", '#include "host_tests/lab/identify/output/result.h"'),
        ("firmware/link/x.h", "#include <string>"),
        ("firmware/mpc/x.h", '#include "host_tests/lab/x.h"'),
        ("firmware/est/x.h", '#include "firmware/est/../link/x.h"'),
        ("firmware/est/x.h", '#include "../link/serial_link.h"'),
        ("firmware/est/x.h", '#include "firmware/nowhere/x.h"'),
        ("firmware/est/x.h", '#  include "protocol/dji/telemetry.h"'),
        ("firmware/est/x.h", '#include"protocol/dji/telemetry.h"'),
        ("firmware/est/x.h", "#include <protocol/dji/telemetry.h>"),
        ("firmware/est/x.h", "#include M100_A_HEADER"),
        ("firmware/est/x.h", "import protocol;"),
        ("firmware/est/x.inc", '#include "protocol/dji/telemetry.h"'),
        ("firmware/est/x.h", "#include <Eigen/Dense>"),
        ("firmware/est/x.h", "#include <vector>"),
        ("host_tests/lab/mpc/command.cpp", "#include <CLI/CLI.hpp>"),
        ("firmware/companion/command_line.h", "#include <CLI/App.hpp>"),
        ("host_tests/unit/x.cpp", "#include <toml++/toml.h>"),
        ("host_tests/lab/x.cpp", "#include <nlohmann/json.hpp>"),
        ("firmware/est/x.cpp", "  return std::sin(x);"),
        ("firmware/est/x.cpp", "  throw 3;"),
        ("firmware/est/x.cpp", "  auto* p = new int;"),
    ]
    sound = [
        ("firmware/est/x.h", '#include "firmware/est/filter/kalman.h"'),
        ("firmware/est/x.h", "#include <array>"),
        ("firmware/companion/command_line.cpp", "#include <CLI/CLI.hpp>"),
        ("firmware/companion/files/text/json.cpp", "#include <nlohmann/json.hpp>"),
        ("firmware/est/x.h", "// an import of goods"),
        ("host_tests/target/x.cpp", "#include M100_A_HEADER  // Deviation: the board decides"),
    ]
    missed = [p for p in planted if not list(offences(p[0], [p[1]]))]
    wrong = [p for p in sound if list(offences(p[0], [p[1]]))]
    for path, line in missed:
        print(f"self-test: not found: {path}: {line}")
    for path, line in wrong:
        print(f"self-test: refused though it is allowed: {path}: {line}")
    return 1 if missed or wrong else 0


def main():
    if "--self-test" in sys.argv:
        return self_test()
    root = pathlib.Path(sys.argv[1])
    count = found = 0
    for folder in ("firmware", "hal", "protocol", "host_tests"):
        for file in sorted((root / folder).rglob("*")):
            if file.suffix not in SOURCES:
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
