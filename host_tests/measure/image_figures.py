# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the ARM builds, which host_tests/arm_tests makes: sizes, stack, instructions per tick on the Cortex-M7."""
import re

from measure.cost_figures import spaced
from measure.lab_figures import table
from measure.marked import Figure
from measure.workspace import NotMeasuredHere, Source

BUILD = "host_tests/target"


def budget(workspace, name="budget.txt"):
    lines = (workspace.root / "linker" / name).read_text().splitlines()
    return {words[0]: int(words[1]) for words in map(str.split, lines) if len(words) == 2 and words[1].isdigit()}


def sizes(workspace):
    """Flash and RAM from the linker's map."""
    image = workspace.program(f"{BUILD}/m100_mps2.elf", ("mps2",))
    allowed = budget(workspace)
    printed = workspace.run("linker/size_report.py", f"{image}.map", "linker/budget.txt", may_fail=True)
    flash, ram = re.search(r"^total\s+(\d+)\s+(\d+)", printed, re.MULTILINE).groups()
    rows = [["", "used [bytes]", "budget [bytes]"],
            ["flash, tables included, without AES", spaced(flash), spaced(allowed["flash_bytes"])],
            [f"RAM, {spaced(allowed['stack_bytes'])} bytes of stack included, logs excluded", spaced(ram), spaced(allowed["ram_bytes"])]]
    return {"image.sizes": table(*rows)}


def companion(workspace):
    workspace.tool("aarch64-linux-gnu-strip")
    rows = [["", "bytes, stripped"]]
    for machine, strip in (("aarch64", "aarch64-linux-gnu-strip"), ("armhf", "arm-linux-gnueabihf-strip")):
        program = workspace.program("firmware/companion/m100", (machine,))
        stripped = program.with_name("m100.stripped")
        workspace.run(workspace.tool(strip), "-o", stripped, program)
        rows.append([f"`m100`, {machine}", spaced(stripped.stat().st_size)])
        stripped.unlink()
    return {"image.companion": table(*rows)}


COLUMN = re.compile(r"^\s*(\d+)\s+(\d+)\s+(\d+)\s{2}(\S.*)$", re.MULTILINE)


def ticks(workspace):
    """Instructions of each part of a tick: in a recorded flight, and with hostile bytes and hard MPC programs."""
    workspace.tool("qemu-system-arm")
    workspace.program(f"{BUILD}/replay.elf", ("mps2",))
    recording = workspace.root / "build" / "determinism" / "flight.recording"
    if not recording.is_file():
        raise NotMeasuredHere("no recorded flight: host_tests/determinism prepare")
    printed = workspace.run("linker/tick_cost", recording, may_fail=True)
    whole = re.findall(r" median (\d+).* worst (\d+)", printed)
    flight, hostile = (COLUMN.findall(half) for half in re.split(r"^hostile", printed, flags=re.MULTILINE))
    rows = [["part", "share of ticks", "median", "worst", "hostile: median", "worst"]]
    for (share, median, worst, name), (_, hostile_median, hostile_worst, _) in zip(flight, hostile):
        rows.append([name, f"{share} %"] + [spaced(n) for n in (median, worst, hostile_median, hostile_worst)])
    rows.append(["**whole tick** (without a log)", ""] + [f"**{spaced(n)}**" for n in whole[0] + whole[1]])
    return {"image.ticks": table(*rows), "image.median": Figure(spaced(whole[0][0])), "image.worst": Figure(spaced(whole[1][1]))}


def cortex_m4f(workspace):
    """The image of the board whose FPU has no double, and its ticks; its parts of a tick are not shown."""
    workspace.tool("qemu-system-arm")
    image = workspace.program(f"{BUILD}/m100_mps2.elf", ("mps2-m4f",))
    workspace.program(f"{BUILD}/replay.elf", ("mps2-m4f",))
    recording = workspace.root / "build" / "determinism" / "flight.recording"
    if not recording.is_file():
        raise NotMeasuredHere("no recorded flight: host_tests/determinism prepare")
    allowed = budget(workspace, "budget_m4f.txt")
    sized = workspace.run("linker/size_report.py", f"{image}.map", "linker/budget_m4f.txt", may_fail=True)
    flash, ram = re.search(r"^total\s+(\d+)\s+(\d+)", sized, re.MULTILINE).groups()
    whole = re.findall(r" median (\d+).* worst (\d+)", workspace.run("linker/tick_cost", recording, "mps2-m4f", may_fail=True))
    rows = [["Cortex-M4F", "measured", "budget"],
            ["flash, tables included [bytes]", spaced(flash), spaced(allowed["flash_bytes"])],
            ["RAM, stack included [bytes]", spaced(ram), spaced(allowed["ram_bytes"])]]
    for (median, worst), mode, label in zip(whole, ("cost", "hostile"), ("tick", "tick, hostile bytes and hardest MPC programs")):
        for number, what in ((median, "median"), (worst, "worst")):
            rows.append([f"{label}, {what} [instructions]", spaced(number), spaced(allowed[f"{mode}_{what}_instructions"])])
    return {"image.cortex_m4f": table(*rows)}


MAX_CHANGES = 64  # kMaxChanges of firmware/mpc/problem.h, in each of two attempts


def active_set(workspace):
    """Cost of a change of the active set on the Cortex-M7, and the cost at the limit of changes, computed from it."""
    emulator = workspace.tool("qemu-system-arm")
    image = workspace.program(f"{BUILD}/active_set_cost.elf", ("mps2",))
    printed = workspace.run("sh", "-c", f"{emulator} -M mps2-an500 -display none -monitor none -serial null -icount shift=0 "
                        f"-semihosting-config enable=on,target=native -kernel '{image}' 2>&1")
    found = [tuple(map(int, row)) for row in re.findall(r"^changes (\d+) solves (\d+) worst (\d+)", printed, re.MULTILINE)]
    worst = {changes: cost for changes, _, cost in found}
    each = max(-(-(cost - worst[0]) // changes) for changes, cost in worst.items() if changes > 0)
    most = max(worst)
    rows = [["changes of the active set", "solves", "most instructions"]]
    rows += [[str(changes), str(solves), spaced(cost)] for changes, solves, cost in found if changes % 8 == 0 or changes == most]
    rows.append(["the most expensive single change", "", spaced(each)])
    rows.append([f"at the limit, {MAX_CHANGES} in each of two attempts (computed)", "", spaced(2 * (worst[0] + MAX_CHANGES * each))])
    return {"image.active_set": table(*rows)}


SOURCES = [Source(("image.active_set",), active_set, quick=False),
           Source(("image.cortex_m4f",), cortex_m4f, quick=False), Source(("image.sizes",), sizes, quick=False),
           Source(("image.companion",), companion, quick=False),
           Source(("image.ticks", "image.median", "image.worst"), ticks, quick=False)]
