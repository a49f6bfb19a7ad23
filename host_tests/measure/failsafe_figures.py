# SPDX-License-Identifier: BSD-3-Clause
"""The failsafe state machine's timers and counts, read from struct Limits of firmware/safety."""
import re

from measure.marked import Figure
from measure.workspace import Source

DURATION = re.compile(r"core::Duration (\w+) = std::chrono::milliseconds\((\d+)\);")
COUNT = re.compile(r"std::uint\w+ (\w+) = (\d+);")


def limits(workspace):
    for file in sorted((workspace.root / "firmware" / "safety").glob("*.h")):
        found = re.search(r"^struct Limits \{(.*?)^\};", file.read_text(), re.MULTILINE | re.DOTALL)
        if found:
            rows = [f"| `{name}` | {value} ms |" for name, value in DURATION.findall(found[1])]
            rows += [f"| `{name}` | {value} |" for name, value in COUNT.findall(found[1])]
            return {"failsafe.limits": Figure("\n".join(["| limit | default |", "|---|---|"] + rows))}
    raise ValueError("no struct Limits in firmware/safety")


SOURCES = [Source(("failsafe.limits",), limits)]
