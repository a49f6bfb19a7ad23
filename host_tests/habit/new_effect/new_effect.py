#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Adds an effect to a copy of the project and counts the files that this took.

An effect is declared in one place and its law is in one other; simulation, identification, files and reports must then
know it. The copy tests whether that still holds.

Usage: new_effect.py ROOT SCRATCH [--whole]
  SCRATCH  folder for the copies; its earlier content is deleted
  without --whole  compiles each effect's quick check with the files that it needs, and runs it (under a minute)
  --whole          builds each copy, simulates the effect, identifies it blind, writes the vehicle file and the report
Exit code 1: an effect took more files than allowed, or some part of the project does not know it.
"""
import argparse
import filecmp
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
NOT_COPIED = shutil.ignore_patterns(".git", "build", "__pycache__")


class Broken(Exception):
    """The effect fails the test; the text is the reason, in one sentence."""


def run(command, folder, name):
    """Runs a command in a folder; its output goes to NAME.log there. Fails on an exit code above 1, or 1 unless NAME is
    identify, for which it is an answer."""
    log = folder / f"{name}.log"
    with open(log, "w", encoding="utf-8") as out:
        code = subprocess.run([str(word) for word in command], cwd=folder, stdout=out, stderr=subprocess.STDOUT,
                              check=False).returncode
    if code > 1 or (code == 1 and name != "identify"):
        tail = "".join(open(log, encoding="utf-8").readlines()[-15:])
        raise Broken(f"{name} ended with {code}; the end of {log}:\n{tail}")


def insert(copy, path, anchor, text):
    """Inserts text before the only line that begins with the anchor."""
    file = copy / path
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    places = [number for number, line in enumerate(lines) if line.startswith(anchor)]
    if len(places) != 1:
        raise Broken(f"{path}: {len(places)} lines begin with {anchor!r}; this test's recipe needs exactly one")
    lines[places[0]:places[0]] = [text]
    file.write_text("".join(lines), encoding="utf-8")


def replace(copy, path, old, new):
    """Replaces the only occurrence of a text."""
    file = copy / path
    text = file.read_text(encoding="utf-8")
    if text.count(old) != 1:
        raise Broken(f"{path}: {old!r} stands there {text.count(old)} times; this test's recipe needs it once")
    file.write_text(text.replace(old, new), encoding="utf-8")


def touched(root, copy):
    """Files of the copy that are new or differ."""
    out = []
    for folder, _, names in os.walk(copy):
        for name in names:
            path = pathlib.Path(folder, name).relative_to(copy)
            if path.parts[0] == "build" or path.suffix == ".log":
                continue
            if not (root / path).exists() or not filecmp.cmp(root / path, copy / path, shallow=False):
                out.append(str(path))
    return sorted(out)


def apply_and_count(root, copy, at_most):
    files = touched(root, copy)
    print("  files touched: " + ", ".join(files))
    if len(files) > at_most:
        raise Broken(f"it took {len(files)} files, at most {at_most} are allowed")


def quick_check(copy, check, sources):
    """Compiles check.cpp with the files that it needs, in the copy, and runs it."""
    compiler = os.environ.get("CXX", "c++")
    eigen = subprocess.run(["pkg-config", "--cflags", "eigen3"], capture_output=True, text=True, check=False).stdout.split()
    build = copy / "build"
    build.mkdir()
    model = copy / "firmware" / "model"
    run(["cmake", f"-DFOLDER={model / 'translation'}", f"-DHEADER={build / 'firmware/model/translation_list.h'}",
         "-P", model / "list_effects.cmake"], copy, "list")
    flags = ["-std=c++20", "-O0", "-Wall", "-Wextra", "-Werror", "-I", copy, "-I", build] + eigen
    run([compiler, *flags, check, *[copy / source for source in sources], "-o", build / "check"], copy, "compile")
    run([build / "check"], copy, "check")


def build_lab(copy):
    build = copy / "build" / "host-release"
    run(["cmake", "--preset", "host-release"], copy, "configure")
    run(["cmake", "--build", build, "--target", "m100-lab"], copy, "build")
    return build / "host_tests" / "lab" / "m100-lab"


class Flown:
    """Follows an effect: simulated with a plant file, identified blind, in the vehicle file and in the report."""

    def __init__(self, copy, plant):
        """Builds the copy and simulates flights with the plant, which the controller does not know."""
        self.copy, self.lab, self.out = copy, build_lab(copy), copy / "build" / "flights"
        self.out.mkdir()
        (self.out / "plant.toml").write_text(plant, encoding="utf-8")
        run([self.lab, "loop", "--plant", self.out / "plant.toml", "--out", self.out / "after.toml", "--logs", self.out],
            copy, "loop")

    def identify(self, axis, declared):
        run([self.lab, "identify", "--axis", axis, "--log", self.out / "loop_train.ulg",
             "--columns", self.out / "columns.toml", "--declare", declared, "--split", "alternate:6",
             "--vehicle", self.out / "found.toml", "--json", self.out / f"{axis}.json", "--report", self.out],
            self.copy, "identify")

    def is_found(self, axis, effect):
        found = [one["name"] for one in json.loads((self.out / f"{axis}.json").read_text(encoding="utf-8"))["effects"]]
        print("  identified: " + ", ".join(found))
        if effect not in found:
            raise Broken(f"the effect was simulated but not identified; identified: {found}")

    def is_written(self, key, flown, tolerance):
        vehicle = (self.out / "found.toml").read_text(encoding="utf-8").splitlines()
        written = [line for line in vehicle if line.startswith(key)]
        if not written or abs(float(written[0].split("=")[1]) - flown) > tolerance:
            raise Broken(f"the vehicle file has {written}, the simulated value is {flown}")
        print("  vehicle file: " + written[0])

    def is_reported(self, axis, sentence):
        if sentence not in (self.out / f"{axis}.html").read_text(encoding="utf-8"):
            raise Broken("the report does not explain the effect")


# ---- an effect of a stick axis ---------------------------------------------------------------------------------------

AXIS_NAME = "motion_gain"
AXIS_KEY = "motion_gain_ratio"
AXIS_RATIO = 1.5


def add_axis_effect(copy):
    """A gain that differs with the direction of the stick's motion: a member and its law, and a row."""
    law = "firmware/model/stick_axis.h"
    insert(copy, law, "  double cross_axis = 0.0;",
           f"  double {AXIS_KEY} = 1.0;  ///< gain while the stick rises over gain while it falls; their mean is the scale\n")
    insert(copy, law, "        slew_per_sample_(real(axis.command_slew_per_s)",
           f"        rising_gain_(Real(2) * real(axis.{AXIS_KEY}) / (Real(1) + real(axis.{AXIS_KEY}))),\n")
    insert(copy, law, "  Real slew_per_sample_;", "  Real rising_gain_;\n  bool is_rising_ = false;\n  Real last_counts_ = Real(0);\n")
    insert(copy, law, "    if (backlash_counts_ > Real(0)) {",
           "    if (rising_gain_ != Real(1)) {\n"
           "      is_rising_ = stick_counts != last_counts_ ? stick_counts > last_counts_ : is_rising_;\n"
           "      last_counts_ = stick_counts;\n"
           "      const Real gain = is_rising_ ? rising_gain_ : Real(2) - rising_gain_;\n"
           "      stick_counts = trim_counts_ + gain * (stick_counts - trim_counts_);\n"
           "    }\n")
    insert(copy, "firmware/model/axis_effects.h", "};  // kAxisEffects",
           f'    AxisEffect{{.name = "{AXIS_NAME}",\n'
           f'               .numbers = {{AxisNumber{{.parameter = "ratio_up_over_down",\n'
           f'                                      .member = &StickAxis::{AXIS_KEY},\n'
           f'                                      .file = everywhere("{AXIS_KEY}", {{0.2, 5.0}}),\n'
           "                                      .fit = {0.25, 4.0},\n"
           "                                      .logarithmic = true,\n"
           "                                      .min_relevant = 0.08,\n"
           "                                      .neutral = 1.0}},\n"
           "               .starts = {{1.0}, {1.3}},\n"
           "               .typical = {1.3},\n"
           '               .sentence = "The stick answers more while it rises than while it falls."},\n')


def fly_axis_effect(copy):
    """All steps; in addition, the forecast of manoeuvres must know the effect."""
    measured = {"roll": ("scale_rad_per_count = 9.23e-4", "natural_frequency_rad_s = 9.26", "damping_ratio = 0.703"),
                "pitch": ("scale_rad_per_count = 9.22e-4", "natural_frequency_rad_s = 8.05", "damping_ratio = 0.612")}
    flown = Flown(copy, "".join("[axis." + axis + "]\n" + "\n".join(lines) + "\n" +
                                (f"{AXIS_KEY} = {AXIS_RATIO}\n" if axis == "roll" else "")
                                for axis, lines in measured.items()))
    flown.identify("roll", "second_order,transport_delay")
    flown.is_found("roll", AXIS_NAME)
    flown.is_written(AXIS_KEY, AXIS_RATIO, 0.2)
    flown.is_reported("roll", f"{AXIS_NAME}: The stick answers more")
    run([flown.lab, "excite", "--axis", "roll", "--json", flown.out / "forecast.json"], copy, "excite")
    forecast = json.loads((flown.out / "forecast.json").read_text(encoding="utf-8"))["forecast"]
    if not any(one["effect"] == AXIS_NAME and one["sigma"] > 1.0 for one in forecast):
        raise Broken("the forecast of manoeuvres does not know the effect")


# ---- an effect of an axis' response ---------------------------------------------------------------------------------

RISE_NAME = "rise_limit"
RISE_KEY = "rise_limit_per_s"
RISE_LIMIT = 0.7


def add_response_effect(copy):
    """A response that rises no faster than a limit, and falls freely: a member and its law, and a row."""
    law = "firmware/model/stick_axis.h"
    insert(copy, law, "  double cross_axis = 0.0;", f"  double {RISE_KEY} = 0.0;  ///< y' limit\n")
    insert(copy, law, "  bool acts() const {", "  bool rises() const { return rise_per_s_ > Real(0); }\n")
    insert(copy, law, "    return limit_per_s_ > Real(0) ? core::clamp(rate_per_s,",
           "    if (rises()) {\n      rate_per_s = rate_per_s < rise_per_s_ ? rate_per_s : rise_per_s_;\n    }\n")
    insert(copy, law, "    return after;",
           "    if (rises() && after - before > rise_per_s_ * step_s) {\n      after = before + rise_per_s_ * step_s;\n    }\n")
    insert(copy, law, "  Real limit_per_s_;", "  Real rise_per_s_ = Real(0);\n")
    replace(copy, law, "(static_cast<Real>(axis.rate_limit_per_s)) {}",
            f"(static_cast<Real>(axis.rate_limit_per_s)) {{\n    rise_per_s_ = static_cast<Real>(axis.{RISE_KEY});\n  }}")
    replace(copy, law, "bool acts() const { return limit_per_s_ > Real(0); }",
            "bool acts() const { return limit_per_s_ > Real(0) || rises(); }")
    insert(copy, "firmware/model/axis_effects.h", "};  // kAxisEffects",
           f'    AxisEffect{{.name = "{RISE_NAME}",\n'
           f'               .numbers = {{AxisNumber{{.parameter = "rise_per_s",\n'
           f'                                      .member = &StickAxis::{RISE_KEY},\n'
           f'                                      .file = everywhere("{RISE_KEY}", {{0.0, 50.0}}),\n'
           "                                      .unit = AxisNumber::FitUnit::kRate,\n"
           "                                      .fit = {0.05, 6.0},\n"
           "                                      .logarithmic = true}},\n"
           "               .starts = {{0.5}, {0.9}},\n"
           "               .of_response = true,\n"
           "               .typical = {0.6, Typical::Of::kFastestResponse},\n"
           '               .sentence = "The axis turns more slowly to one side than to the other."},\n')


def fly_response_effect(copy):
    """All steps."""
    flown = Flown(copy, "[axis.roll]\nscale_rad_per_count = 9.23e-4\nnatural_frequency_rad_s = 9.26\ndamping_ratio = 0.703\n"
                        f"{RISE_KEY} = {RISE_LIMIT}\n"
                        "[axis.pitch]\nscale_rad_per_count = 9.22e-4\nnatural_frequency_rad_s = 8.05\ndamping_ratio = 0.612\n")
    flown.identify("roll", "second_order,transport_delay")
    flown.is_found("roll", RISE_NAME)
    flown.is_written(RISE_KEY, RISE_LIMIT, 0.1)
    flown.is_reported("roll", f"{RISE_NAME}: The axis turns more slowly")


# ---- an effect of translation ----------------------------------------------------------------------------------------

SIDE_NAME = "side_force"
SIDE_KEY = "side_force_per_s"
SIDE_RATE = 0.3


def add_translation_effect(copy):
    """A force perpendicular to the air velocity, as an inclined wing causes it: one file."""
    (copy / "firmware/model/translation/side_force.h").write_text(f"""// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "firmware/model/translation_effect.h"

namespace m100::model::translation {{

/// A force across the velocity in the air, to its left: a = s (e3 x (v - w)).
struct SideForce {{
  double {SIDE_KEY} = 0.0;
  static constexpr std::array<double SideForce::*, 1> kMembers{{&SideForce::{SIDE_KEY}}};

  static Acceleration column(std::size_t, const Moment& at, double) {{
    return {{-at.air_velocity_w_m_s[1], at.air_velocity_w_m_s[0], 0.0}};
  }}

  static constexpr TranslationEffect kEffect{{
      .name = "{SIDE_NAME}",
      .place = 200,
      .needs = {{.velocity = true}},
      .parameters = {{{{{{.name = "rate_per_s", .low = -5.0, .high = 5.0, .key = "{SIDE_KEY}", .only_if_set = true}}}}}},
      .min_relevant = 0.03,
      .size = magnitude,
      .columns = 1,
      .column = column,
      .drag = Drag::kProportional,
      .in_flight = InFlight::kLeftToTheObserver,
      .sentence = "Flying forward pushes the vehicle aside."}};
}};

}}  // namespace m100::model::translation
""", encoding="utf-8")


def fly_translation_effect(copy):
    """All steps."""
    flown = Flown(copy, f"[air]\n{SIDE_KEY} = {SIDE_RATE}\n")
    flown.identify("translation", "rigid_body")
    flown.is_found("translation", SIDE_NAME)
    flown.is_written(SIDE_KEY, SIDE_RATE, 0.06)
    flown.is_reported("translation", f"{SIDE_NAME}: Flying forward pushes")


# Production code: everything but tests, and but the vehicles that tests keep independent on purpose
# (host_tests/property).
PRODUCTION = ("firmware", "hal", "protocol", "host_tests/lab", "host_tests/sim")
NAMED_IN_AT_MOST = 6
EXAMPLES = {"backlash": r"backlash", "quadratic_drag": r"quadratic_?drag"}


def names_stand_in_few_files(root):
    """An effect that is named in many files has no home. Keys and comments count."""
    for effect, pattern in EXAMPLES.items():
        named = sorted(str(file.relative_to(root)) for folder in PRODUCTION for file in (root / folder).rglob("*")
                       if file.suffix in (".h", ".cpp", ".inc")
                       and re.search(pattern, file.read_text(encoding="utf-8"), re.IGNORECASE))
        print(f"{effect} stands in {len(named)} production files: " + ", ".join(named))
        if not named or len(named) > NAMED_IN_AT_MOST:
            raise Broken(f"{effect} is named in {len(named)} production files, at most {NAMED_IN_AT_MOST} are allowed")


class Recipe:
    """How an effect is added, how many files that may take, and how the test proves that all parts know it."""

    def __init__(self, title, at_most, add, check, sources, fly):
        self.title, self.at_most, self.add, self.check, self.sources, self.fly = title, at_most, add, check, sources, fly


RECIPES = [
    Recipe("a new effect of a stick axis", 2, add_axis_effect, HERE / "axis_effect_arrives.cpp",
           ["firmware/model/stick_axis.cpp", "firmware/core/maths.cpp", "firmware/companion/files/vehicle_keys.cpp",
            "host_tests/lab/identify/model/axis/axis_structure.cpp"],
           fly_axis_effect),
    Recipe("a new effect of an axis' response", 2, add_response_effect, HERE / "response_effect_arrives.cpp",
           ["firmware/model/stick_axis.cpp", "firmware/model/axis_step.cpp", "firmware/core/assert.cpp", "firmware/core/maths.cpp", "firmware/sysid/axis_dynamics.cpp",
            "host_tests/lab/identify/model/axis/axis_structure.cpp", "host_tests/sim/world/axis_motion.cpp"],
           fly_response_effect),
    Recipe("a new effect of translation", 1, add_translation_effect, HERE / "translation_effect_arrives.cpp",
           ["firmware/model/stick_axis.cpp", "firmware/core/assert.cpp", "firmware/core/maths.cpp",
            "firmware/companion/files/vehicle_keys.cpp", "host_tests/sim/world/axis_motion.cpp",
            "host_tests/sim/world/carried_load.cpp", "host_tests/sim/world/plant.cpp", "host_tests/sim/world/vehicle.cpp",
            "host_tests/sim/world/wind.cpp"],
           fly_translation_effect),
]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("scratch", type=pathlib.Path)
    parser.add_argument("--whole", action="store_true")
    options = parser.parse_args()
    root = options.root.resolve()
    failed = False
    try:
        names_stand_in_few_files(root)
    except Broken as reason:
        print(f"  {reason}")
        failed = True
    for number, recipe in enumerate(RECIPES):
        copy = options.scratch.resolve() / str(number)
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(root, copy, ignore=NOT_COPIED)
        print(recipe.title)
        try:
            recipe.add(copy)
            apply_and_count(root, copy, recipe.at_most)
            if options.whole:
                recipe.fly(copy)
            else:
                quick_check(copy, recipe.check, recipe.sources)
            print("  all parts know the effect")
        except Broken as reason:
            print(f"  {reason}")
            failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
