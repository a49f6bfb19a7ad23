#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Flies the guide's excitation in the guide's room with 24 aircraft: m100-lab excite makes it, m100 flies it.

Usage: excitation_space.py M100 LAB SOURCE

Each aircraft has wind of 0 to 3 m/s from any direction, the measured drag or 0.3 1/s, trims 20 counts off the vehicle
file's, and an attitude loop with a transport delay of 130 to 180 ms, which the vehicle file contains. A flight that is
aborted, or that moves farther than the 3 m of its design, fails.
"""
import json
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import time

DELAYS_S = (0.13, 0.145, 0.16, 0.18)
DRAGS_PER_S = (0.0144, 0.3)
FENCE_M = 3.0
TRIM_COUNTS = 20.0
SEEDS = range(1, 25)


def with_delay(vehicle, delay_s):
    """@returns the vehicle file with this transport delay on both tilt axes, and their trims by axis."""
    lines, trims, section = [], {}, ""
    for line in vehicle.splitlines():
        section = line.strip() if line.startswith("[") else section
        axis = {"[axis.roll]": "roll", "[axis.pitch]": "pitch"}.get(section)
        if axis and line.startswith("transport_delay_s"):
            line = f"transport_delay_s = {delay_s}"
        if axis and line.startswith("trim_counts"):
            trims[axis] = float(re.split("[=#]", line)[1])
        lines.append(line)
    return "\n".join(lines) + "\n", trims


def plant_of(seed, delay_s, trims):
    chance = random.Random(seed)
    speed_m_s, angle_rad = chance.uniform(0.0, 3.0), chance.uniform(0.0, 2.0 * math.pi)
    lines = ["[air]", f"linear_drag_per_s = {DRAGS_PER_S[seed // len(DELAYS_S) % 2]}",
             f"wind_m_s = [{speed_m_s * math.cos(angle_rad):.3f}, {speed_m_s * math.sin(angle_rad):.3f}, 0.0]"]
    for axis, trim in trims.items():
        lines += [f"[axis.{axis}]", f"transport_delay_s = {delay_s}",
                  f"trim_counts = {trim + chance.choice((-TRIM_COUNTS, TRIM_COUNTS))}"]
    return "\n".join(lines) + "\n"


class Room:
    def __init__(self, m100, lab, source, work):
        self.m100, self.lab, self.work = m100, lab, work
        self.vehicle = (source / "firmware/mpc/generated/vehicle.toml").read_text()
        self.flight = str(source / "firmware/companion/files/example/flight.toml")

    def make(self, delay_s):
        """Makes table and sticks for one vehicle file, once. @returns their folder and the file's trims."""
        folder = self.work / f"vehicle_{delay_s}"
        text, trims = with_delay(self.vehicle, delay_s)
        if not folder.exists():
            folder.mkdir()
            (folder / "believed.toml").write_text(text)
            for words in (["gains", "--vehicle", "believed.toml", "--tune", "vehicle.toml", "--table", "gains.bin"],
                          ["excite", "--axis", "roll,pitch", "--duration", "40", "--amplitude", "150", "--fence",
                           str(FENCE_M), "--vehicle", "vehicle.toml", "--out", "sticks.csv"]):
                subprocess.run([self.lab, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        return folder, trims

    def fly(self, seed):
        """@returns what is wrong with the flight; empty if nothing is."""
        delay_s = DELAYS_S[seed % len(DELAYS_S)]
        made, trims = self.make(delay_s)
        folder = self.work / f"flight_{seed}"
        folder.mkdir()
        (folder / "plant.toml").write_text(plant_of(seed, delay_s, trims))
        world = folder / "world"
        with subprocess.Popen([self.lab, "autopilot", "--sim", str(world), "--plant", "plant.toml", "--seed", str(seed),
                               "--events", "events.json"], cwd=folder, stdout=subprocess.DEVNULL) as autopilot:
            try:
                while not world.exists() and autopilot.poll() is None:
                    time.sleep(0.01)
                run = subprocess.run(
                    [self.m100, "fly", "--port", f"sim:{world}", "--pose-port", f"sim:{world}.pose", "--vehicle",
                     str(made / "vehicle.toml"), "--gains", str(made / "gains.bin"), "--flight", self.flight, "--excite",
                     str(made / "sticks.csv"), "--take-control", "--once", "--hold", "5", "--log", "flight.ulg", "--json",
                     "flight.json"], cwd=folder, capture_output=True, text=True, check=False)
            finally:
                autopilot.terminate()
        if run.returncode != 0:
            return f"m100 ended with {run.returncode}: {run.stdout[-900:]}{run.stderr}"
        farthest_m = 0.0
        for line in (folder / "events.json").read_text().splitlines():
            event = json.loads(line)
            if event.get("what") == "truth":
                farthest_m = max(farthest_m, abs(event["x_m"]), abs(event["y_m"]))
        flown = json.loads((folder / "flight.json").read_text())["excitation"]
        print(f"seed {seed}, {1000 * delay_s:.0f} ms: {flown['flown']} of {flown['pieces']} pieces, at most {farthest_m:.2f} m from "
              "the start", flush=True)
        return "" if flown["over"] and farthest_m < FENCE_M else f"was {farthest_m:.2f} m from its start: {flown}"


def main():
    m100, lab, source = (pathlib.Path(name).resolve() for name in sys.argv[1:4])
    with tempfile.TemporaryDirectory() as work:
        room = Room(str(m100), str(lab), source, pathlib.Path(work))
        wrong = {seed: why for seed in SEEDS if (why := room.fly(seed))}
    for seed, why in wrong.items():
        print(f"FAILED: seed {seed}: {why}")
    print(f"{len(SEEDS) - len(wrong)} of {len(SEEDS)} excitations were flown to their end inside {FENCE_M} m")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
