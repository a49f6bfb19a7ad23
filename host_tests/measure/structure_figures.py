# SPDX-License-Identifier: BSD-3-Clause
"""The shape of the tree: what host_tests/habit/structure.py counts."""
import sys

from measure.marked import Figure
from measure.workspace import Source


def shape(workspace):
    printed = workspace.run(sys.executable, "host_tests/habit/structure.py", ".", "--table")
    return {"structure.table": Figure(printed.strip(), 0.02)}


SOURCES = [Source(("structure.",), shape)]
