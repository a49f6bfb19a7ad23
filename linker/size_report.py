#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Flash and RAM of an image by module, from the linker's map, held to budget.txt.

Usage: size_report.py IMAGE.map BUDGET.txt     exit 1: over budget
Flash counts code, constants and the start values of variables; RAM counts variables and the reserved stack. The
section .harness, which only emulator runs fill, is printed but is in no budget.
"""
import collections
import re
import sys

FLASH = {".vectors", ".text", ".rodata", ".ARM.exidx", ".init_array"}
BOTH = {".data"}
RAM = {".bss", ".stack"}
OUTPUT = re.compile(r"^(\.[\w.]+)(?:\s+0x([0-9a-f]+)\s+0x([0-9a-f]+))?")
INPUT = re.compile(r"^ (?:(\.[\w.$*:~<>,()]+|COMMON)\s+|\s+)0x([0-9a-f]+)\s+0x([0-9a-f]+)\s+(\S.*)$")
FILL = re.compile(r"^ \*fill\*\s+0x[0-9a-f]+\s+0x([0-9a-f]+)")


def module(source):
    ours = re.search(r"libm100_(\w+)\.a", source)
    if ours:
        return ours.group(1)
    library = re.search(r"lib(\w+|stdc\+\+)\.a\(", source)
    if library:
        return f"({'gcc' if library.group(1) == 'gcc' else 'lib' + library.group(1)})"
    if "/startup.cpp" in source or "/semihosting.cpp" in source:
        return "startup"
    return "image"


def read_budget(path):
    budget = {}
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            words = line.split("#")[0].split()
            if words:
                budget[words[0]] = int(words[1])
    return budget


def read_map(path):
    """-> {output section: {module: bytes}}, {output section: bytes}"""
    parts = collections.defaultdict(collections.Counter)
    totals = {}
    section = None
    started = False
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            if line.startswith("Linker script and memory map"):
                started = True
            if not started:
                continue
            output = OUTPUT.match(line)
            if output:
                section = output.group(1)
                if output.group(3):
                    totals[section] = int(output.group(3), 16)
                continue
            if section is None:
                continue
            if section not in totals:  # a long name puts its numbers on the next line
                numbers = re.match(r"^\s+0x([0-9a-f]+)\s+0x([0-9a-f]+)", line)
                if numbers:
                    totals[section] = int(numbers.group(2), 16)
                    continue
            found = INPUT.match(line)
            if found and not found.group(4).startswith("0x"):
                parts[section][module(found.group(4))] += int(found.group(3), 16)
                continue
            fill = FILL.match(line)
            if fill:
                parts[section]["(alignment)"] += int(fill.group(1), 16)
    return parts, totals


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    parts, totals = read_map(sys.argv[1])
    budget = read_budget(sys.argv[2])
    flash = collections.Counter()
    ram = collections.Counter()
    for section, modules in parts.items():
        for name, size in modules.items():
            if section in FLASH | BOTH:
                flash[name] += size
            if section in RAM | BOTH and section != ".stack":
                ram[name] += size
    ram["(stack)"] += totals.get(".stack", 0)
    flash_total = sum(totals.get(s, 0) for s in FLASH | BOTH)
    ram_total = sum(totals.get(s, 0) for s in RAM | BOTH)
    print(f"{'module':<16}{'flash':>8}{'RAM':>8}   bytes")
    for name in sorted(set(flash) | set(ram), key=lambda n: -flash[n]):
        if flash[name] or ram[name]:
            print(f"{name:<16}{flash[name]:>8}{ram[name]:>8}")
    print(f"{'total':<16}{flash_total:>8}{ram_total:>8}")
    print(f"{'budget':<16}{budget['flash_bytes']:>8}{budget['ram_bytes']:>8}")
    if totals.get(".harness"):
        print(f"harness (emulator runs only): {totals['.harness']} bytes of RAM, in no budget")
    failed = False
    for what, used in (("flash", flash_total), ("ram", ram_total)):
        if used > budget[what + "_bytes"]:
            print(f"error: budget.txt: {what}_bytes: {used} used, {budget[what + '_bytes']} allowed", file=sys.stderr)
            failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
