# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the program m100-lab: identification of the measured flights, gain tables, simulated flights."""
import json
import pathlib
import re
import tempfile

from measure.marked import Figure
from measure.workspace import Source

LAB = "host_tests/lab/m100-lab"
VEHICLE = "firmware/mpc/generated/vehicle.toml"
ROOT_TASKS = [(task, air) for task in ("hover", "step", "trajectory") for air in ("calm", "wind")]


def table(*rows):
    """-> rows of cells as a Markdown table; the first row is the header."""
    lines = ["| " + " | ".join(cells) + " |" for cells in rows]
    return Figure("\n".join([lines[0], "|" + "---|" * len(rows[0])] + lines[1:]))


def compact_table(*rows):
    """-> the same without spaces beside the bars, for the first page, whose words are counted."""
    lines = ["|" + "|".join(cells) + "|" for cells in rows]
    return Figure("\n".join([lines[0], "|" + "---|" * len(rows[0])] + lines[1:]))


def asked(workspace, *words):
    """-> (what m100-lab prints, its JSON)"""
    with tempfile.TemporaryDirectory() as folder:
        answer = pathlib.Path(folder) / "answer.json"
        printed = workspace.run(workspace.program(LAB), *words, "--json", answer)
        return printed, json.loads(answer.read_text())


MEASURED = {"roll": ("rad", "pitch_roll.csv", ("--train", "12:38", "--validate", "38:55.5")),
            "pitch": ("rad", "pitch_roll.csv", ("--train", "12:38", "--validate", "38:55.5")),
            "climb": ("m/s", "height.csv", ("--train", "4.5:38", "--validate", "38:64.5")),
            "yaw_rate": ("rad/s", "yaw.csv", ("--train", "10:30", "--validate", "30:51"))}


def dead_zones(workspace):
    """Half width of each measured axis' dead zone."""
    zones = []
    for axis, (_, log, ranges) in MEASURED.items():
        found = asked(workspace, "identify", "--log", workspace.measured_log(log), "--columns", "host_tests/lab/columns/m100_csv.toml",
                      "--axis", axis, "--declare", "first_order", *ranges)[1]
        for effect in found["effects"]:
            zone = next((values for key, values in effect["parameters"].items() if "width" in key or "counts" in key), None)
            if effect["name"] == "dead_zone" and isinstance(zone, dict):
                zones.append(f"{axis.replace('_', ' ')} {zone['value']:.1f} counts [{zone['low']:.1f}, {zone['high']:.1f}]")
    return {"identify.dead_zones": Figure(", ".join(zones))}


def gain_tables(workspace):
    """The set-point law of the generated vehicle."""
    printed, _ = asked(workspace, "gains", "--vehicle", VEHICLE)
    law = re.compile(r"(\w): set-point law of (\d+) regions in half the box, (\d+) affine pieces, at most (\d+) planes in "
                     r"\d+ nodes of (\d+), (\d+) bytes")
    pieces = [["axis", "regions in half the box", "affine pieces", "planes at most", "nodes", "bytes in float"]]
    pieces += [list(found) for found in law.findall(printed)]
    return {"mpc.setpoint_law": table(*pieces)}


def papers_numbers(workspace):
    """The paper's scales and climb dynamics from its files: with its authors' method, and with aligned sticks."""
    _, answer = asked(workspace, "paper", "--pitch-roll", workspace.measured_log("ExperimentPitchRoll.mat"),
                      "--height", workspace.measured_log("ExperimentHeight.mat"), "--yaw", workspace.measured_log("ExperimentYaw.mat"))
    rows = [["quantity", "paper", "reproduced", "aligned by the message counters", "verdict"]]
    for line in answer["lines"]:
        numbers = [line[column] for column in ("paper", "reproduced", "aligned")]
        rows.append([line["quantity"]] + ["" if number is None else f"{number:.4g}" for number in numbers] + [line["verdict"]])
    return {"identify.paper": table(*rows)}


RIVAL = "host_tests/lab/gains/no_zero.toml"
SMALL_BOX = ["--setpoint-box"] + ["0.01"] * 6  # the explicit law is not needed
STRUCTURES = (("its own structure", "as the vehicle file, with lead zeros"), (RIVAL, "without a zero"))


def as_flown(workspace):
    """Margins of the default controller as flown: with command hold, observer and prediction."""
    _, answer = asked(workspace, "gains", "--vehicle", VEHICLE, "--rival", RIVAL, *SMALL_BOX)
    rows = [["aircraft", "channel", "x: peak sensitivity", "x: delay margin [ms]", "y: peak sensitivity", "y: delay margin [ms]"]]
    for structure, name in STRUCTURES:
        for channel, words in (("virtual_rc", "Virtual RC, 25 Hz"), ("movement", "movement, 50 Hz")):
            both = [answer["flown"][structure][axis][channel] for axis in ("x", "y")]
            rows.append([name, words] + [text for axis in both for text in (
                f"{axis['peak_sensitivity']:.2f}", f"{1e3 * axis['delay_margin_s']:.0f}")])
    return {"mpc.as_flown": table(*rows)}


def corners(workspace):
    """Worst margins over both axes and structures, nominal and over the boxes, for each mode and channel."""
    rows = [["mode", "channel", "nominal: peak sensitivity", "delay margin [ms]", "corners: peak sensitivity",
             "delay margin [ms]", "whole box: peak sensitivity"]]
    for mode in ("field", "robust"):
        _, answer = asked(workspace, "gains", "--vehicle", VEHICLE, "--rival", RIVAL, "--corners", "--mode", mode, *SMALL_BOX)
        for channel, words in (("virtual_rc", "Virtual RC"), ("movement", "movement")):
            all_axes = [answer["flown"][structure][axis] for structure, _ in STRUCTURES for axis in ("x", "y")]

            def worst(parts, delay=True):
                peak = f"{max(part['peak_sensitivity'] for part in parts):.2f}"
                peak = peak if all(part["stable"] for part in parts) else "unstable"
                return [peak] + ([f"{1e3 * min(part['delay_margin_s'] for part in parts):.0f}"] if delay else [])
            rows.append([f"`{mode}`", words] + worst([axis[channel] for axis in all_axes])
                        + worst([axis["corners"][channel] for axis in all_axes])
                        + worst([axis["box"][channel] for axis in all_axes], delay=False))
    return {"mpc.corners": table(*rows)}


def thousandths(value, digits=3):
    return f"{value:.{digits}f}"


def papers_tasks(workspace):
    """The paper's tasks in simulated flight, over 20 seeds, with our law, the clipped LQR and the law of the paper's authors."""
    _, answer = asked(workspace, "experiments", "--seeds", "20", "--baseline")
    rows = [["task", "pose [m]", "x [m]", "y [m]", "z [m]", "yaw [deg]", "`--law paper`, pose [m]"]]
    laws = [["task", "ours: pose [m]", "clipped LQR", "`--law paper`", "ours: z [m]", "`--law paper`",
             "ours: command [deg/s]", "`--law paper`"]]
    more = [["task", "pose [m]", "tilt [deg]", "command rate [deg/s]", "largest tilt [deg]",
             "share of the time-optimal response"]]
    for task, air in ROOT_TASKS:
        cell = answer[task][air]
        rows.append([f"{task}, {air}"] + [f"{cell[name]:.3f}/{cell['paper'][name]:.3f}"
                                         for name in ("pose_m", "x_m", "y_m", "z_m", "yaw_deg")] +
                    [f"{cell['paper_law']['pose_m']:.3f}"])
        laws.append([f"{task}, {air}", *(f"{law['pose_m']:.4f}" for law in (cell, cell["lqr"], cell["paper_law"])),
                     *(f"{law['z_m']:.4f}" for law in (cell, cell["paper_law"])),
                     *(f"{law['input_variation_deg_s']:.0f}" for law in (cell, cell["paper_law"]))])
    for task in (key for key in answer if isinstance(answer[key], dict)):
        for air, cell in answer[task].items():
            share = f"{100 * cell['time_optimal_share']:.0f} %" if "time_optimal_share" in cell else ""
            more.append([f"{task}, {air}"] + [thousandths(cell["pose_m"]), f"{cell['tilt_deg']:.2f}",
                                              f"{cell['input_variation_deg_s']:.0f}", f"{cell['largest_tilt_deg']:.1f}", share])
    above = answer["cells_above_paper"]
    return {"flight.paper": compact_table(*rows), "flight.more": table(*more), "flight.laws": table(*laws),
            "flight.cells_above_paper": Figure(f"{above} cells" if above != 1 else "1 cell")}


def studied(workspace, study, seeds):
    """-> the table of a study of experiments/studies.py, with the default vehicle."""
    printed = workspace.run("host_tests/lab/experiments/studies.py", study, workspace.program(LAB), VEHICLE, "--seeds", seeds)
    return table(*([cell.strip() for cell in line.strip("| ").split("|")] for line in printed.splitlines()))


def command_rates(workspace):
    """Tracking error at each command rate, over three seeds."""
    return {"flight.rates": studied(workspace, "rates", 3)}


def far_tasks(workspace):
    """LQR, exact law, and exact law with the planner in tasks where the limits are active, over 20 seeds."""
    _, answer = asked(workspace, "experiments", "--tasks", "far", "--seeds", "20")
    laws = {"lqr": "LQR", "mpc": "MPC", "planned": "planned"}
    numbers = {"overshoot_m": ("overshoot", "m", 3), "iae_m_s": ("error integral", "m s", 2), "settled_s": ("2 cm after", "s", 2)}
    cells = [(law, name) for name in numbers for law in laws]
    rows = [["task"] + [f"{numbers[name][0]}, {laws[law]} [{numbers[name][1]}]" for law, name in cells]]
    for task in answer["tasks"]:
        rows.append([task["name"].replace("_", " ")] +
                    [thousandths(task[law][name], numbers[name][2]) for law, name in cells])
    sums = [sum(task[law][name] for task in answer["tasks"]) for law, name in cells]
    rows.append(["sum"] + [thousandths(total, numbers[name][2]) for total, (_, name) in zip(sums, cells)])
    return {"flight.far": table(*rows)}


def both_modes(workspace):
    """The paper's tasks in both modes, over five seeds."""
    modes = {mode: asked(workspace, "experiments", "--seeds", "5", "--mode", mode)[1] for mode in ("field", "robust")}
    rows = [["task", "field: pose [m]", "command [deg/s]", "robust: pose [m]", "command [deg/s]", "the paper's pose [m]"]]
    for task, air in ROOT_TASKS:
        cells = [modes[mode][task][air] for mode in modes]
        rows.append([f"{task}, {air}"] + [text for cell in cells for text in (
            thousandths(cell["pose_m"], 4), f"{cell['input_variation_deg_s']:.0f}")] + [thousandths(cells[0]["paper"]["pose_m"])])
    rows.append(["cells above the paper's"] + [text for mode in modes for text in (
        str(modes[mode]["cells_above_paper"]), "")] + [""])
    return {"flight.modes": table(*rows)}


def motion_curve(workspace):
    """Tracking error against the motion of the commands, over five seeds."""
    return {"flight.motion": studied(workspace, "motion", 5)}


def hidden_effects(workspace):
    """The confusion matrix, as shares: one list of 620 logs, and two held-out lists of 320."""
    program, scores = workspace.program("host_tests/lab/hidden/hidden_effects", ("host-release",)), {}
    for seed, logs in (("20261121", 620), ("90210", 320), ("55", 320)):
        with tempfile.TemporaryDirectory() as folder:
            answer = pathlib.Path(folder) / "answer.json"
            workspace.run(program, "--logs", logs, "--seed", seed, "--json", answer)
            scores[seed] = json.loads(answer.read_text())["scores"]
    rows = [["", "right", "share", "goal", "right, seeds 90210 and 55 (320 logs each)"]]
    for first, second, third in zip(*scores.values()):
        goal = f"{100 * first['goal']:.0f} %" if first["goal"] > 0 else ""
        share = f"{100 * first['right'] / max(first['count'], 1):.1f} %"
        others = f"{second['right'] + third['right']} of {second['count'] + third['count']}"
        rows.append([first["what"], f"{first['right']} of {first['count']}", share, goal, others])
    zeros = workspace.run(program, "--only", "lead_zero", "--logs", 6200, "--seed", 31415, may_fail=True)
    named = re.search(r"roll lead_zero +(\d+ of \d+)", zeros)[1]
    return {"hidden.shares": table(*rows), "hidden.lead_zero": Figure(named)}


def coverage(workspace):
    """How often the 95 % intervals contain the true value: simulated logs of a hand, and excited flights of evenings."""
    program, figures = workspace.program("host_tests/property/identify_coverage", ("host-release",)), {}
    for name, flights, seed in (("identify.coverage", "hand", 20261122), ("identify.coverage_excited", "excited", 900000)):
        with tempfile.TemporaryDirectory() as folder:
            answer = pathlib.Path(folder) / "answer.json"
            workspace.run(program, "--flights", flights, "--logs", 500, "--seed", seed, "--json", answer)
            figures[name] = coverage_table(json.loads(answer.read_text())["parameters"])
    return figures


def coverage_table(parameters):
    """Covered share and mean half width of each parameter, one column for each axis."""
    cells, axes, names = {}, [], []
    for row in parameters:
        axis = next(one for one in ("roll", "pitch", "climb", "yaw_rate", "translation") if row["parameter"].startswith(one + " "))
        name = row["parameter"].removeprefix(axis + " ")
        cells[name, axis] = f"{row['covered_percent']:.1f} ±{row['half_width_percent']:.0f}"
        axes += [axis] if axis not in axes else []
        names += [name] if name not in names else []
    rows = [["covered, ± mean half width [%]", *(axis.replace("_", " ") for axis in axes)]]
    return table(*rows, *([name.replace("_", " "), *(cells.get((name, axis), "") for axis in axes)] for name in names))


SOURCES = [Source(("identify.dead_zones",), dead_zones),
           Source(("mpc.margins", "mpc.setpoint_law"), gain_tables),
           Source(("mpc.as_flown",), as_flown),
           Source(("identify.paper",), papers_numbers),
           Source(("mpc.corners",), corners, quick=False),
           Source(("flight.paper", "flight.more", "flight.laws", "flight.cells_above_paper"), papers_tasks, quick=False),
           Source(("flight.rates",), command_rates, quick=False),
           Source(("flight.far",), far_tasks, quick=False),
           Source(("flight.modes",), both_modes, quick=False),
           Source(("flight.motion",), motion_curve, quick=False),
           Source(("hidden.shares", "hidden.lead_zero"), hidden_effects, quick=False),
           Source(("identify.coverage",), coverage, quick=False)]
