#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks promise R17 in the shipped worlds: no monitor, gate or alarm reports anything. In no flight is a limit cycle
noticed, poses or attitude called false, an axis reported as having left its model, or a pose refused for long enough
that the failsafe would act.

Usage: healthy.py M100_LAB [--flights N] [--seed N]
Flies N (default 12: 1008 flights) flights of each of the six tasks in each world, and names those with a false alarm.
Exit 1 only for a false alarm; whether the flights stay is not checked here.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

from changes import value

WORLDS = pathlib.Path(__file__).resolve().parents[2] / "lab/campaign/worlds"


# Keys of a flight's record, and the largest value that is no alarm. Poses after a gap may be refused while the observer
# waits for three that agree, for at most 0.1 s: 24 poses at 240 Hz.
MAX_CHANGE = {"limit_cycle_detected_s": -1.0, "contradicted": False, "left_model": False, "refused_poses": 24}


def main():
    words = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        answer = pathlib.Path(folder) / "answer.json"
        command = [words[0], "campaign", *map(str, sorted(WORLDS.glob("*.toml"))), "--json", str(answer),
                   "--flights", value(words, "--flights", "12"), "--seed", value(words, "--seed", "201")]
        code = subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode
        if code > 1:
            print(f"m100-lab campaign ended with {code}", file=sys.stderr)
            return 2
        flown = json.loads(answer.read_text())["flown"]
    spoke = [(flight, [f"{key} {flight[key]}" for key, most in MAX_CHANGE.items() if flight[key] > most]) for flight in flown]
    spoke = [(flight, what) for flight, what in spoke if what]
    for flight, what in spoke:
        print(f"{flight['world']}, {flight['task']}, seed {flight['seed']}: {', '.join(what)}")
    print(f"{len(spoke)} of {len(flown)} flights with a false alarm")
    return 1 if spoke or not flown else 0


if __name__ == "__main__":
    sys.exit(main())
