# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of the first page that other pages show, too: read there, where a measurement has written them."""
import re

from measure import marked
from measure.marked import Figure
from measure.workspace import Source

PROMISES, THREATS, MPC = "firmware/safety/PROMISES.md", "firmware/safety/THREATS.md", "firmware/mpc/README.md"
TESTS = "host_tests/README.md"


def figure_of(workspace, page, name):
    """-> text of a figure on another page"""
    for found in marked.MARKED.finditer((workspace.root / page).read_text()):
        if found["name"] == name:
            return found["text"].strip()
    raise ValueError(f"{page} does not show the figure {name}")


def first(pattern, text):
    found = re.search(pattern, text)
    if not found:
        raise ValueError(f"'{pattern}' is not in: {text[:200]}")
    return found[1]


def delay_margins(workspace):
    """-> the smallest delay margins of mode field over both channels: nominal, and with gain and frequency 20 % off [ms]"""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in figure_of(workspace, MPC, "mpc.corners").splitlines()]
    field = [row for row in rows if row[0] == "`field`"]
    return [min(int(row[rows[0].index("delay margin [ms]", start)]) for row in field) for start in (0, 4)]


def numbers(workspace):
    nominal, corner = delay_margins(workspace)
    hover, motion = (first(r"([\d.]+ m/s)", figure_of(workspace, THREATS, name)) for name in ("smallest.drift", "motion.drifts"))
    drawn = [figure_of(workspace, THREATS, name) for name in ("motion.drawn", "motion.turning")]
    faults, fast = (sum(int(first(pattern, text)) for text in drawn) for pattern in (r"of (\d+) handed over", r"(\d+) at 1\.0 m/s"))
    fastest = max(float(first(r"at most at ([\d.]+) m/s", text)) for text in drawn)
    promise = " ".join((workspace.root / PROMISES).read_text().split())
    return {"first.release": Figure(first(r"within ([\d.]+ s) of the death or the hang of the program", promise)),
            "first.drift": Figure(f"{hover} in hover, {motion} if it begins in a motion"),
            "first.handed_over": Figure(f"after {faults} drawn faults it was at 1 m/s or faster {fast} times, at most at {fastest} m/s"),
            "first.main_job": Figure(figure_of(workspace, TESTS, "run.main_job")),
            "first.margins": Figure(f"{nominal} ms of delay margin become {corner} ms if gain and frequency are 20 % off")}


SOURCES = [Source(("first.",), numbers)]
