# SPDX-License-Identifier: BSD-3-Clause
"""Durations of the last runs of the project's two commands, which they write into the build folder."""
from measure.marked import Figure
from measure.workspace import NotMeasuredHere, Source


def minutes_of(command):
    def measured(workspace):
        note = workspace.root / "build" / f"{command}_seconds"
        if not note.is_file():
            raise NotMeasuredHere(f"host_tests/{command} has not run to its end here")
        seconds, cores = note.read_text().split()
        return {f"run.{command}": Figure(f"{max(1, round(int(seconds) / 60))} minutes on {cores} cores", 0.5)}
    return measured


SOURCES = [Source((f"run.{command}",), minutes_of(command), quick=False) for command in ("run_tests", "main_job")]
