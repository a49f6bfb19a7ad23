# SPDX-License-Identifier: BSD-3-Clause
"""Lists the tests that hold each promise of firmware/safety/PROMISES.md. Each test names its promises itself.

GoogleTest: RecordProperty("promise", "R4") or ("promise", "R4, R5"). Any other test: the line
`# Holds promise R7: arm.tick_cost` beside its add_test in the CMakeLists.txt.
"""
import re

from measure import recorded
from measure.marked import Figure

PAGE = "firmware/safety/PROMISES.md"
HEADING = re.compile(r"^### (R\d+)\. (.+)$", re.MULTILINE)
IN_CMAKE = re.compile(r"^\s*# Holds promises? (R\d+(?:, R\d+)*): (.+)$", re.MULTILINE)


def stated(root):
    """-> {"R4": "Authority", ...}, from the headings of the page."""
    return dict(HEADING.findall((root / PAGE).read_text()))


def ids(value):
    return [one.strip() for one in value.split(",")]


def of_sources(root):
    """-> [(promise, kind of test, its name)]"""
    out = []
    for file in sorted((root / "host_tests").rglob("*.cpp")):
        text = file.read_text()
        if 'RecordProperty("promise"' not in re.sub(r"\(\s+", "(", text):
            continue
        kind = file.relative_to(root / "host_tests").parts[0]
        try:
            calls = recorded.calls_of(text)
        except ValueError as error:
            raise ValueError(f"{file.relative_to(root)}: {error}") from error
        for call in calls:
            if call.key == "promise":
                out += [(promise, kind, f"{call.suite}.{call.test}") for promise in ids(call.value)]
    return out


def of_cmake(root):
    """-> [(promise, kind of test, its name)]. ValueError: the last word of a name does not occur in its file."""
    out = []
    for file in sorted((root / "host_tests").rglob("CMakeLists.txt")):
        text = file.read_text()
        for line in IN_CMAKE.finditer(text):
            for name in ids(line[2]):
                word = [part for part in name.split(".") if part != "*"][-1]
                if word not in text.replace(line[0], ""):
                    raise ValueError(f"{file.relative_to(root)}: there is no test {name}")
                out += [(promise, name.split(".")[0], name) for promise in ids(line[1])]
    return out


def holders(root):
    """-> {"R4": {(kind of test, name)}, ...} for every promise of the page. ValueError: the page lacks a promise."""
    out = {promise: set() for promise in stated(root)}
    for promise, kind, name in of_sources(root) + of_cmake(root):
        if promise not in out:
            raise ValueError(f"{name} holds {promise}, which {PAGE} does not state")
        out[promise].add((kind, name))
    return out


def figures(root):
    """-> {"promise.R4": the list of its tests, one line for each kind, ...}"""
    out = {}
    for promise, tests in holders(root).items():
        kinds = sorted({kind for kind, _ in tests})
        lines = [f"- {kind}: " + ", ".join(f"`{name}`" for one, name in sorted(tests) if one == kind) for kind in kinds]
        out["promise." + promise] = Figure("\n".join(lines) if lines else "**open**: no test names this promise yet.")
    return out
