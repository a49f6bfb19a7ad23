# SPDX-License-Identifier: BSD-3-Clause
"""Figures that tests measure: RecordProperty("figure.NAME", text), or ("figure.PREFIX." + rest, text) for a family.

Of each test program, only these tests are run. Programs of the labels `scenario`, `soak` and `arm` run only at night.
"""
import collections
import json
import pathlib
import re
import tempfile

from measure import recorded
from measure.marked import Figure
from measure.workspace import NotMeasuredHere, Source

OUTPUT = re.compile(r" -o (?P<folder>\S*)/CMakeFiles/(?P<program>[\w.-]+)\.dir/\S*\.o ")


def recording_tests(root):
    """-> {source file: [Call of a figure]}"""
    out = {}
    for file in sorted((root / "host_tests").rglob("*_test.cpp")):
        text = file.read_text()
        if '"figure.' in text:
            out[file] = [call for call in recorded.calls_of(text) if call.key.startswith("figure.")]
    return out


def sources_of(file):
    """-> the source itself, or the sources that CMake joined in a unity file."""
    if file.parent.name == "Unity":
        return [pathlib.Path(name) for name in re.findall(r'^#include "(.*)"$', file.read_text(), re.MULTILINE)]
    return [file]


def programs_of(root):
    """-> {source file: [test program's path in a build folder]}, from the builds' compile commands."""
    out = collections.defaultdict(list)
    for build in ("host-release", "host-debug"):
        file = root / "build" / build / "compile_commands.json"
        for entry in json.loads(file.read_text()) if file.is_file() else []:
            found = OUTPUT.search(entry["command"])
            if found:
                program = f"{found['folder']}/{found['program']}"
                for source in sources_of(pathlib.Path(entry["file"])):
                    if program not in out[source]:
                        out[source].append(program)
    return out


def measure(workspace, program, calls):
    """Runs the tests of the calls; a test that is skipped measures nothing."""
    file = workspace.program(program)
    names = ":".join(sorted({recorded.gtest_filter(call.suite, call.test) for call in calls}))
    out = {}
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.json"
        workspace.run(file, f"--gtest_filter={names}", f"--gtest_output=json:{report}")
        for suite in json.loads(report.read_text())["testsuites"]:
            for test in [suite] + suite["testsuite"]:
                out.update({key.removeprefix("figure."): Figure(value) for key, value in test.items()
                            if key.startswith("figure.")})
    if not out:
        raise NotMeasuredHere(f"{program}: its tests were skipped")
    return out


def is_long(program):
    """Whether the program takes minutes or needs the ARM builds: for the nightly run."""
    return program.rsplit("/", 1)[-1].startswith(("scenario_", "soak_", "arm_"))


def sources(root):
    programs = programs_of(root)
    out = []
    for file, calls in recording_tests(root).items():
        prefixes = tuple(sorted({call.key.removeprefix("figure.") for call in calls}))
        for program in programs.get(file, [f"the program of {file.name}"]):
            out.append(Source(prefixes, lambda workspace, program=program, calls=calls: measure(workspace, program, calls),
                              quick=not is_long(program)))
    return out
