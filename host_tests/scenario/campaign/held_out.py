#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Flies in worlds that are drawn from a seed, so that no constant of the flight code can be fitted to them.

Usage: held_out.py M100_LAB [--worlds N] [--seed S] [--keep FOLDER]
Draws N (default 48) worlds, a third of each kind: a pose with any promised latency, jitter, rate, drift and reported
age; wind of any direction up to the control authority; both at once. Flies the six tasks in each, with a seed of its
own, and for comparison a hover in the same air with the measured pose (the kind world). Exit 1 if a flight falls below
coast or leaves its fence, tilts by more than 35 degrees, hovers with more than twice the tilt of the kind world, or if
the observer's errors do not match its covariance (mean NEES of a world outside 0.2 to 3). --keep keeps the files.
"""
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

from changes import value

MAX_TILT_DEG = 35.0
MAX_HOVER_RATIO = 2.0
NEES = (0.2, 3.0)
DRAG_PER_S = 0.3
MAX_FORCE_M_S2 = 4.0  # drag x (mean + gust amplitude), on each axis
GUST_SHARE = 0.3
TURBULENCE_SHARE = 0.15
LATEST_S = 0.140  # latency and jitter together


def pose(dice):
    """-> a pose section. Uniform in each range, but the ends of a range have a raised probability."""
    latency_s = dice.choice((0.0, 0.1, dice.uniform(0.0, 0.1), dice.uniform(0.0, 0.1)))
    jitter_s = min(dice.choice((0.0, 0.04, dice.uniform(0.0, 0.04), dice.uniform(0.0, 0.04))), LATEST_S - latency_s)
    rate_hz = dice.choice((30.0, 240.0, dice.uniform(30.0, 240.0), dice.uniform(30.0, 240.0)))
    return (f"[pose]\nrate_hz = {rate_hz:.1f}\nlatency_s = {latency_s:.4f}\njitter_s = {jitter_s:.4f}\n"
            f"clock_drift_ppm = {dice.uniform(-100.0, 100.0):.1f}\n"
            f"reported_age = \"{dice.choice(('true', 'constant', 'none'))}\"\n"
            f"reported_age_s = {dice.uniform(0.0, 0.1):.4f}\n")


def air(dice, disturbance_m_s2=None):
    """-> an air section. @param disturbance_m_s2 including gusts, on the worse axis; None: drawn, up to MAX_FORCE_M_S2"""
    direction = dice.uniform(0.0, 2.0 * math.pi)
    along, across = math.cos(direction), math.sin(direction)
    disturbance_m_s2 = disturbance_m_s2 or dice.uniform(0.1 * MAX_FORCE_M_S2, MAX_FORCE_M_S2)
    mean_m_s = disturbance_m_s2 / (DRAG_PER_S * (1.0 + GUST_SHARE) * max(abs(along), abs(across)))
    return (f"[air]\nlinear_drag_per_s = {DRAG_PER_S}\nwind_m_s = [{mean_m_s * along:.3f}, {mean_m_s * across:.3f}, 0.0]\n"
            f"gust_m_s = {GUST_SHARE * mean_m_s:.3f}\nturbulence_m_s = {TURBULENCE_SHARE * mean_m_s:.3f}\n")


def draw(seed, number):
    """-> kind, text of its plant file, text of the kind world: the same air with the measured pose"""
    dice = random.Random(f"{seed} {number}")
    kind = ("pose", "wind", "both")[number % 3]
    blows = "# still air\n" if kind == "pose" else air(dice)
    return kind, blows + ("" if kind == "wind" else pose(dice)), blows


def report_of(program, folder, name, text, *options):
    """-> the report of a campaign in one world"""
    path, answer = folder / f"{name}.toml", folder / f"{name}.json"
    path.write_text(text)
    words = [program, "campaign", str(path), "--flights", "1", "--json", str(answer), *options]
    subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    return json.loads(answer.read_text())


def fly(program, folder, name, text, *options):
    """-> the summary of a world's flights"""
    return report_of(program, folder, name, text, *options)["worlds"][name]


def faults(world, kind_hover_deg):
    """-> a sentence for each violated limit"""
    found = [f"{one['task']}, seed {one['seed']}, at {one['at_s']:.2f} s: {one['why']}" for one in world["failures"]]
    if world["worst_tilt_deg"] > MAX_TILT_DEG:
        found.append(f"tilts by {world['worst_tilt_deg']:.1f} degrees")
    hover_deg = world["tasks"]["hover"]["tilt_rms_deg"]
    if hover_deg is not None and kind_hover_deg is not None and hover_deg > MAX_HOVER_RATIO * kind_hover_deg:
        found.append(f"hovers with a tilt of {hover_deg:.2f} degrees, {kind_hover_deg:.2f} in the kind world")
    if world["nees"] is None or not NEES[0] <= world["nees"] <= NEES[1]:
        found.append(f"NEES is {world['nees']}, not {NEES[0]} to {NEES[1]}")
    return found


def main():
    words = sys.argv[1:]
    worlds, seed, wrong = int(value(words, "--worlds", "48")), int(value(words, "--seed", "1")), 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(value(words, "--keep", scratch))
        folder.mkdir(parents=True, exist_ok=True)
        for number in range(worlds):
            kind, text, blows = draw(seed, number)
            flown = ("--seed", str(1000 * seed + number))
            world = fly(words[0], folder, f"{kind}_{seed}_{number}", text, *flown)
            beside = fly(words[0], folder, f"kind_{seed}_{number}", blows, *flown, "--tasks", "hover")
            found = faults(world, beside["tasks"]["hover"]["tilt_rms_deg"])
            wrong += bool(found)
            for sentence in found:
                print(f"{kind}_{seed}_{number}: {sentence}", flush=True)
    print(f"{wrong} of {worlds} worlds, of six tasks each, violate a limit")
    return 1 if wrong or worlds == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
