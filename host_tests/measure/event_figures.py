# SPDX-License-Identifier: BSD-3-Clause
"""Events in the measured flights that are neither a lasting change nor an effect: what identify says of them."""
import collections
import csv
import math
import pathlib
import random
import tempfile

from measure.identify_figures import asked_of
from measure.lab_figures import MEASURED, compact_table
from measure.workspace import Source

COLUMN = {"roll": ("rc_roll", "odom_roll_rad"), "pitch": ("rc_pitch", "odom_pitch_rad")}
DECLARED = ("second_order", "trim_offset", "lead_zero", "dead_zone", "transport_delay")
RANGES = (("--train", "12:38", "--validate", "38:55.5"), ("--train", "30:55.5", "--validate", "12:30"))
CENTRE, FIRST_S, LAST_S = 1024.0, 14.0, 52.0
TIMES = 6  # of each event, axis and half
SEEN_COUNTS = 40.0  # an event of a stick that moves less is none
ROWS_A_SECOND = 100


def lost(draw, stick, response, first):
    """The stick is logged at its centre for one to three seconds."""
    last = first + draw.choice((1, 2, 3)) * ROWS_A_SECOND
    return stick[:first] + [CENTRE] * (last - first) + stick[last:], response


def frozen(draw, stick, response, first):
    """The stick is logged with one value for one to three seconds."""
    last = first + draw.choice((1, 2, 3)) * ROWS_A_SECOND
    return stick[:first] + [stick[first]] * (last - first) + stick[last:], response


def late(draw, stick, response, first):
    """From here on the stick is logged 0.15 s late."""
    return stick[:first] + stick[first - 15:-15], response


def jump(draw, stick, response, first):
    """From here on the response has another zero."""
    size = draw.choice((-0.04, -0.02, 0.02, 0.04))
    return stick, response[:first] + [value + size for value in response[first:]]


def gust(draw, stick, response, first):
    """The response is pushed away for a second."""
    size = draw.choice((-0.06, 0.06))
    return stick, [value + size * math.exp(-0.5 * ((row - first) / (0.5 * ROWS_A_SECOND)) ** 2) for row, value in enumerate(response)]


EVENTS = {"stick lost": lost, "stick frozen": frozen, "stick late": late, "response jumps": jump, "gust": gust}


def logs_of(draw, event, stick, response, time_s):
    """-> logs with the event at a drawn time; events that the log does not show are drawn again"""
    while True:
        begins_s = draw.uniform(FIRST_S, LAST_S)
        first = next(row for row, at_s in enumerate(time_s) if at_s > begins_s)
        moved = event(draw, stick, response, first)
        if moved[1] != response or max(abs(a - b) for a, b in zip(moved[0], stick)) > SEEN_COUNTS:
            return moved


def events(workspace):
    draw = random.Random(7)
    counts = collections.defaultdict(collections.Counter)
    for axis, columns in COLUMN.items():
        with open(workspace.measured_log(MEASURED[axis][1]), encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        places = [head.index(name) for name in columns]
        time_s = [float(row[0]) for row in rows]
        measured = [[float(row[place]) for row in rows] for place in places]
        for name, event in EVENTS.items():
            for number in range(TIMES * len(RANGES)):
                changed = logs_of(draw, event, *measured, time_s)
                with tempfile.TemporaryDirectory() as folder:
                    log = pathlib.Path(folder) / "log.csv"
                    with open(log, "w", encoding="utf-8", newline="") as file:
                        out = csv.writer(file)
                        out.writerow(head)
                        for row, cells in enumerate(rows):
                            out.writerow([f"{changed[places.index(k)][row]:.9g}" if k in places else cell for k, cell in enumerate(cells)])
                    result = asked_of(workspace, axis, DECLARED, RANGES[number % len(RANGES)], log=log)
                named = {change["name"] for change in result["changes"]} | {effect["name"] for effect in result["effects"]}
                answer = f"explained: {', '.join(sorted(named))}" if result["verdict"] == "explained" else result["verdict"]
                counts[name][answer] += 1
    rows = [[name, str(sum(found.values())), str(found["unexplained"]), str(found["nothing_missing"]),
             ", ".join(f"{answer.removeprefix('explained: ')} {count}" for answer, count in sorted(found.items()) if answer.startswith("explained")) or "-"]
            for name, found in counts.items()]
    return {"identify.events": compact_table(["event", "logs", "unexplained", "clean bill", "explained by"], *rows)}


SOURCES = [Source(("identify.events",), events, quick=False)]
