#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""In the worlds that ship no aircraft swings by itself, and the watch in flight does not say so (promise R17).

Usage: healthy.py M100_LAB [--flights N] [--seed N]
Flies N (default 12: 1008 flights) flights of each of the six tasks in each world, and names those in which a swing was
noticed. Whether they stay is another question: exit 1 for a swing alone.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

WORLDS = pathlib.Path(__file__).resolve().parents[2] / "lab/campaign/worlds"


def value(words, option, otherwise):
    return words[words.index(option) + 1] if option in words else otherwise


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
    noticed = [flight for flight in flown if flight["swing_noticed_s"] >= 0.0]
    for flight in noticed:
        print(f"{flight['world']}, {flight['task']}, seed {flight['seed']}: at {flight['swing_noticed_s']:.1f} s")
    print(f"{len(noticed)} of {len(flown)} flights: a swing was noticed")
    return 1 if noticed or not flown else 0


if __name__ == "__main__":
    sys.exit(main())
