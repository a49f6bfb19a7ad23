# SPDX-License-Identifier: BSD-3-Clause
"""The end of the main job: one line for each axis, from the residual to the effect, before and after.

Usage: axis_lines.py FOLDER [FIRST_LOOP.json]
  FOLDER      holds roll.json, pitch.json, climb.json and second/translation.json of `identify`, and loop.json of `loop`; what
              is missing is left out
  FIRST_LOOP  the JSON of the `loop` that flew the identified log; missing: the log is a measured one
"""
import json
import pathlib
import sys

AXES = {"roll": ("rad", "roll_rad"), "pitch": ("rad", "pitch_rad"), "climb": ("m/s", "climb_m_s"),
        "yaw_rate": ("rad/s", "yaw_rate_rad_s")}


def words(values):
    return ", ".join(values).replace("_", " ") or "nothing"


DECLARED = ("scale", "time_constant")  # keys whose names begin so are part of the declared first order
SAME = 0.01  # numbers that differ by less, relative to the larger one, count as equal


def hidden_from_first_order(world, axis):
    """-> what the simulated world of a log has and the declared first order has not"""
    return [f"{key} {number['world']:.3g}" for key, number in world[axis].items()
            if number["world"] != number["without"] and not key.startswith(DECLARED)]


def hidden_from_file(world, axis):
    """-> every number in which the simulated world and the vehicle file differ"""
    return [f"{key} {number['world']:.3g} (file: {number['vehicle']:.3g})" for key, number in world[axis].items()
            if abs(number["world"] - number["vehicle"]) > SAME * max(abs(number["world"]), abs(number["vehicle"]))]


def identified(folder, axis, unit, world):
    found = json.loads((folder / f"{axis}.json").read_text())
    line = (f"{axis}: a model of first order leaves a residual of {found['declared']['validation_rmse']:.4f} {unit} -> "
            f"{words(effect['name'] for effect in found['effects'])} -> {found['final']['validation_rmse']:.4f} {unit}")
    return line + (f" (hidden: {words(hidden_from_first_order(world, axis))})" if world else "")


def predicted(found):
    before, after = (", ".join(f"{model[key]['1.0']:.3f} {unit}" for key, unit in (("position_rmse", "m"), ("velocity_rmse", "m/s")))
                     for model in (found["declared"], found["final"]))
    return f"second aircraft, x and y from the sticks 1 s ahead: {before} -> the effects of all axes -> {after}"


def looped(result, axis, unit, key):
    before, after = (result[side]["prediction_1s"][key] for side in ("before", "after"))
    rows = result["believed_found"].get(axis, [])
    found = [f"{row['parameter']} {row['believed']:.3g} -> {row['found']:.3g} [{row['low']:.3g}, {row['high']:.3g}]"
             for row in rows if row["matters"]]
    found += [effect["name"] for effect in result.get("identified", {}).get(axis, {}).get("effects", [])]
    hidden = words(hidden_from_file(result["world"], axis))
    return (f"{axis}: 1 s ahead {before:.4f} -> {after:.4f} {unit}; hidden: {hidden}; found: {words(found)}"
            + ("" if axis in result["taken_over"] else "; not taken over"))


def main():
    folder, *first = map(pathlib.Path, sys.argv[1:])
    world = json.loads(first[0].read_text())["world"] if first else None
    print("Identified" + (" from the SIMULATED flight:" if first else " from the measured flights:"))
    for axis, (unit, _) in AXES.items():
        if (folder / f"{axis}.json").is_file():
            print("  " + identified(folder, axis, unit, world))
    if (folder / "second/translation.json").is_file():
        print("  " + predicted(json.loads((folder / "second/translation.json").read_text())))
    if not (folder / "loop.json").is_file():
        return 0
    result = json.loads((folder / "loop.json").read_text())
    print("The loop on an aircraft with hidden effects (SIMULATED), vehicle file before -> after:")
    for axis, (unit, key) in AXES.items():
        print("  " + looped(result, axis, unit, key))
    for key, words in (("paired", "as flown"), ("paired_at_ordered_margin", "at equal margin")):
        if key == "paired" or result[key] != result["paired"]:
            for task, pairs in result.get(key, {}).items():
                parts = (f"{part} {one['before_m']:.4f} -> {one['after_m']:.4f} m, {one['verdict']} ({one['flights']} pairs)"
                         for part, one in ((part, pairs[part]) for part in ("horizontal", "vertical")))
                print(f"  {words}: {task}: {'; '.join(parts)}")
    print("  " + result["paired_rule"])
    return 0


if __name__ == "__main__":
    sys.exit(main())
