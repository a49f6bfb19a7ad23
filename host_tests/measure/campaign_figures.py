# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the program m100-lab campaign: the worlds that ship, the matrix of what the source of pose may be, and
aircraft that are not what the vehicle file says."""
import json
import pathlib
import sys
import tempfile

from measure.lab_figures import LAB, table
from measure.marked import Figure
from measure.place import Source

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
             "hover: command [deg/s]", "NEES", "NIS"]]
    for name, world in report["worlds"].items():
        hover = world["tasks"]["hover"]
        rows.append([name.replace("_", " "), f"{world['stayed']} of {world['flights']}", str(world["coasted"]),
                     str(world["oscillating"]), f"{world['worst_tilt_deg']:.1f}", number(hover["pose_rms_m"]["median"], 3),
                     number(hover["tilt_rms_deg"]), number(hover["command_deg_s"], 0), number(world["nees"]),
                     number(world["nis"])])
    return rows


def drawn_worlds(place):
    """What is flown in worlds that are drawn by number, and in the shipped ones with nothing to be alarmed about."""
    last = {name: place.run(sys.executable, pathlib.Path(place.root) / script, place.program(LAB), *options,
                            may_fail=True).strip().splitlines()[-1]
            for name, script, options in (("drawn.healthy", HEALTHY, ("--seed", "7001")),
                                          ("drawn.held_out", HELD_OUT, ("--seed", "41")),
                                          ("drawn.storm", STORM, ("--seed", "41")))}
    return {name: Figure(line) for name, line in last.items()}


def campaigns(place):
    """The shipped worlds, ten seeds of each task; the matrix, six."""
    with tempfile.TemporaryDirectory() as folder:
        shipped, matrix = pathlib.Path(folder) / "shipped.json", pathlib.Path(folder) / "matrix.json"
        paths = sorted((pathlib.Path(place.root) / WORLDS).glob("*.toml"))
        # An answer of "not all stayed" is a figure too.
        place.run(place.program(LAB), "campaign", *paths, "--json", shipped, may_fail=True)
        printed = place.run(pathlib.Path(place.root) / MATRIX, place.program(LAB), "--record", matrix)
        worlds = json.loads(shipped.read_text())
    cells = [[cell.strip() for cell in line.split("|")] for line in printed.splitlines() if "|" in line]
    found = [line for line in printed.splitlines() if "|" not in line]
    return {"campaign.worlds": table(*world_rows(worlds)), "campaign.matrix": table(*cells),
            "campaign.latency": Figure("; ".join(found))}


def changed_aircraft(place):
    """Aircraft that are not what the vehicle file says."""
    # An answer of "one swings" is a figure too.
    printed = place.run(pathlib.Path(place.root) / CHANGES, place.program(LAB), may_fail=True)
    inside = place.run(pathlib.Path(place.root) / CHANGES, place.program(LAB), "--inside", "1000", may_fail=True)
    everything = place.run(pathlib.Path(place.root) / CHANGES, place.program(LAB), "--drawn", "0:500")
    _, flights, left, swing, noticed, _ = (cell.strip() for cell in everything.splitlines()[-1].split("|"))
    return {"changes.drawn": Figure(f"{swing} of {flights} flights swing, {noticed} of them noticed in flight; {left} did not stay"),
            **{name: table(*[[cell.strip() for cell in line.split("|")] for line in lines.splitlines() if "|" in line])
               for name, lines in (("changes.map", printed), ("changes.inside", inside))}}


SOURCES = [Source(("campaign.",), campaigns, quick=False), Source(("drawn.",), drawn_worlds, quick=False),
           Source(("changes.",), changed_aircraft, quick=False)]
