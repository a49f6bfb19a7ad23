#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Flies the tasks of `m100-lab experiments` over a range of one setting and prints a table, simulated.

Usage: studies.py rates|motion M100_LAB VEHICLE.toml [--seeds N] [-- more options of experiments, such as --plant P.toml]
  rates   tracking error at each command rate of both channels
  motion  motion of the tilt commands and tracking error over a range of input weights of the mode `field`
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

RATES = [("virtual_rc", 5), ("virtual_rc", 10), ("virtual_rc", 25), ("virtual_rc", None),
         ("movement", 10), ("movement", 25), ("movement", 50), ("movement", None)]  # None: the paper's 100 Hz, asked for by name
FACTORS = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0)  # of the vehicle file's input weight
CHANNELS = {"virtual_rc": "Virtual RC", "movement": "movement"}


def flown(lab, task, *words):
    """-> {air: the task's errors} of one run. RuntimeError, with what it said, if a flight never obtained control."""
    with tempfile.TemporaryDirectory() as folder:
        answer = pathlib.Path(folder) / "answer.json"
        done = subprocess.run([str(word) for word in (lab, "experiments", "--only", task, "--json", answer, *words)],
                              capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(done.stderr.strip().splitlines()[-1])
        return json.loads(answer.read_text())[task]


def rates(lab, vehicle, words=(), tasks=("hover", "step", "trajectory")):
    """-> [(channel, rate in Hz or None, {(task, air): errors})]"""
    rows = []
    for channel, rate_hz in RATES:
        speed = ["--rate", rate_hz] if rate_hz else ["--paper-100-hz"]
        flights = {task: flown(lab, task, "--vehicle", vehicle, "--channel", channel, *speed, *words) for task in tasks}
        rows.append((channel, rate_hz, {(task, air): cell for task, airs in flights.items() for air, cell in airs.items()}))
    return rows


def rates_table(rows):
    """-> rows of text: pose error in m, root mean square."""
    table = [["channel and rate", *(f"{task}, {air}" for task, air in rows[0][2])]]
    for channel, rate_hz, cells in rows:
        speed = f"{rate_hz} Hz" if rate_hz else "100 Hz by name"
        table.append([f"{CHANNELS[channel]}, {speed}", *(f"{cell['pose_m']:.4f}" for cell in cells.values())])
    return table


def motion(lab, vehicle, words=()):
    """-> [(input weight, {task: errors in calm air})]"""
    text = pathlib.Path(vehicle).read_text()
    section = re.search(r"^\[design\.mpc\](.*?)^input = ([\d.e+-]+)$", text, re.DOTALL | re.MULTILINE)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for factor in FACTORS:
            weight = factor * float(section[2])
            changed = pathlib.Path(folder) / "vehicle.toml"
            changed.write_text(text[:section.start(2)] + repr(weight) + text[section.end(2):])
            rows.append((weight, {task: flown(lab, task, "--vehicle", changed, *words)["calm"] for task in ("hover", "trajectory")}))
    return rows


def motion_table(rows):
    """-> rows of text: motion of both tilt commands together, pose error, root mean square."""
    table = [["input weight", "hover: command [deg/s]", "pose [m]", "square: command [deg/s]", "pose [m]"]]
    for weight, cells in rows:
        table.append([f"{weight:.3g}"] + [text for cell in cells.values() for text in (
            f"{cell['input_variation_deg_s']:.0f}", f"{cell['pose_m']:.4f}")])
    return table


STUDIES = {"rates": (rates, rates_table), "motion": (motion, motion_table)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", choices=STUDIES)
    parser.add_argument("lab")
    parser.add_argument("vehicle")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("more", nargs="*")
    asked = parser.parse_args()
    fly, table = STUDIES[asked.study]
    try:
        rows = fly(asked.lab, asked.vehicle, ("--seeds", asked.seeds, *asked.more))
    except RuntimeError as refused:
        sys.exit(f"studies.py: {refused}")
    for row in table(rows):
        print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main()
