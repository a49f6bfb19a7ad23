# SPDX-License-Identifier: BSD-3-Clause
"""Figures of m100-lab campaign: the shipped worlds, the matrix of tolerable properties of the pose source, and aircraft
that differ from the vehicle file."""
import json
import pathlib
import sys
import tempfile

from measure.lab_figures import LAB, table
from measure.marked import Figure
from measure.workspace import Source

WORLDS = "host_tests/lab/campaign/worlds"
MATRIX = "host_tests/scenario/campaign/matrix.py"
HEALTHY = "host_tests/scenario/campaign/healthy.py"
HELD_OUT = "host_tests/scenario/campaign/held_out.py"
STORM = "host_tests/scenario/campaign/storm.py"
CHANGES = "host_tests/scenario/campaign/changes.py"


def number(value, digits=2):
    return "" if value is None else f"{value:.{digits}f}"


def world_rows(report):
    rows = [["world", "stayed", "coasted", "oscillating", "worst tilt [deg]", "hover: pose, median [m]", "hover: tilt [deg]",
             "hover: command rate [deg/s]", "NEES", "NIS"]]
    for name, world in report["worlds"].items():
        hover = world["tasks"]["hover"]
        rows.append([name.replace("_", " "), f"{world['stayed']} of {world['flights']}", str(world["coasted"]),
                     str(world["oscillating"]), f"{world['worst_tilt_deg']:.1f}", number(hover["pose_rms_m"]["median"], 3),
                     number(hover["tilt_rms_deg"]), number(hover["command_deg_s"], 0), number(world["nees"]),
                     number(world["nis"])])
    return rows


def drawn_worlds(workspace):
    """Flights in worlds drawn at random (healthy, held out, storm): the summary line of each script."""
    last = {name: workspace.run(sys.executable, pathlib.Path(workspace.root) / script, workspace.program(LAB), *options,
                            may_fail=True).strip().splitlines()[-1]
            for name, script, options in (("drawn.healthy", HEALTHY, ("--seed", "7001")),
                                          ("drawn.held_out", HELD_OUT, ("--seed", "41")),
                                          ("drawn.storm", STORM, ("--seed", "41")))}
    return {name: Figure(line) for name, line in last.items()}


def campaigns(workspace):
    """The shipped worlds with ten seeds of each task, and the matrix with six."""
    with tempfile.TemporaryDirectory() as folder:
        shipped, matrix = pathlib.Path(folder) / "shipped.json", pathlib.Path(folder) / "matrix.json"
        paths = sorted((pathlib.Path(workspace.root) / WORLDS).glob("*.toml"))
        # The answer "not all stayed" is a figure, too.
        workspace.run(workspace.program(LAB), "campaign", *paths, "--json", shipped, may_fail=True)
        printed = workspace.run(pathlib.Path(workspace.root) / MATRIX, workspace.program(LAB), "--record", matrix)
        worlds = json.loads(shipped.read_text())
    cells = [[cell.strip() for cell in line.split("|")] for line in printed.splitlines() if "|" in line]
    found = [line for line in printed.splitlines() if "|" not in line]
    return {"campaign.worlds": table(*world_rows(worlds)), "campaign.matrix": table(*cells),
            "campaign.latency": Figure("; ".join(found))}


def joined(rows):
    """-> the table with one row for all changes that have the same counts"""
    counts = {}
    for change, *same, tilt in rows[1:]:
        counts.setdefault(tuple(same), []).append(f"{change}: {tilt}")
    return table([f"{rows[0][0]}: {rows[0][-1]}", *rows[0][1:-1]], *[["; ".join(changes), *same] for same, changes in counts.items()])


def changed_aircraft(workspace):
    """Flights of aircraft that differ from the vehicle file."""
    # The answer "one swings" is a figure, too.
    printed = workspace.run(pathlib.Path(workspace.root) / CHANGES, workspace.program(LAB), may_fail=True)
    inside = workspace.run(pathlib.Path(workspace.root) / CHANGES, workspace.program(LAB), "--inside", "1000", may_fail=True)
    everything = workspace.run(pathlib.Path(workspace.root) / CHANGES, workspace.program(LAB), "--drawn", "0:500")
    _, flights, left, swing, noticed, _ = (cell.strip() for cell in everything.splitlines()[-1].split("|"))
    return {"changes.drawn": Figure(f"{swing} of {flights} flights swing, and {noticed} of these are noticed in flight; "
                                    f"{left} did not stay"),
            **{name: joined([[cell.strip() for cell in line.split("|")] for line in lines.splitlines() if "|" in line])
               for name, lines in (("changes.map", printed), ("changes.inside", inside))}}


SOURCES = [Source(("campaign.",), campaigns, quick=False), Source(("drawn.",), drawn_worlds, quick=False),
           Source(("changes.",), changed_aircraft, quick=False)]
