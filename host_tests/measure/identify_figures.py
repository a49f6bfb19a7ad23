# SPDX-License-Identifier: BSD-3-Clause
"""Figures of identify on adversarial logs, and on measured flights to which an effect was added."""
import json
import pathlib
import re
import tempfile

from measure.lab_figures import LAB, MEASURED, table
from measure.marked import Figure
from measure.workspace import Source

UNSEEN = ("--unseen", "--logs", 10, "--seed", 780000)
KIND = re.compile(r"^(?P<kind>\S.*?) +" + " +".join(rf"(?P<n{k}>\d+)" for k in range(8)) + r" +[\d.]+$")
GROUPS = {"healthy": "^healthy", "a missing effect": "^lacks", "a change in flight": " (changes|grows) |later$"}
MAP = "host_tests/lab/columns/m100_csv.toml"
# The medium sizes of the confusion matrix of simulated logs.
SIZES = {"transport_delay": 0.10, "dead_zone": 20, "gain_asymmetry": 1.25, "trim_offset": 40, "stick_curve": 1.35,
         "backlash": 18, "gain_drift": 0.28, "cross_axis": 0.17}


def unseen(workspace):
    """Logs of unknown vehicles: the answers of identify for each group of kinds, and the shares that have a limit."""
    printed = workspace.run(workspace.program("host_tests/property/identify_adversarial_logs", ("host-release",)), *UNSEEN,
                        may_fail=True)
    head = ["kinds (simulated)", "logs", "right", "undecided", "wrong name", "clean bill", "of these, not visible in the log",
            "healthy refused", "error"]
    groups = {}
    said = []
    for line in printed.splitlines():
        found = KIND.match(line)
        if found:
            name = next((group for group, sign in GROUPS.items() if re.search(sign, found["kind"])), "a fault of the log")
            counts = groups.setdefault(name, [0] * 8)
            groups[name] = [sum(pair) for pair in zip(counts, (int(found[f"n{k}"]) for k in range(8)))]
        elif not line.startswith(("kind ", "processor time")):
            said.append(line.strip())
    if len(groups) < len(GROUPS):
        raise ValueError("the campaign printed no table")
    rows = [[name, *map(str, counts)] for name, counts in groups.items()]
    return {"identify.unseen": table(head, *rows), "identify.unseen_shares": Figure("; ".join(said))}


def untouched(workspace, axis):
    """-> the answer of identify for an unchanged measured flight"""
    with tempfile.TemporaryDirectory() as folder:
        answer = pathlib.Path(folder) / "answer.json"
        _, log, ranges = MEASURED[axis]
        workspace.run(workspace.program(LAB), "identify", "--log", workspace.measured_log(log), "--columns", MAP, "--axis", axis,
                  "--declare", "first_order", *ranges, "--json", answer)
        return json.loads(answer.read_text())


def with_effect(workspace, axis, structure, effect, size):
    """-> the answer of identify for the flight with the effect added; all its other effects are declared"""
    with tempfile.TemporaryDirectory() as folder:
        log, columns, answer = (pathlib.Path(folder) / name for name in ("log.csv", "map.toml", "answer.json"))
        _, flight, ranges = MEASURED[axis]
        declared = ("--axis", axis, "--declare", ",".join(structure))
        workspace.run(workspace.program(LAB), "inject", "--log", workspace.measured_log(flight), "--columns", MAP, *declared,
                  "--train", ranges[1], "--effect", f"{effect}={size}", "--out", log, "--map", columns)
        workspace.run(workspace.program(LAB), "identify", "--log", log, "--columns", columns, *declared, *ranges, "--json", answer)
        return json.loads(answer.read_text())


def by_itself(workspace, axis, structure, effect, parameter):
    """-> the size of the effect in the unchanged flight, fitted together with all its other effects"""
    with tempfile.TemporaryDirectory() as folder:
        answer = pathlib.Path(folder) / "answer.json"
        _, log, ranges = MEASURED[axis]
        workspace.run(workspace.program(LAB), "identify", "--log", workspace.measured_log(log), "--columns", MAP, "--axis", axis,
                  "--declare", ",".join([*structure, effect]), *ranges, "--refits", 0, "--json", answer)
        return json.loads(answer.read_text())["declared"]["parameters"][parameter]


def together(effect, added, own):
    """-> the total size of an added effect and the flight's own one: ratios and exponents multiply, others add"""
    return added * own if effect in ("gain_asymmetry", "stick_curve") else added + own


def names_it(found, effect):
    alike = [group for group in found["not_separable"] if effect in group]
    named = [one["name"] for one in found["effects"]]
    return effect in named or any(name in group for group in alike for name in named)


def injected(workspace):
    """Adds each effect that a measured flight does not have, at medium size."""
    rows = [["flight", "effect", "added", "added and the flight's own", "named", "identified, 95 % interval", "verdict"]]
    right, inside, inside_with_own, numbers = 0, 0, 0, 0
    for axis in MEASURED:
        structure = untouched(workspace, axis)["final"]["structure"]
        for effect, size in SIZES.items():
            taken = effect in structure or (effect == "transport_delay" and "lead_zero" in structure)
            if taken or (effect == "cross_axis" and axis not in ("roll", "pitch")):
                continue
            found = with_effect(workspace, axis, structure, effect, size)
            named = [one["name"] for one in found["effects"]]
            right += names_it(found, effect)
            interval, with_own = "", ""
            for one in found["effects"]:
                if one["name"] == effect:
                    parameter, number = next(iter(one["parameters"].items()))
                    whole = together(effect, size, by_itself(workspace, axis, structure, effect, parameter))
                    numbers += 1
                    inside += number["low"] <= size <= number["high"]
                    inside_with_own += number["low"] <= whole <= number["high"]
                    with_own = f"{whole:.3g}"
                    interval = f"{number['value']:.3g} [{number['low']:.3g}, {number['high']:.3g}]"
            rows.append([axis, effect.replace("_", " "), f"{size:g}", with_own, ", ".join(named).replace("_", " "),
                         interval, found["verdict"].replace("_", " ")])
    shares = (f"{right} of {len(rows) - 1} named correctly; {inside} of {numbers} intervals contain the added size, "
              f"{inside_with_own} of {numbers} the sum of the added size and the flight's own")
    return {"identify.injected": table(*rows), "identify.injected_shares": Figure(shares)}


def hour(workspace):
    """Cost of an hour's log of one axis: memory, and processor time per minute relative to a log of four minutes."""
    printed = workspace.run(workspace.program("host_tests/lab/hidden/identify_scaling", ("host-release",)), "--minutes", "4,60")
    rows = [[float(word) for word in line.split()[:4]] for line in printed.splitlines()[1:]]
    short, long = rows[0], rows[-1]
    return {"identify.hour": Figure(f"{long[3]:.0f} MB, and {long[2] / short[2]:.1f} times the processor time per minute "
                                    f"that a log of four minutes takes")}


SOURCES = [Source(("identify.hour",), hour, quick=False),
           Source(("identify.unseen",), unseen, quick=False),
           Source(("identify.injected",), injected, quick=False)]
