#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Flies the dead-zone sweep of m100-lab excite on aircraft with known dead zones, and identifies each from its flight log.

Usage: dead_zone_sweep.py M100 LAB SOURCE [AXIS [FLIGHTS]]

The half widths go evenly from 10 to 60 counts; every aircraft has its own seed, wind of up to 2 m/s from any direction and
trims up to 20 counts off the vehicle file's. Of twenty dead zones nineteen must lie inside their 95 % interval.
"""
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import time

FENCE_M = {"roll": 6.0, "pitch": 6.0, "climb": 1.0, "yaw_rate": 3.0}
DECLARED = {"roll": "second_order,transport_delay,trim_offset", "pitch": "second_order,transport_delay,trim_offset",
            "climb": "second_order,trim_offset", "yaw_rate": "first_order,trim_offset"}
FLIGHT = """mode = "field"
[fence]
x_m = [-8.0, 8.0]
y_m = [-8.0, 8.0]
z_m = [0.2, 6.0]
"""
MAP = """time = { column = "tick.timestamp", scale = 1.0 }
[signals]
stick_roll = { column = "tick.sticks[0]", offset = -1024 }
stick_pitch = { column = "tick.sticks[1]", offset = -1024 }
stick_throttle = { column = "tick.sticks[2]", offset = -1024 }
stick_yaw = { column = "tick.sticks[3]", offset = -1024 }
attitude_roll = "tick.imu_attitude[0]"
attitude_pitch = "tick.imu_attitude[1]"
attitude_yaw = "tick.imu_attitude[2]"
rate_x = "tick.imu_rate[0]"
rate_y = "tick.imu_rate[1]"
rate_z = "tick.imu_rate[2]"
velocity_x = "tick.velocity[0]"
velocity_y = "tick.velocity[1]"
velocity_z = "tick.velocity[2]"
"""


def plant_of(seed, axis, width_counts):
    chance = random.Random(seed)
    speed_m_s, angle_rad = chance.uniform(0.0, 2.0), chance.uniform(0.0, 2.0 * math.pi)
    lines = ["[air]", f"wind_m_s = [{speed_m_s * math.cos(angle_rad):.3f}, {speed_m_s * math.sin(angle_rad):.3f}, 0.0]"]
    for name in ("roll", "pitch"):
        lines += [f"[axis.{name}]", f"trim_counts = {chance.uniform(-20.0, 20.0):.1f}"]
        if name == axis:
            lines.append(f"dead_zone_counts = {width_counts:.2f}")
    if axis not in ("roll", "pitch"):
        lines += [f"[axis.{axis}]", f"dead_zone_counts = {width_counts:.2f}", "stick_exponent = 1.0"]
    return "\n".join(lines) + "\n"


class Sweep:
    def __init__(self, m100, lab, source, axis, work):
        self.m100, self.lab, self.axis, self.work = m100, lab, axis, work
        vehicle = source / "firmware/mpc/generated/vehicle.toml"
        (work / "vehicle.toml").write_text(vehicle.read_text())
        (work / "flight.toml").write_text(FLIGHT)
        (work / "map.toml").write_text(MAP)
        self.run("gains", "--vehicle", "vehicle.toml", "--table", "gains.bin", "--setpoint-box", *["0.01"] * 6)
        print(self.run("excite", "--kind", "sweep", "--axis", axis, "--amplitude", "200", "--duration", "80", "--fence",
                       str(FENCE_M[axis]), "--vehicle", "vehicle.toml", "--out", "sticks.csv").stdout)

    def run(self, *words, check=True):
        return subprocess.run([self.lab, *words], cwd=self.work, check=check, capture_output=True, text=True)

    def fly(self, seed, width_counts):
        """@returns the excited part of the flight, as FROM:TO, or why there is none."""
        (self.work / "plant.toml").write_text(plant_of(seed, self.axis, width_counts))
        world = self.work / f"world{seed}"
        (self.work / "flight.ulg").unlink(missing_ok=True)
        with subprocess.Popen([self.lab, "autopilot", "--sim", world, "--plant", "plant.toml", "--seed", str(seed)],
                              cwd=self.work, stdout=subprocess.DEVNULL) as autopilot:
            try:
                while not world.exists() and autopilot.poll() is None:
                    time.sleep(0.01)
                flown = subprocess.run(
                    [self.m100, "fly", "--port", f"sim:{world}", "--pose-port", f"sim:{world}.pose", "--vehicle", "vehicle.toml",
                     "--gains", "gains.bin", "--flight", "flight.toml", "--excite", "sticks.csv", "--take-control", "--once",
                     "--hold", "5", "--log", "flight.ulg", "--json", "flight.json"],
                    cwd=self.work, capture_output=True, text=True, check=False)
            finally:
                autopilot.terminate()
        if flown.returncode != 0:
            return None, f"m100 ended with {flown.returncode}: {flown.stdout[-400:]}{flown.stderr}"
        excitation = json.loads((self.work / "flight.json").read_text())["excitation"]
        return f"{excitation['from_s']}:{excitation['to_s']}", ""

    def identify(self, within):
        self.run("identify", "--log", "flight.ulg", "--columns", "map.toml", "--axis", self.axis, "--declare", DECLARED[self.axis],
                 "--split", "alternate:6", "--within", within, "--json", "found.json", check=False)
        found = json.loads((self.work / "found.json").read_text())
        for effect in found["effects"]:
            if effect["name"] == "dead_zone":
                width = effect["parameters"]["width_counts"]
                return width["value"], width["low"], width["high"], effect["parameters"].get("shape"), found["verdict"]
        names = ", ".join(effect["name"] for effect in found["effects"])
        raise LookupError(f"no dead zone found, but {names or 'nothing'} ({found['verdict']})")

    def is_inside(self, seed, width_counts):
        within, why = self.fly(seed, width_counts)
        if within is None:
            print(f"{width_counts:5.1f} counts: {why}", flush=True)
            return False
        try:
            value, low, high, shape, verdict = self.identify(within)
        except LookupError as wrong:
            print(f"{width_counts:5.1f} counts: {wrong}", flush=True)
            return False
        inside = low <= width_counts <= high
        print(f"{width_counts:5.1f} counts: {value:.1f} [{low:.1f}, {high:.1f}] {shape}, {verdict}{'' if inside else '  MISSED'}", flush=True)
        return inside


def main():
    m100, lab, source = (pathlib.Path(name).resolve() for name in sys.argv[1:4])
    axis = sys.argv[4] if len(sys.argv) > 4 else "roll"
    flights = int(sys.argv[5]) if len(sys.argv) > 5 else 20
    with tempfile.TemporaryDirectory() as work:
        sweep = Sweep(m100, lab, source, axis, pathlib.Path(work))
        inside = sum(sweep.is_inside(seed, 10.0 + 50.0 * (seed - 1) / max(1, flights - 1)) for seed in range(1, flights + 1))
    print(f"{inside} of {flights} dead zones of 10 to 60 counts are inside their interval")
    return 0 if inside >= math.ceil(0.95 * flights) else 1


if __name__ == "__main__":
    sys.exit(main())
