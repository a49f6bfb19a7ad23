# SPDX-License-Identifier: BSD-3-Clause
"""Instructions on x86-64, counted by callgrind: parts of a tick, solves of the MPC, bytes of the parser.

Another processor or another build of the C library changes such a count slightly: differences up to 2 % are ignored.
"""
import re

from measure.lab_figures import table
from measure.marked import Figure
from measure.workspace import Source

SPREAD = 0.02
PARTS = {"axis": "observer, one horizontal axis: prediction; updates with tilt, rate and a pose 20 ms old",
         "ekf": "whole observer: both axes, height, yaw, attitude to tilt",
         "law": "control law, moving reference: two predictions, two MPC programs by table, height, yaw",
         "window": "reference window of 21 points in x and y",
         "sticks": "command to four sticks"}
SCALARS = {"double": "double", "float": "float", "fixed": "fixed point"}


def needs_callgrind(workspace):
    workspace.tool("valgrind")


def spaced(number):
    return f"{int(number):,}".replace(",", " ")


def parts_of_a_tick(workspace):
    needs_callgrind(workspace)
    program = workspace.program("host_tests/property/tick_cost", ("host-release",))
    printed = workspace.run("host_tests/benchmark/tick_parts.sh", program)
    counts = {(part, scalar): f"{spaced(median)} / {spaced(worst)}" for part, scalar, median, worst in
              re.findall(r"^(\w+) (\w+)\s+\d+ ticks\s+median\s+(\d+)\s+worst\s+(\d+)", printed, re.MULTILINE)}
    rows = [["part (argument of `tick_cost`)"] + list(SCALARS.values())]
    for part in dict.fromkeys(part for part, _ in counts):
        rows.append([f"{PARTS.get(part, part)} (`{part}`)"] + [counts.get((part, scalar), "") for scalar in SCALARS])
    return {"cost.parts": Figure(table(*rows).text, SPREAD)}


PATH = re.compile(r"^(\w+)\s+(\d+) solves\s+median\s+(\d+)\s+p99\s+(\d+)\s+worst\s+(\d+)", re.MULTILINE)


def solves(workspace):
    needs_callgrind(workspace)
    program = workspace.program("host_tests/benchmark/mpc_instructions", ("host-release",))
    rows = [["mode", "path", "solves", "median", "99th percentile", "worst"]]
    for mode, scalar in (("flight", "double"), ("flight", "float")):
        counts = {path: numbers for path, *numbers in PATH.findall(
            workspace.run("host_tests/benchmark/mpc_instructions.sh", program, mode, scalar))}
        for path in sorted(counts):
            rows.append([f"`{mode} {scalar}`", path.replace("_", " ")] + [spaced(number) for number in counts[path]])
    return {"cost.solves": Figure(table(*rows).text, SPREAD)}


STREAMS = {"clean_142_byte_frames": "telemetry, 142-byte frames back to back", "random_bytes": "random bytes",
           "runs_of_start_bytes": "runs of 0xAA",
           "headers_of_1023": "headers with a valid CRC16 and LEN 1023, one after the other",
           "densest_headers": "headers of at most 160 bytes as dense as possible, every 8 bytes",
           "frames_behind_false_headers": "good frames, each after a header with LEN 1023"}


def streams(workspace):
    workspace.tool("valgrind")
    program = workspace.program("host_tests/benchmark/benchmark_protocol", ("host-release",))
    printed = workspace.run("host_tests/benchmark/instructions.sh", program, may_fail=True)
    counts = re.findall(r"^(\w+)\s+([\d.]+) instructions per byte", printed, re.MULTILINE)
    clean = float(counts[0][1])
    rows = [["stream", "instructions per byte", "ratio to clean telemetry"]]
    rows += [[STREAMS.get(name, name), f"{float(count):.1f}", f"{float(count) / clean:.1f}"] for name, count in counts]
    return {"cost.streams": Figure(table(*rows).text, 0.05)}


MAVLINK_STREAMS = {"clean": "ATT_POS_MOCAP frames back to back", "random": "random bytes",
                   "starts": "runs of one start byte", "frames": "good frames after and inside the claims of false headers",
                   "headers": "false headers of any length, flags and gap",
                   "densest": "headers of known messages as dense as possible, four in 11 bytes",
                   "climbed": "patterns improved byte by byte", "mixture": "mixtures of these"}


def mavlink_streams(workspace):
    """The most expensive of 20 streams of each family."""
    workspace.tool("valgrind")
    program = workspace.program("host_tests/benchmark/worst_mavlink_stream", ("host-release",))
    printed = workspace.run("host_tests/benchmark/worst_stream.sh", program, "20", "50", may_fail=True)
    counts = dict(re.findall(r"^(\w+)\s+dearest of \d+: ([\d.]+) instructions", printed, re.MULTILINE))
    rows = [["stream", "instructions per byte"]]
    rows += [[text, f"{float(counts[name]):.1f}"] for name, text in MAVLINK_STREAMS.items()]
    return {"cost.mavlink_streams": Figure(table(*rows).text, 0.05)}


SOURCES = [Source(("cost.parts",), parts_of_a_tick), Source(("cost.solves",), solves),
           Source(("cost.streams",), streams, quick=False),
           Source(("cost.mavlink_streams",), mavlink_streams, quick=False)]
