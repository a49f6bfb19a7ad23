# SPDX-License-Identifier: BSD-3-Clause
"""What the measured effects do to the flight: models of one half of the flights, flown on a plant of the other half.

Every model is fitted to the first half of each measured flight: first order as in the paper, first order with one measured
effect more, and all effects. The plant is fitted to the second half, with structures that none of the models has.
"""
import json
import pathlib
import re
import tempfile

from measure.lab_figures import LAB, VEHICLE, asked, compact_table
from measure.workspace import Source

MAP = "host_tests/lab/columns/m100_csv.toml"
HALVES = {"roll": ("pitch_roll.csv", "12:38", "38:55.5"), "pitch": ("pitch_roll.csv", "12:38", "38:55.5"),
          "climb": ("height.csv", "4.5:38", "38:64.5"), "yaw_rate": ("yaw.csv", "10:30", "30:51")}
PLANT = {"roll": "second_order,transport_delay,stick_curve", "pitch": "second_order,transport_delay,stick_curve",
         "climb": "first_order,dead_zone,gain_asymmetry,transport_delay", "yaw_rate": "first_order,dead_zone"}
ALL = {"roll": "second_order,dead_zone,lead_zero", "pitch": "second_order,dead_zone,lead_zero",
       "climb": "second_order,gain_asymmetry,stick_curve", "yaw_rate": "first_order,stick_curve"}
# Name -> what is declared instead of first order alone.
FIREFLYS_WEIGHT = "first order, the Firefly's input weight"  # 35: mav_control_rw's file of that aircraft, printed in the paper
DESIGNED = "all effects, shipped `[design]`"  # what the others predict and estimate with is their own model
MODELS = {FIREFLYS_WEIGHT: {}, "first order": {},
          "+ second order": {axis: "second_order" for axis in ("roll", "pitch", "climb")},
          "+ dead zone": {axis: "first_order,dead_zone" for axis in ("roll", "pitch")},
          "+ lead zero, delay": {axis: "first_order,lead_zero" for axis in ("roll", "pitch")},
          "+ stick curve, asymmetry": {"climb": "first_order,gain_asymmetry,stick_curve", "yaw_rate": "first_order,stick_curve"},
          "all effects": ALL, DESIGNED: ALL}
SCALE = {"roll": "scale_rad_per_count", "pitch": "scale_rad_per_count", "climb": "scale_m_s_per_count",
         "yaw_rate": "scale_rad_s_per_count"}
KEYS = {"time_constant_s": "time_constant_s", "natural_frequency_rad_s": "natural_frequency_rad_s",
        "damping_ratio": "damping_ratio", "delay_s": "transport_delay_s", "zero_s": "lead_zero_s",
        "width_counts": "dead_zone_counts", "shape": "dead_zone_shape", "exponent": "stick_exponent", "ratio": "gain_asymmetry"}


SEEDS = "20"


def section(workspace, axis, structure, part):
    """-> (section of a vehicle file with what is declared, fitted to one half of the flight, its error 1 s ahead on the other)"""
    log, *halves = HALVES[axis]
    _, found = asked(workspace, "identify", "--log", workspace.measured_log(log), "--columns", MAP, "--axis", axis,
                     "--declare", structure, "--train", halves[part], "--validate", halves[1 - part])
    lines = [f"[axis.{axis}]"]
    for name, value in found["declared"]["parameters"].items():
        if name == "gain":
            lines.append(f"{SCALE[axis]} = {abs(value)!r}")
        else:
            lines.append(f"{KEYS[name]} = {json.dumps(value)}")
    text = "\n".join(lines) + f"\nsource = '{log}, train {halves[part]} s, declared {structure}'\n"
    return text, found["declared"]["horizon_rmse"]["1.0"]


def vehicle_file(workspace, folder, title, structures, part):
    """Writes the default vehicle file with other axes, of first order without a structure. -> (file, roll's error 1 s ahead)"""
    replaced = "axis" if title == DESIGNED else "axis|design|rival"
    rest = re.sub(rf"\[+(?:{replaced})[\w.]*\]+\n(?:.+\n)+\n?", "", (workspace.root / VEHICLE).read_text())
    if title == FIREFLYS_WEIGHT:
        rest = re.sub(r"(?m)^input = .*$", "input = 35.0", rest)
    axes = {axis: section(workspace, axis, structures.get(axis, "first_order"), part) for axis in HALVES}
    file = folder / f"{re.sub('[^a-z0-9]+', '_', title)}.toml"
    file.write_text("\n".join(text for text, _ in axes.values()) + "\n" + rest)
    return file, axes["roll"][1]


def interval(cell, digits):
    return f"{cell['value']:.{digits}f}±{0.5 * (cell['high'] - cell['low']):.{digits}f}"


def effects_in_flight(workspace):
    """Errors of prediction and flight, and margins, of each model on the same plant, over 20 seeds."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        plant, _ = vehicle_file(workspace, folder, "plant", PLANT, 1)
        models = [vehicle_file(workspace, folder, title, structures, 0) for title, structures in MODELS.items()]
        answer = folder / "models.json"
        workspace.run(workspace.program(LAB), "loop", "--plant-from", plant, "--models",
                      *(file for file, _ in models), "--tasks", "trajectory",
                      "--seeds", SEEDS, "--json", answer)
        scores = json.loads(answer.read_text())
    rows = [["model", "measured roll 1 s ahead [rad]", "simulated roll 1 s ahead [rad]", f"pose [m], {SEEDS} seeds, ±95 %", "horizontal [m]", "peak sensitivity", "delay margin [ms]"]]
    for title, (_, measured), score in zip(MODELS, models, scores):
        flown = [interval(score[what]["trajectory"], 4) if "trajectory" in score[what] else "flew away"
                 for what in ("pose_m", "horizontal_m")]
        margins = score["margins"]
        kept = [f"{margins['peak_sensitivity']:.2f}", f"{1e3 * margins['delay_margin_s']:.0f}"] if margins["stable"] else ["unstable", "0"]
        rows.append([title, f"{measured:.4f}", interval(score["prediction_1s"]["roll [rad]"], 4), *flown, *kept])
    return {"flight.effects": compact_table(*rows)}


SOURCES = [Source(("flight.effects",), effects_in_flight, quick=False)]
