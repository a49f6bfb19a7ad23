# SPDX-License-Identifier: BSD-3-Clause
"""All sources of figures: lists of tests by promise, figures that tests record, and the modules *_figures.py here."""
import importlib
import pathlib

from measure import promises, tests_record
from measure.workspace import Source


def all_sources(root):
    out = [Source(("promise.",), lambda workspace: promises.figures(workspace.root))] + tests_record.sources(root)
    for file in sorted(pathlib.Path(__file__).parent.glob("*_figures.py")):
        out += importlib.import_module(f"measure.{file.stem}").SOURCES
    return out
