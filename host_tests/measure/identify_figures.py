# SPDX-License-Identifier: BSD-3-Clause
"""Figures of identify on adversarial logs, and on measured flights to which an effect was added."""
import pathlib
import re
import tempfile

from measure.lab_figures import LAB, MEASURED, asked, table
from measure.marked import Figure
from measure.workspace import Source

UNSEEN = ("--unseen", "--logs", 31, "--seed", 912000)
KIND = re.compile(r"^(?P<kind>\S.*?) +" + " +".join(rf"(?P<n{k}>\d+)" for k in range(8)) + r" +[\d.]+$")
GROUPS = {"healthy": "^healthy", "a missing effect": "^lacks", "a change in flight": " (changes|grows) |later$"}
MAP = "host_tests/lab/columns/m100_csv.toml"
# The medium sizes of the confusion matrix of simulated logs.
SIZES = {"transport_delay": 0.10, "dead_zone": 20, "gain_asymmetry": 1.25, "trim_offset": 40, "stick_curve": 1.35,
         "backlash": 18, "gain_drift": 0.28, "cross_axis": 0.17}
RATIOS = ("gain_asymmetry", "stick_curve")
SIGNED = ("trim_offset", "gain_drift", "cross_axis")


def unseen(workspace):
    """Logs of unknown vehicles: the answers of identify for each group of kinds, and the shares that have a limit."""
    printed = workspace.run(workspace.program("host_tests/property/identify_adversarial_logs", ("host-release",)), *UNSEEN,
                        may_fail=True)
    head = ["kinds (simulated)", "logs", "right", "undecided", "wrong name", "false acceptance", "of these, not visible in the log",
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


def asked_of(workspace, axis, declared, ranges, *more, log=None, columns=MAP):
    """-> the answer of identify for a log, or for the measured flight of this axis"""
    log = log or workspace.measured_log(MEASURED[axis][1])
    return asked(workspace, "identify", "--log", log, "--columns", columns, "--axis", axis, "--declare", ",".join(declared), *ranges, *more)[1]


def with_effect(workspace, axis, structure, ranges, effect, size):
    """-> the answer of identify for the flight with the effect added to what it has of it; its other effects are declared"""
    with tempfile.TemporaryDirectory() as folder:
        log, columns = (pathlib.Path(folder) / name for name in ("log.csv", "map.toml"))
        workspace.run(workspace.program(LAB), "inject", "--log", workspace.measured_log(MEASURED[axis][1]), "--columns", MAP, "--axis", axis,
                      "--declare", ",".join([*structure, effect]), "--train", ranges[1], "--effect", f"{effect}={size}", "--out", log, "--map", columns)
        return asked_of(workspace, axis, structure, ranges, log=log, columns=columns)


def sizes(effect, medium):
    """-> smaller, medium and larger, and the medium one the other way round where it has a sign or is a ratio"""
    if effect in RATIOS:
        return [round(medium ** power, 3) for power in (0.7, 1, 1.4)] + [round(1 / medium, 3)]
    return [round(medium * factor, 3) for factor in (0.7, 1, 1.4)] + ([-medium] if effect in SIGNED else [])


def together(effect, added, own):
    """-> the total size of an added effect and the flight's own one: ratios and exponents multiply, others add"""
    return added * own if effect in RATIOS else added + own


def names_it(found, effect):
    alike = [group for group in found["not_separable"] if effect in group]
    named = [one["name"] for one in found["effects"]]
    return effect in named or any(name in group for group in alike for name in named)


def in_one(workspace, axis, effect):
    """-> [logs, named correctly, not named but "unexplained", with a size, size inside its interval] for one flight and effect"""
    counts = [0] * 5
    _, _, (train, first, validate, second) = MEASURED[axis]
    for ranges in ((train, first, validate, second), (train, second, validate, first)):
        structure = asked_of(workspace, axis, ["first_order"], ranges)["final"]["structure"]
        taken = effect in structure or (effect == "transport_delay" and "lead_zero" in structure)
        if taken or (effect == "cross_axis" and axis not in ("roll", "pitch")):
            continue
        own = {}
        for size in sizes(effect, SIZES[effect]):
            found = with_effect(workspace, axis, structure, ranges, effect, size)
            counts[0] += 1
            counts[1] += names_it(found, effect)
            counts[2] += found["verdict"] == "unexplained" and not names_it(found, effect)
            for name, number in (next(iter(one["parameters"].items())) for one in found["effects"] if one["name"] == effect):
                own = own or asked_of(workspace, axis, [*structure, effect], ranges, "--refits", 0)["declared"]["parameters"]
                counts[3] += 1
                counts[4] += number["low"] <= together(effect, size, own[name]) <= number["high"]
    return counts


def injected(workspace):
    """Adds each effect that a measured flight does not have, in several sizes, to both orders of its halves."""
    counts = {(axis, effect): in_one(workspace, axis, effect) for effect in SIZES for axis in MEASURED}
    rows = [["named, size inside", *(axis.replace("_", " ") for axis in MEASURED)]]
    for effect in SIZES:
        cells = [counts[axis, effect] for axis in MEASURED]
        rows.append([effect.replace("_", " "), *(f"{named}/{logs}, {inside}/{sized}" if logs else "" for logs, named, _, sized, inside in cells)])
    shares = []
    for axes in (("roll", "pitch"), ("climb", "yaw_rate")):
        logs, named, undecided, sized, inside = (sum(column) for column in zip(*(counts[axis, effect] for axis in axes for effect in SIZES)))
        shares.append(f"{' and '.join(axes).replace('_', ' ')}: {named} of {logs} named correctly, {undecided} undecided, {inside} of {sized} intervals contain the sum")
    return {"identify.injected": table(*rows), "identify.injected_shares": Figure("; ".join(shares))}


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
