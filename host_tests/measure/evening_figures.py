# SPDX-License-Identifier: BSD-3-Clause
"""Seven whole evenings (soak.evening): each error of each aircraft, before and after the correction."""
import json
import pathlib
import tempfile

from measure.lab_figures import LAB, table
from measure.workspace import Source

TEST = "host_tests/lab/evening/evening_test.py"
M100 = "firmware/companion/m100"
# Row title, names of its two numbers in evening.json, and the factor from their unit to the printed one.
ROWS = (("distance from the course [cm]", "pose_m.course", "pose_m.corrected", 100.0),
        ("its horizontal part [cm]", "horizontal_m.course", "horizontal_m.corrected", 100.0),
        ("its vertical part [cm]", "height_m.course", "height_m.corrected", 100.0),
        ("heading [deg]", "heading_deg.course", "heading_deg.corrected", 1.0),
        ("roll, predicted 1 s ahead [mrad]", "ahead.roll.before", "ahead.roll.after", 1000.0),
        ("pitch, predicted 1 s ahead [mrad]", "ahead.pitch.before", "ahead.pitch.after", 1000.0),
        ("climb speed, predicted 1 s ahead [mm/s]", "ahead.climb.before", "ahead.climb.after", 1000.0),
        ("yaw rate, predicted 1 s ahead [mrad/s]", "ahead.yaw_rate.before", "ahead.yaw_rate.after", 1000.0))


def shown(value):
    return f"{value:.2f}" if value < 10.0 else f"{value:.1f}"


def titled(name, numbers):
    return f"{name}, swings before" if numbers.get("calm_law.course") else name


def errors(evenings):
    """-> rows of the table. The folder holds one folder for each evening; columns are in the order of their names."""
    flown = {file.parent.parent.name: json.loads(file.read_text())["numbers"]
             for file in sorted(pathlib.Path(evenings).glob("*/*/evening.json"))}
    return [["root mean square, before -> after", *(titled(*one) for one in flown.items())]] + [
        [words, *(f"{shown(times * numbers[before])} -> {shown(times * numbers[after])}" for numbers in flown.values())]
        for words, before, after, times in ROWS]


def whole_evenings(workspace):
    with tempfile.TemporaryDirectory() as folder:
        workspace.run("python3", TEST, workspace.program(M100), workspace.program(LAB), "--whole", folder)
        return {"evening.errors": table(*errors(pathlib.Path(folder) / "evenings"))}


SOURCES = [Source(("evening.",), whole_evenings, quick=False)]
