#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""`m100 handshake` says what it sees of the autopilot as keys of guide/FIRST_CONTACT.md; with those keys in a file,
`m100-lab autopilot --real` behaves so, and the next handshake sees it.

Usage: first_contact_test.py M100 LAB. Prints one line per offence.
"""
import pathlib
import re
import sys
import tempfile

from mistakes_test import World, run

# The file, and what a handshake with that autopilot says.
CASES = [
    ("", {"telemetry.before_activation": "true", "control.requests_to_obtain": "2", "telemetry.obeys_rates": "true",
          "virtual_rc.shown_in_rc_item": "true"}),
    ("[telemetry]\nbefore_activation = false\n[control]\nrequests_to_obtain = 1\n[virtual_rc]\nshown_in_rc_item = false\n",
     {"telemetry.before_activation": "false", "control.requests_to_obtain": "1", "virtual_rc.shown_in_rc_item": "false"}),
    ("[telemetry]\nobeys_rates = false\n", {"telemetry.obeys_rates": "false"}),  # status too seldom for control
]
LOSSES = [("", "true"), ("[control]\nlost_push = false\n", "false")]


def handshake(m100, lab, folder, text, *words):
    real = folder / "real.toml"
    real.write_text(text)
    with World(lab, folder, "--real", str(real), *words) as world:
        _, out, err = run(m100, ["handshake", "--port", world.port, "--hold", "3"])
    seen = dict(re.findall(r"first contact: (\S+) = (\w+)", out))
    differs = set(re.findall(r"first contact: (\S+) = \w+; assumed", out))
    return seen, differs, out + err


def main():
    m100, lab = sys.argv[1:3]
    offences = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for text, wanted in CASES:
            seen, differs, said = handshake(m100, lab, folder, text)
            if seen | wanted != seen or differs != (set(wanted) if text else set()):
                offences.append(f"{text!r}: handshake says {seen}, differing {differs}, wanted {wanted}: {said}")
        script = folder / "leave.txt"
        script.write_text("4 mode A\n")
        for text, wanted in LOSSES:
            seen, _, said = handshake(m100, lab, folder, text, "--script", str(script))
            if seen.get("control.lost_push") != wanted:
                offences.append(f"{text!r}: handshake says {seen} when the switch leaves F: {said}")
        code, _, err = run(lab, ["autopilot", "--pty", str(folder / "pty"), "--real", str(folder / "none.toml")])
        if code != 2 or "none.toml: cannot be read" not in err:
            offences.append(f"a missing --real: exit code {code}, {err!r}")
        (folder / "typo.toml").write_text("[movement]\ntimeout = 1.0\n")
        code, _, err = run(lab, ["autopilot", "--pty", str(folder / "pty"), "--real", str(folder / "typo.toml")])
        if code != 2 or "typo.toml:2: 'movement.timeout': unknown key; did you mean `timeout_s`?" not in err:
            offences.append(f"an unknown key of --real: exit code {code}, {err!r}")
    print("\n".join(offences))
    return 1 if offences else 0


if __name__ == "__main__":
    sys.exit(main())
