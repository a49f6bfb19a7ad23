# SPDX-License-Identifier: BSD-3-Clause
"""Time until the installed programs give the sticks back (m100_authority_battery): under every fault, and on a lossy line."""
from measure.lab_figures import LAB
from measure.marked import Figure
from measure.workspace import Source

STICKS = "host_tests/scenario/m100_authority_battery"
M100 = "firmware/companion/m100"
TABLE = "host_tests/scenario/table.bin"
VEHICLE = "firmware/mpc/generated/vehicle.toml"
OPEN = "host_tests/scenario/authority/open.txt"


def joined(lines):
    """-> the table with one row for all faults that have the same cells"""
    rows = {}
    for line in lines[2:]:
        fault, _, cells = line.removeprefix("| ").partition(" | ")
        rows.setdefault(cells, []).append(fault)
    return lines[:2] + [f"| {'; '.join(faults)} | {cells}" for cells, faults in rows.items()]


def table_of(battery):
    def measured(workspace):
        def built(path):
            return workspace.program(path, ("host-release",))  # the time limits hold for the program that ships
        printed = workspace.run(built(STICKS), "--battery", battery, "--m100", built(M100), "--lab", built(LAB),
                            "--vehicle", workspace.root / VEHICLE, "--gains", built(TABLE), "--open", workspace.root / OPEN,
                            may_fail=True)  # the table shows failures, too
        return {f"sticks.{battery}": Figure("\n".join(joined([line for line in printed.splitlines() if line.startswith("|")])))}
    return measured


SOURCES = [Source((f"sticks.{battery}",), table_of(battery), quick=False) for battery in ("whole", "losses")]
