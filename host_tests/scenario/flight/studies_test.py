#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tracking error at each command rate, and over the input weight, as in the tables of experiments/README.md.

Usage: studies_test.py M100_LAB VEHICLE.toml, and the path of lab/experiments/studies.py
"""
import importlib.util
import pathlib
import sys
import tempfile


def rate_offences(studies, lab, vehicle):
    """A rate that never reaches the wire (rows are equal), and one that costs more than its delay explains."""
    before = {}
    for channel, rate_hz, cells in studies.rates(lab, vehicle, tasks=("hover",)):
        for key, cell in cells.items():
            name = f"{channel} at {rate_hz} Hz, {key}: {cell['pose_m']:.4f} m"
            if cell["pose_m"] > cell["paper"]["pose_m"]:
                yield f"{name}: worse than the paper's {cell['paper']['pose_m']} m"
            if cell["off_nominal_share"] > 0.0:
                yield f"{name}: off the failsafe's top for {cell['off_nominal_share']:.1%} of the flight"
            slower_m = before.get((channel, key))
            if slower_m and not 0.7 * slower_m < cell["pose_m"] < slower_m:
                yield f"{name}: {slower_m:.4f} m at the next slower rate"
            before[channel, key] = cell["pose_m"]


def motion_offences(studies, lab, vehicle):
    """A weight that never reaches the gain table, and calm commands without any cost in tracking error."""
    rows = studies.motion(lab, vehicle)
    for (weight, cells), (heavier, after) in zip(rows, rows[1:]):
        for task in cells:
            if cells[task]["off_nominal_share"] > 0.0:
                yield f"{task}: off the failsafe's top with the weight {weight:g}"
            if not after[task]["input_variation_deg_s"] < cells[task]["input_variation_deg_s"]:
                yield f"{task}: the command does not move less with the weight {heavier:g} than with {weight:g}"
    if not rows[-1][1]["hover"]["pose_m"] > rows[0][1]["hover"]["pose_m"]:
        yield "hover: the heaviest weight costs no tracking error"


def refusal_offences(studies, lab, vehicle):
    """A flight that never began and counts as one without an error."""
    with tempfile.TemporaryDirectory() as folder:
        blind = pathlib.Path(folder) / "blind.toml"
        blind.write_text("[pose]\ndropout_per_s = 100.0\n")
        for study in (studies.rates, studies.motion):
            try:
                study(lab, vehicle, ("--plant", blind))
                yield f"{study.__name__}: no word of flights that never obtained control"
            except RuntimeError as refused:
                if "never obtained control" not in str(refused):
                    yield f"{study.__name__}: {refused}"


def main():
    lab, vehicle, file = sys.argv[1:]
    spec = importlib.util.spec_from_file_location("studies", file)
    studies = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(studies)
    found = [one for test in (rate_offences, motion_offences, refusal_offences) for one in test(studies, lab, vehicle)]
    print("\n".join(found + [f"{len(found)} offences"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
