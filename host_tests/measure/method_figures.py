# SPDX-License-Identifier: BSD-3-Clause
"""Figures of host_tests/lab/identify/METHOD.md: the thresholds as the code has them, and the worked example beside m100-lab's result."""
import math
import pathlib
import re
import tempfile

from measure import method_example
from measure.lab_figures import asked, compact_table
from measure.marked import Figure
from measure.workspace import Source

IDENTIFY = "host_tests/lab/identify/"
BLOCKS = 16  # of a training part of 40 s, as in the example


def to_one(odds):
    return f"{float(f'{odds:.2g}'):g}:1"


def bayes(difference):
    """Odds that a difference of Schwarz's criterion stands for (Kass and Raftery)."""
    return to_one(math.exp(difference / 2))


def student(t):
    """Odds against a t this large by chance, one-sided, from the blocks' differences."""
    n, step, end = BLOCKS - 1, 1e-3, 60.0
    scale = math.gamma((n + 1) / 2) / math.gamma(n / 2) / math.sqrt(n * math.pi)
    tail = sum(scale * (1 + (t + step * k) ** 2 / n) ** (-(n + 1) / 2) for k in range(round((end - t) / step))) * step
    return f"{to_one(1 / tail)} (Student)"


def normal(sigmas):
    return f"{to_one(2 / math.erfc(sigmas / math.sqrt(2)))} (normal)"


def chi_square(ratio):
    return f"{to_one(1 / math.erfc(math.sqrt(ratio / 2)))} (chi-square)"


def probability(value):
    return to_one(1 / value)


# file -> {constant: what its value follows from}; a function computes it from the value
DERIVED = {
    "selection/selection.h": {"minimum_delta_bic": bayes, "strong_delta_bic": bayes, "min_delta_white": lambda white: f"{bayes(white)}; 240 healthy logs reach 7.1", "minimum_delta_white": bayes,
                              "minimum_t": student},
    "selection/verdict.h": {"min_probability": probability},
    "residual_tests/axis/axis_change_point.h": {"kChanceChange": "1 of 100 healthy logs", "kLikelyChange": "0 of 480",
                                                "kCertainChange": chi_square, "kNameMargin": bayes,
                                                "kMinDelayChange_s": "healthy delays shift by up to 0.012 s"},
    "residual_tests/change_scan.cpp": {"kDateDrop": lambda drop: f"{100 * (1 - math.exp(-drop / 2)) ** 2:.1f} % (Hansen, *Econometrica* 68, 2000)"},
    "residual_tests/axis/axis_time_offset.cpp": {"kMargin": bayes, "kMinSigmas": normal},
    "residual_tests/axis/axis_tether.cpp": {"kThreshold": "as kChanceChange"},
    "residual_tests/axis/weak_effect.cpp": {"kFalseAlarm": probability},
    "residual_tests/residual_test.h": {"shifts": lambda shifts: to_one(shifts + 1), "drift_t": student,
                                       "periodic_peak": lambda peak: f"{to_one(math.exp(peak))} (white noise)"}}
CHOSEN = {
    "selection/selection.h": ("minimum_t_white", "minimum_t_strong", "minimum_cv_gain", "keep_cv_gain", "simpler_margin", "rival_margin", "split_gain"),
    "translation_pipeline.cpp": ("kMinimumCvGain",),
    "selection/verdict.h": ("min_ratio", "max_ratio", "min_evidence", "min_fit_percent"),
    "residual_tests/residual_test.h": ("shift_factor", "shift_margin", "minimum_share", "periodic_share", "drift_share", "burst_sigma", "burst_share",
                                       "floor_factor")}


def constant(workspace, file, name):
    """-> the value that the code gives to a constant"""
    found = re.search(rf"\b{name} =\s+([\d.]+);", (workspace.root / IDENTIFY / file).read_text())
    if not found:
        raise ValueError(f"{file} has no constant {name}")
    return float(found[1])


def thresholds(workspace):
    rows = [("constant", "value", "follows from", "file")]
    for file, constants in DERIVED.items():
        for name, reason in constants.items():
            value = constant(workspace, file, name)
            rows.append((f"`{name}`", f"{value:g}", reason if isinstance(reason, str) else reason(value), f"`{file}`"))
    for file, names in CHOSEN.items():
        rows += [(f"`{name}`", f"{constant(workspace, file, name):g}", "chosen", f"`{file}`") for name in names]
    return {"method.thresholds": compact_table(*rows)}


def acceptance(workspace):
    """The evidence that an effect needs, as convincing() in selection/criteria.cpp asks for it."""
    bic, strong, white, much, t, t_white, t_strong, gain = (f"{constant(workspace, 'selection/selection.h', name):g}" for name in (
        "minimum_delta_bic", "strong_delta_bic", "min_delta_white", "minimum_delta_white", "minimum_t", "minimum_t_white", "minimum_t_strong", "minimum_cv_gain"))
    return {"method.acceptance": Figure(f"- gain>{gain} (in training also without each block's first second) and one of\n"
                                        f"  - delta_white>{much} and t>{t_white} ({t} if delta_bic<=0),\n"
                                        f"  - delta_white>={white}, delta_bic>{bic} and t>{t} ({t_strong} if delta_bic>{strong}).")}


def identified(workspace, data):
    """-> what m100-lab says of the example's record"""
    with tempfile.TemporaryDirectory() as folder:
        log, columns = (pathlib.Path(folder) / name for name in ("log.csv", "map.toml"))
        method_example.write(data, log)
        columns.write_text('time = "t_s"\n[signals]\nstick_roll = "stick"\nattitude_roll = "roll"\n')
        ranges = [f"{begin:g}:{end:g}" for begin, end in (method_example.TRAIN_S, method_example.VALIDATE_S)]
        return asked(workspace, "identify", "--log", log, "--columns", columns, "--axis", "roll", "--declare", "first_order,transport_delay",
                     "--train", ranges[0], "--validate", ranges[1])[1]


def example(workspace):
    data = method_example.record()
    lab, ours = identified(workspace, data), method_example.evidence(data)
    (effect,) = lab["effects"]
    tried = next(row for row in lab["candidates"] if row["name"] == effect["name"])
    keys = ("gain", "time_constant_s", "offset_counts", "delay_s", "width_counts")
    names = ("gain [rad/count]", "time constant [s]", "trim [counts]", "delay [s]", "dead zone [counts]")
    rows = [("number", "true", "declared", "with dead zone", "`identify`")]
    for k, (key, name) in enumerate(zip(keys, names)):
        cells = [f"{value:.3g}" for value in (method_example.TRUE[k], ours["declared"][k], ours["found"][k], lab["final"]["parameters"][key])]
        if key in ("delay_s", "width_counts"):
            interval = lab["final"]["intervals"][key]
            cells[2:] = [f"{cells[2]}±{ours['half'][k]:.2g}", f"{cells[3]}±{(interval['high'] - interval['low']) / 2:.2g}"]
        rows.append((name, *cells))
    for key, part in (("train", "training"), ("validation", "validation")):
        rows.append((f"{part} error [rad]", "", *(f"{value:.3g}" for value in (*ours[key], lab["final"][f"{key}_rmse"]))))
    rows.append(("independent samples (6)", "", "", f"{ours['effective']:.0f}", ""))
    for key, equation, theirs in (("cv_gain", "5", "cv_gain"), ("t", "", "paired_t"), ("delta_bic", "6", "delta_bic"), ("delta_white", "7", "delta_white")):
        rows.append((f"{key.replace('cv_', '')}{f' ({equation})' if equation else ''}", "", "", f"{ours[key]:.3g}", f"{tried[theirs]:.3g}"))
    rows.append(("verdict", "", "", "", f"{lab['verdict']}: {effect['name']}"))
    return {"method.example": Figure(compact_table(*rows).text, 0.01)}


SOURCES = [Source(("method.thresholds",), thresholds), Source(("method.acceptance",), acceptance), Source(("method.example",), example)]
