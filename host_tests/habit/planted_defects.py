#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A test of the tests: plants defects one by one; the tests have to find each.

Usage: planted_defects.py ROOT SCRATCH [--only NAME]
       planted_defects.py ROOT --stale    only looks whether the text of each defect is still in the code; takes no time
Copies the tree to SCRATCH and builds it there. For each defect it edits one place, builds, and runs the tests that
should find it. A defect that no test finds, or whose text is no longer in the code, is a failure. A defect that does
not compile counts as found (a static_assert is a test, too) and is listed as such.
"""
import pathlib
import shutil
import subprocess
import sys

# name, file, original text, planted text, tests that should find it (ctest -R)
DEFECTS = [
    ("crc32_seed", "protocol/crc.h", "0x00003AA3", "0x00003AA1", r"protocol"),
    ("parser_accepts_short_length", "protocol/dji/frame_parser.cpp",
     "length < kFrameOverheadBytes && length != kHeaderBytes", "length < 1 && length != kHeaderBytes", r"protocol"),
    ("parser_skips_a_byte_too_many", "protocol/dji/frame_parser.cpp", "begin_;; ++at) {", "begin_;; at += 2) {", r"protocol"),
    ("absurd_padding_passes", "protocol/dji/frame_parser.cpp", "} else if (!padding_makes_sense(at, length)) {",
     "} else if (!padding_makes_sense(at, length) && length == 0) {", r"protocol"),
    ("repeat_executes_twice", "protocol/dji/session.cpp",
     "if (!slot.used || slot.sequence != header.sequence) {", "if (true) {", r"protocol"),
    ("one_try_too_many", "protocol/dji/session.cpp", "if (late.sent >= late.transmissions)",
     "if (late.sent > late.transmissions)", r"protocol"),
    ("late_answer_taken", "protocol/dji/session.cpp", "      slot(header.session).sequence != header.sequence) {",
     "      false) {", r"protocol"),
    ("ring_overwrites_when_full", "firmware/core/spsc_ring.h", "if (head - tail == kCapacity) {",
     "if (head - tail == kCapacity + 1) {", r"unit\.core"),
    ("frames_turned_about_y", "firmware/core/frames.h", "return {v.x(), -v.y(), -v.z()};",
     "return {-v.x(), v.y(), -v.z()};", r"unit\.core"),
    ("sine_last_bit", "firmware/core/maths_series.h", "-1.66666666666666324348e-01", "-1.66666666666666352e-01", r"core"),
    ("ladder_ignores_pilot", "firmware/safety/failsafe.h",
     "      Row{In::kNominal, When::kNone, When::kCommandable, In::kSilent, Why::kControlGone},\n", "", r"safety"),
    ("coast_never_ends", "firmware/safety/supervisor.cpp", "inside >= limits_.coast,",
     "inside >= 100 * limits_.coast,", r"safety"),
    ("slew_not_limited", "firmware/safety/supervisor.cpp", "core::clamp(inside, last - most, last + most)",
     "inside", r"safety"),
    ("nan_command_passes", "firmware/safety/supervisor.cpp", "return value >= T(-2) * range && value <= T(2) * range;",
     "return !(value < T(-2) * range) && !(value > T(2) * range);", r"safety"),
    ("authority_asks_by_itself", "firmware/safety/authority_table.h",
     "Row{S::kSilent, kControlRequested, kNone, S::kAwaitingTelemetry,",
     "Row{S::kSilent, kNone, kNone, S::kAwaitingTelemetry,", r"safety|link"),
    ("vehicle_range_unchecked", "firmware/companion/files/text/toml_text.cpp",
     "if (!(number() >= low && number_ <= high)) {", "if (number() < low - 1e9) {", r"vehicle_file"),
    ("digest_of_half_the_file", "firmware/companion/files/vehicle_file.cpp",
     "std::span(text.data(), text.size())", "std::span(text.data(), text.size() / 2)", r"vehicle_file"),
    ("trim_of_one_axis_only", "firmware/est/trim_monitor.h",
     "(beyond(report_.roll_counts) || beyond(report_.pitch_counts))", "beyond(report_.pitch_counts)", r"TrimMonitor"),
    ("trim_to_the_wrong_side", "firmware/est/trim_monitor.h", "{.roll = -roll_rad *", "{.roll = roll_rad *", r"TrimMonitor"),
    ("shape_of_the_dead_zone_lost", "host_tests/lab/identify/output/vehicle_update.cpp",
     'if (result.final_model.dead_zone_shape == "jump") {', 'if (result.final_model.dead_zone_shape == "none") {',
     r"ToVehicle"),
]


def run(command, **options):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)


def build_and_test(tree, build, tests):
    """-> which step failed: "compile", "test", or None."""
    if run(["cmake", "--build", build, "-j", "2"]).returncode != 0:
        return "compile"
    result = run(["ctest", "--test-dir", build, "-R", tests, "-LE", "soak|habit|scenario", "--no-tests=error", "-j", "2"],
                 cwd=tree)
    return "test" if result.returncode != 0 else None


def stale(root):
    """Names the defects whose text is no longer in the code: they could not be planted at night."""
    out = []
    for name, file, find, _, _ in DEFECTS:
        count = (root / file).read_text().count(find) if (root / file).is_file() else 0
        if count == 0:
            out.append(f"{name}: {file} no longer contains {find!r}")
    return out


def main():
    if "--stale" in sys.argv:
        found = stale(pathlib.Path(sys.argv[1]))
        print(*found, f"{len(DEFECTS)} defects, {len(found)} stale", sep="\n")
        return 1 if found else 0
    root, scratch = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    only = sys.argv[sys.argv.index("--only") + 1] if "--only" in sys.argv else None
    tree = scratch / "tree"
    build = str(scratch / "build")
    tree.mkdir(parents=True, exist_ok=True)
    for name in run(["git", "ls-files"], cwd=root).stdout.split("\n"):
        if name and (root / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, tree / name)
    run(["cmake", "-S", str(tree), "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release"])
    if build_and_test(tree, build, "core") is not None:
        print("the unchanged tree does not build, or fails its tests")
        return 1
    missed = 0
    for name, file, find, replace, tests in DEFECTS:
        if only and name != only:
            continue
        path = tree / file
        sound = path.read_text()
        if find not in sound:
            print(f"{name:32s} STALE: {file} no longer contains the text", flush=True)
            missed += 1
            continue
        path.write_text(sound.replace(find, replace, 1))
        found = build_and_test(tree, build, tests)
        path.write_text(sound)
        print(f"{name:32s} {'MISSED' if found is None else 'found by a ' + found}", flush=True)
        missed += found is None
    print(f"{len(DEFECTS)} defects planted, {missed} not found")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
