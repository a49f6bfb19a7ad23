#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Winds that the aircraft cannot hold its place against, drawn by number: nobody gets the sticks of an aircraft in motion.

Usage: storm.py M100_LAB [--worlds N] [--seed S]
Draws N (default 12) winds whose push is 1.05 to 1.5 times the 4.0 m/s^2 that are held against on the worse axis, half of
them with a pose of any kind that is promised, and flies the six tasks in each. Exit 1 where control goes back at 1 m/s
or more. What stays is told, and no fault: a wind across may be held a little longer than promised.
"""
import pathlib
import random
import sys
import tempfile

import held_out

MOST_M_S = 1.0
STRONGER = (1.05, 1.5)


def draw(seed, number):
    dice = random.Random(f"storm {seed} {number}")
    return held_out.air(dice, dice.uniform(*STRONGER) * held_out.MOST_PUSH_M_S2) + (
        held_out.pose(dice) if number % 2 else "")


def main():
    words = sys.argv[1:]
    value = held_out.option_of(words)
    worlds, seed = int(value("--worlds", "12")), int(value("--seed", "1"))
    handed_over, stayed, fast = [], 0, []
    with tempfile.TemporaryDirectory() as scratch:
        for number in range(worlds):
            name = f"storm_{seed}_{number}"
            flown = held_out.report_of(words[0], pathlib.Path(scratch), name, draw(seed, number), "--seed",
                                       str(1000 * seed + number))["flown"]
            stayed += sum(flight["stayed"] for flight in flown)
            given = [flight for flight in flown if flight["handed_over_m_s"] >= 0.0]
            handed_over += [flight["handed_over_m_s"] for flight in given]
            fast += [f"{name}, {flight['task']}: control goes back at {flight['handed_over_m_s']:.2f} m/s, {flight['why']}"
                     for flight in given if flight["handed_over_m_s"] >= MOST_M_S]
    for sentence in fast:
        print(sentence)
    print(f"{6 * worlds} flights: {stayed} stayed, {len(handed_over)} were handed over, "
          f"at most at {max(handed_over, default=0.0):.2f} m/s")
    return 1 if fast or not handed_over else 0


if __name__ == "__main__":
    sys.exit(main())
