# SPDX-License-Identifier: BSD-3-Clause
"""What the measured flights say of each other, and of another aircraft."""
import pathlib
import tempfile

from measure.lab_figures import asked, compact_table, table
from measure.workspace import Source

MAP = "host_tests/lab/columns/m100_csv.toml"
TILT, CLIMB, YAW = "pitch_roll.csv", "height.csv", "yaw.csv"
# Per row: the logs, the training part, the validation part. In height.csv the autopilot held the position, so that its
# roll and pitch are not attitude responses; only yaw.csv moves the yaw stick.
TILT_SPLITS = (("whole flight, judged on the yaw flight", (TILT, YAW), "1@12:55.5", "2@10:51"),
               ("yaw flight, judged on the whole flight", (TILT, YAW), "2@10:51", "1@12:55.5"),
               ("both flights, halves of each", (TILT, YAW), "1@12:38,2@10:30", "1@38:55.5,2@30:51"))
SPLITS = {"roll": TILT_SPLITS, "pitch": TILT_SPLITS,
          "climb": (("whole flight, judged on the roll and pitch flight", (CLIMB, TILT), "1@4.5:64.5", "2@12:55.5"),
                    ("all three flights, halves of each", (CLIMB, TILT, YAW), "1@4.5:38,2@12:38,3@10:30",
                     "1@38:64.5,2@38:55.5,3@30:51"))}


def size(value):
    return f"{value['value']:.3g} [{value['low']:.3g}, {value['high']:.3g}]"


def effect(one):
    sizes = ", ".join(size(value) for value in one["parameters"].values() if isinstance(value, dict))
    rivals = ", ".join(rival["name"].replace("_", " ") for rival in one["rivals"])
    return one["name"].replace("_", " ") + (f" {sizes}" if sizes else "") + (f" (or {rivals})" if rivals else "")


def splits(workspace):
    """Structure, sizes with 95 % intervals and errors of each axis for each division of the flights."""
    rows = [["axis", "training and validation part", "declared first order", "with the effects", "effects, 95 % (or: not separable)", "verdict"]]
    for axis, all_splits in SPLITS.items():
        for name, logs, train, validate in all_splits:
            words = [word for log in logs for word in ("--log", workspace.measured_log(log))]
            _, found = asked(workspace, "identify", *words, "--columns", MAP, "--axis", axis, "--declare", "first_order",
                             "--train", train, "--validate", validate)
            rows.append([axis.replace("_", " "), name, f"{found['declared']['validation_rmse']:.4f}",
                         f"{found['final']['validation_rmse']:.4f}", "; ".join(effect(one) for one in found["effects"]) or "none",
                         found["verdict"].replace("_", " ")])
    return {"identify.splits": table(*rows)}


def second_aircraft(workspace):
    """x and y of the second aircraft: first order and a rigid body, and with the effects of roll, pitch, climb and translation."""
    log, columns = workspace.measured_log("falcon2_height.csv"), workspace.measured_log("falcon2.toml")
    with tempfile.TemporaryDirectory() as name:
        files = ["--vehicle", pathlib.Path(name) / "identified.toml", "--vehicle-declared", pathlib.Path(name) / "declared.toml"]
        found = {axis: asked(workspace, "identify", "--log", log, "--columns", columns, "--axis", axis, "--declare",
                             "rigid_body" if axis == "translation" else "first_order", "--split", "alternate:6", "--within", "33:99", *files)[1]
                 for axis in ("roll", "pitch", "climb", "translation")}
    models = [found["translation"][model] for model in ("declared", "final")]
    rows = [["second aircraft, declared/identified", *(f"{float(key):g} s" for key in models[0]["horizon_rmse"])]]
    for what, key in (("position [m]", "position_rmse"), ("velocity [m/s]", "velocity_rmse")):
        rows.append([what] + ["/".join(f"{model[key][horizon]:.3f}" for model in models) for horizon in models[0][key]])
    details = [["second aircraft", "declared", "identified", "effects, 95 %", "verdict"]]
    for axis, one in found.items():
        details.append([axis, *(f"{one[model]['validation_rmse']:.4f}" for model in ("declared", "final")),
                        "; ".join(effect(each) for each in one["effects"]), one["verdict"]])
    return {"identify.motion": compact_table(*rows), "identify.second": table(*details)}


SOURCES = [Source(("identify.motion", "identify.second"), second_aircraft),
           Source(("identify.splits",), splits, quick=False)]
