#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests the matrix of matrix.py with an invented answer: a world in which nothing flew has no tilt, but keeps its row."""
import sys

from matrix import AGES, JITTERS_MS, LATENCIES_MS, name, rows


def world(stayed, tilt_deg):
    return {"stayed": stayed, "flights": 6, "oscillating": 0, "tasks": {"hover": {"tilt_rms_deg": tilt_deg}}}


def main():
    worlds = {name(latency_ms, jitter_ms, age): world(6, 0.5 + 0.1 * number)
              for latency_ms in LATENCIES_MS for jitter_ms in JITTERS_MS for number, age in enumerate(AGES)}
    most_deg = 0.5 + 0.1 * (len(AGES) - 1)
    worlds[name(LATENCIES_MS[0], JITTERS_MS[0], AGES[0])] = world(0, None)
    for age in AGES:
        worlds[name(LATENCIES_MS[-1], JITTERS_MS[-1], age)] = world(0, None)
    matrix = rows({"worlds": worlds})
    flights = 6 * len(AGES)
    cells = {"one age did not fly": (matrix[1][1], f"{flights - 6} of {flights}, 0 swing, {most_deg:.2f} deg"),
             "all flew": (matrix[1][2], f"{flights} of {flights}, 0 swing, {most_deg:.2f} deg"),
             "none flew": (matrix[-1][-1], f"0 of {flights}, 0 swing, none flew")}
    wrong = [f"{case}: '{is_}' instead of '{wanted}'" for case, (is_, wanted) in cells.items() if is_ != wanted]
    print("\n".join(wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
