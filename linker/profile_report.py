#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Instructions of a tick by part, from the samples of `replay RECORDING profile` (host_tests/target/replay.cpp).

Usage: profile_report.py IMAGE.elf SAMPLES.txt [--functions N]
"""
import bisect
import collections
import re
import subprocess
import sys

PARTS = [("mpc", "m100::mpc::"), ("est", "m100::est::"), ("protocol", "m100::protocol::"), ("ref", "m100::ref::"),
         ("ctl", "m100::ctl::"), ("sysid", "m100::sysid::"), ("safety", "m100::safety::"), ("vrc", "m100::vrc::"),
         ("log", "m100::log::"), ("core", "m100::core::"), ("app", "m100::app::"), ("recording", "m100::golden::")]


def part_of(name):
    own = re.sub(r"^.*?(?=m100::)", "", name.split("(")[0] or name)  # without the namespaces of its arguments
    return next((part for part, space in PARTS if own.startswith(space)), "library")


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    functions = []
    for line in subprocess.run(["arm-none-eabi-nm", "-C", sys.argv[1]], check=True, capture_output=True,
                               text=True).stdout.splitlines():
        words = line.split(None, 2)
        if len(words) == 3 and words[1] in "TtWw":
            functions.append((int(words[0], 16) & ~1, words[2]))
    functions.sort()
    starts = [start for start, _ in functions]
    count = collections.Counter()
    callers = collections.Counter()
    by_part = collections.Counter()

    def function_at(address):
        return functions[bisect.bisect_right(starts, address & ~1) - 1][1]

    per_sample = ticks = 0
    with open(sys.argv[2], encoding="utf-8") as lines:
        for line in lines:
            words = line.split()
            if words[0] == "ticks":
                ticks, per_sample = int(words[1]), int(words[3])
            else:
                name, caller = function_at(int(words[0])), function_at(int(words[1]))
                count[name] += 1
                is_library = part_of(name) == "library"
                by_part[part_of(caller if is_library else name)] += 1
                if is_library:
                    callers[f"{name[:20]} from {caller}"] += 1
    scale = per_sample / ticks
    for part, samples in by_part.most_common():
        print(f"{part:<10}{samples * scale:>9.0f} instructions a tick, mean")
    print(f"{'sum':<10}{sum(by_part.values()) * scale:>9.0f}")
    if "--functions" in sys.argv:
        most = int(sys.argv[sys.argv.index("--functions") + 1])
        for name, samples in count.most_common(most) + callers.most_common(most):
            print(f"{samples * scale:>9.0f}  {name[:110]}")


if __name__ == "__main__":
    main()
