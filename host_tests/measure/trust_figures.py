# SPDX-License-Identifier: BSD-3-Clause
"""How far the tests themselves are tested: rows of the safety tables, states of the model, mutants, lines and branches."""
import json
import re

from measure.marked import Figure
from measure.place import NotMeasuredHere, Source


def rows(place):
    program = place.program("host_tests/unit/unit_safety_rows")
    said = place.run(place.root / "host_tests/unit/safety/every_row_is_missed.sh", program, may_fail=True)
    return {"trust.rows": Figure(re.search(r"^rows: (\d+ of \d+)$", said, re.MULTILINE)[1])}


def states(place):
    program = place.program("host_tests/model_check/promela", builds=("host-release",))
    place.tool("spin")
    said = place.run(place.root / "host_tests/model_check/check.sh", program, place.root / "build/model_check", "--sound")
    counts = [float(text) for text in re.findall(r"^([\d.e+]+) states$", said, re.MULTILINE)]
    return {"trust.states": Figure(" and ".join(f"{count / 1e6:.2f} million" for count in counts), 0.02)}


def mutants(place):
    note = place.root / "build" / "mutants" / "result.json"
    if not note.is_file():
        raise NotMeasuredHere("host_tests/mutants has not run to its end here")
    counts = json.loads(note.read_text())
    judged = counts["noticed"] + counts["alive"]
    return {"trust.mutants": Figure(f"{counts['noticed']} of {judged} ({100 * counts['noticed'] / judged:.0f} %), drawn from "
                                    f"{counts['of']} with seed {counts['seed']}", 0.02)}


def coverage(place):
    note = place.root / "build" / "coverage" / "result.json"
    if not note.is_file():
        raise NotMeasuredHere("host_tests/coverage has not run to its end here")
    counts = json.loads(note.read_text())
    lines, branches = counts["run"] / counts["lines"], counts["taken"] / counts["branches"]
    return {"trust.coverage": Figure(f"{100 * lines:.1f} % of {counts['lines']} lines, {100 * branches:.1f} % of "
                                     f"{counts['branches']} branches", 0.02)}


SOURCES = [Source(("trust.rows",), rows), Source(("trust.states",), states, quick=False),
           Source(("trust.mutants",), mutants, quick=False), Source(("trust.coverage",), coverage, quick=False)]
