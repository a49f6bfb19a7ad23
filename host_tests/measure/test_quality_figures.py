# SPDX-License-Identifier: BSD-3-Clause
"""How well the tests themselves are tested: rows of the safety tables, states of the model, mutants, coverage."""
import json
import re

from measure.marked import Figure
from measure.workspace import NotMeasuredHere, Source


def rows(workspace):
    program = workspace.program("host_tests/unit/unit_safety_transitions")
    said = workspace.run(workspace.root / "host_tests/unit/safety/every_transition_is_missed.sh", program, may_fail=True)
    return {"trust.rows": Figure(re.search(r"^rows: (\d+ of \d+)$", said, re.MULTILINE)[1])}


def states(workspace):
    program = workspace.program("host_tests/model_check/promela", builds=("host-release",))
    workspace.tool("spin")
    said = workspace.run(workspace.root / "host_tests/model_check/check.sh", program, workspace.root / "build/model_check", "--sound")
    counts = [float(text) for text in re.findall(r"^([\d.e+]+) states$", said, re.MULTILINE)]
    return {"trust.states": Figure(" and ".join(f"{count / 1e6:.2f} million" for count in counts), 0.02)}


def mutants(workspace):
    note = workspace.root / "build" / "mutants" / "result.json"
    if not note.is_file():
        raise NotMeasuredHere("host_tests/mutants has not run to its end here")
    counts = json.loads(note.read_text())
    judged = counts["noticed"] + counts["alive"]
    by = ", judged only by the tests of their own part" if counts["part"] else ""
    left = f"; {counts['not_judged']} drawn after these are not judged yet" if counts["not_judged"] else ""
    return {"trust.mutants": Figure(f"{counts['noticed']} of {judged} ({100 * counts['noticed'] / judged:.0f} %){by}; drawn from "
                                    f"{counts['of']} with seed {counts['seed']}; a further {counts['equivalent']} cannot be noticed "
                                    f"and {counts['not_compiled']} do not compile{left}", 0.02)}


def searched(workspace):
    """Largest distance that a fault of one channel moved the aircraft before it was noticed, over the whole search."""
    said = workspace.run(workspace.program("host_tests/scenario/scenario_worst_faults", builds=("host-release",)),
                     "--gtest_filter=*WorstFault*", may_fail=True)
    found = re.findall(r"^([\w.]+) \| ([\d.]+) m \| (.*) \| [\d.]+ m$", said, re.MULTILINE)
    channel, away, when = max(found, key=lambda one: float(one[1]))
    noticed = when if when == "not noticed" else f"noticed after {when}"
    return {"trust.searched": Figure(f"{away} m ({channel}, {noticed})", 0.02)}


def fuzzed(workspace):
    """Number of inputs that the fuzzers try, read from the configured tests."""
    files = [workspace.root / "build" / build / "host_tests" / "fuzz" / "CTestTestfile.cmake" for build in ("host-release", "host-debug")]
    tests = "".join(file.read_text() for file in files if file.is_file())
    by_day = dict(re.findall(r"add_test\(\S*?fuzz\.(\w+)_short\S* .*?\"-runs=(\d+)\"", tests))
    at_night = dict(re.findall(r"add_test\(\S*?fuzz\.(\w+)_long\S* .*?\"-max_total_time=(\d+)\"", tests))
    if not by_day:
        raise NotMeasuredHere("no build with the fuzzers is configured")
    day = ", ".join(f"{name} {int(count):,}".replace(",", " ") for name, count in sorted(by_day.items()))
    night = ", ".join(f"{name} {seconds} s" for name, seconds in sorted(at_night.items()))
    return {"trust.fuzzed": Figure(f"{day} inputs by day; {night} at night")}


def counted(counts):
    """-> the text for counted lines and branches."""
    lines, branches = counts["run"] / counts["lines"], counts["taken"] / counts["branches"] if counts["branches"] else 1.0
    return f"{100 * lines:.1f} % of {counts['lines']} lines, {100 * branches:.1f} % of {counts['branches']} branches"


def coverage(workspace):
    note = workspace.root / "build" / "coverage" / "result.json"
    if not note.is_file():
        raise NotMeasuredHere("host_tests/coverage has not run here")
    parts = json.loads(note.read_text())
    sums = {key: sum(counts[key] for counts in parts.values()) for key in ("lines", "run", "branches", "taken")}
    rows = [f"| `{part}` | " + counted(counts).replace(", ", " | ") + " |" for part, counts in sorted(parts.items())]
    return {"trust.coverage": Figure(counted(sums), 0.02),
            "trust.parts": Figure("\n".join(["| part | lines | branches |", "|---|---|---|", *rows]), 0.02)}


SOURCES = [Source(("trust.rows",), rows), Source(("trust.states",), states, quick=False),
           Source(("trust.mutants",), mutants, quick=False),
           Source(("trust.coverage", "trust.parts"), coverage, quick=False),
           Source(("trust.searched",), searched), Source(("trust.fuzzed",), fuzzed)]
