# SPDX-License-Identifier: BSD-3-Clause
"""The end of the main job: one line for each axis, from the residual to the effect, before and after.

Usage: axis_lines.py FOLDER PLANT.toml [FIRST_PLANT.toml]
  FOLDER       holds roll.json, pitch.json, climb.json of `identify` and loop.json of `loop`
  PLANT        what was hidden in the loop
  FIRST_PLANT  what was hidden in the flight that was identified; missing: a measured flight
"""
import json
import pathlib
import sys
import tomllib

AXES = {"roll": ("rad", "roll_rad"), "pitch": ("rad", "pitch_rad"), "climb": ("m/s", "climb_m_s"),
        "yaw_rate": ("rad/s", "yaw_rate_rad_s")}


def words(values):
    return ", ".join(values).replace("_", " ") or "nothing"


def hidden_in(plant, axis, known=None):
    """-> the keys of the axis that the plant hides; not those that the aircraft identified before has as well"""
    before = (known or {}).get("axis", {}).get(axis, {})
    return {key: value for key, value in plant.get("axis", {}).get(axis, {}).items() if before.get(key) != value}


def identified(folder, axis, unit, plant):
    found = json.loads((folder / f"{axis}.json").read_text())
    line = (f"{axis}: a model of first order leaves a residual of {found['declared']['validation_rmse']:.4f} {unit} -> "
            f"{words(effect['name'] for effect in found['effects'])} -> {found['final']['validation_rmse']:.4f} {unit}")
    hidden = [f"{key} {value:g}" for key, value in hidden_in(plant, axis).items()]
    return line + (f" (hidden: {words(hidden)})" if hidden else "")


def looped(result, axis, unit, key, plant, known):
    before, after = (result[side]["prediction_1s"][key] for side in ("before", "after"))
    rows = result["believed_found"].get(axis, [])
    found = [f"{row['parameter']} {row['believed']:.3g} -> {row['found']:.3g} [{row['low']:.3g}, {row['high']:.3g}]"
             for row in rows if row["matters"]]
    found += [effect["name"] for effect in result.get("identified", {}).get(axis, {}).get("effects", [])]
    hidden = [f"{name} {value:g}" for name, value in hidden_in(plant, axis, known).items()]
    return (f"{axis}: 1 s ahead {before:.4f} -> {after:.4f} {unit}; hidden: {words(hidden)}; found: {words(found)}"
            + ("" if axis in result["taken_over"] else "; not taken over"))


def main():
    folder, hidden, *first = map(pathlib.Path, sys.argv[1:])
    second_plant = tomllib.loads(hidden.read_text())
    first_plant = tomllib.loads(first[0].read_text()) if first else {}
    print("Identified" + (" from the SIMULATED flight:" if first else " from the measured flights:"))
    for axis, (unit, _) in AXES.items():
        if (folder / f"{axis}.json").is_file():
            print("  " + identified(folder, axis, unit, first_plant))
    result = json.loads((folder / "loop.json").read_text())
    print("The loop on an aircraft with hidden effects (SIMULATED), vehicle file before -> after:")
    for axis, (unit, key) in AXES.items():
        print("  " + looped(result, axis, unit, key, second_plant, first_plant))
    for task, pairs in result.get("paired_at_ordered_margin", {}).items():
        for part in ("horizontal", "vertical"):
            one = pairs[part]
            print(f"  {task}, {part}: {one['before_m']:.4f} -> {one['after_m']:.4f} m, {one['verdict']} ({one['flights']} "
                  "pairs, both laws at the ordered margin)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
