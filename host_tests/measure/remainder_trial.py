#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Logs with effects that `m100-lab identify` has no name for: does the drawing of the remainder point to them?

Usage: remainder_trial.py FOLDER [SEED]. Writes NN.csv, columns.toml and key.json (axis and cause of each log). The vehicle is simulated here, in plain
Python, and shares no code with the lab: four axes of second order, a delay of 0.06 s, coloured air, a hand that flies, and position from tilt.
"""
import json
import math
import pathlib
import random
import sys

PERIOD_S, DURATION_S, DELAY = 0.01, 120.0, 6  # s, s, samples
GAIN = {"roll": 8.5e-4, "pitch": 8.5e-4, "yaw_rate": -2.6e-3, "climb": 4.5e-3}  # unit of the axis per count
AIR = {"roll": 0.008, "pitch": 0.008, "yaw_rate": 0.03, "climb": 0.05}  # rms, unit of the axis
NOISE = {"roll": 5e-4, "pitch": 5e-4, "yaw_rate": 2e-3, "climb": 5e-3}
STICK = {"roll": "stick_roll", "pitch": "stick_pitch", "yaw_rate": "stick_yaw", "climb": "stick_throttle"}
FREQUENCY_RAD_S, DAMPING = 7.0, 0.9
COLUMNS = ("t_s", "stick_roll", "stick_pitch", "stick_yaw", "stick_throttle", "attitude_roll", "attitude_pitch", "attitude_yaw", "rate_x", "rate_y",
           "rate_z", "position_x", "position_y", "position_z", "velocity_x", "velocity_y", "velocity_z", "battery_v", "temperature_c", "humidity")

# Axis, cause in words, and what the cause does to the axis' command c in the state s: -> the changed command.
EFFECTS = (
    ("climb", "near the ground the aircraft is pushed up: depends on the height", lambda c, s: c + 0.5 * math.exp(-s["position_z"] / 0.4)),
    ("roll", "the gain falls with the battery's voltage", lambda c, s: c * (1 + 0.16 * (s["battery_v"] - 23.5))),
    ("pitch", "the stick sticks: it passes on only movements of more than 25 counts", None),
    ("roll", "the rate of the other axis (pitch rate, rate_y) couples in", lambda c, s: c + 0.10 * s["rate_y"]),
    ("pitch", "the gain falls with the speed", lambda c, s: c * (1 - 0.10 * s["speed"])),
    ("roll", "the other axis' attitude (pitch) adds an even offset", lambda c, s: c + 0.9 * s["attitude_pitch"] ** 2),
    ("pitch", "the trim moves with the temperature", lambda c, s: c + 0.004 * (s["temperature_c"] - 40)),
    ("roll", "a force fixed in the world: periodic in the heading", lambda c, s: c + 0.02 * math.sin(s["attitude_yaw"] + 0.6)),
    ("roll", "friction against the motion: depends on the sign of the own rate", lambda c, s: c - 0.025 * math.tanh(s["rate_x"] / 0.05)),
    ("yaw_rate", "the throttle's torque turns the aircraft", lambda c, s: c + 0.10 * (s["stick_throttle"] / 100) ** 2 * (s["stick_throttle"] > 0)),
)


class Hand:
    """Holds a stick, moves it to another deflection, and pulls back where the flight leads too far."""

    def __init__(self, draw, size):
        self.draw, self.size, self.goal, self.hold, self.value = draw, size, 0.0, 50, 0.0

    def move(self, pull):
        if self.hold == 0:
            self.goal, self.hold = max(-400.0, min(400.0, self.draw.gauss(0, self.size) + pull)), round(20 + 80 * self.draw.random())
        self.hold -= 1
        self.value += max(-15.0, min(15.0, self.goal - self.value))
        return round(self.value)


class Slow:
    """A value that wanders about zero with a root mean square of one."""

    def __init__(self, draw, time_s):
        self.draw, self.keep, self.value = draw, math.exp(-PERIOD_S / time_s), draw.gauss(0, 1)

    def step(self):
        self.value = self.keep * self.value + math.sqrt(1 - self.keep ** 2) * self.draw.gauss(0, 1)
        return self.value


def fly(axis, effect, seed):
    """-> rows of the log. @param effect  as in EFFECTS; None: the stick of the axis sticks"""
    draw = random.Random(seed)
    hands = {name: Hand(draw, size) for name, size in (("roll", 110), ("pitch", 110), ("yaw_rate", 90), ("climb", 80))}
    air = {name: Slow(draw, 0.3) for name in GAIN}
    load, heat, humid = Slow(draw, 8.0), Slow(draw, 15.0), Slow(draw, 10.0)
    value, rate = dict.fromkeys(GAIN, 0.0), dict.fromkeys(GAIN, 0.0)
    queue = {name: [0.0] * (DELAY + 1) for name in GAIN}
    s = dict.fromkeys(COLUMNS, 0.0) | {"position_z": 0.9, "speed": 0.0}
    stuck, rows = 0.0, []
    for k in range(round(DURATION_S / PERIOD_S)):
        ahead = s["velocity_x"] * math.cos(s["attitude_yaw"]) + s["velocity_y"] * math.sin(s["attitude_yaw"])
        left = s["velocity_y"] * math.cos(s["attitude_yaw"]) - s["velocity_x"] * math.sin(s["attitude_yaw"])
        pull = {"roll": 40 * left, "pitch": -40 * ahead, "yaw_rate": 70.0, "climb": -90 * (s["position_z"] - 0.9)}
        s["t_s"], s["speed"] = k * PERIOD_S, math.hypot(ahead, left)
        s["battery_v"] = 23.5 + load.step() - 0.004 * max(0.0, s["stick_throttle"])
        s["temperature_c"], s["humidity"] = 40 + 3 * heat.step(), 50 + 5 * humid.step()
        for name in GAIN:
            s[STICK[name]] = hands[name].move(pull[name])
            moved = s[STICK[name]]
            if name == axis and effect is None:
                stuck = moved if abs(moved - stuck) > 25 else stuck
                moved = stuck
            queue[name] = queue[name][1:] + [GAIN[name] * moved]
            command = queue[name][0]
            if name == axis and effect is not None:
                command = effect(command, s)
            command += AIR[name] * air[name].step()
            rate[name] += PERIOD_S * (FREQUENCY_RAD_S ** 2 * (command - value[name]) - 2 * DAMPING * FREQUENCY_RAD_S * rate[name])
            value[name] += PERIOD_S * rate[name]
        s["attitude_roll"], s["attitude_pitch"] = value["roll"], value["pitch"]
        s["rate_x"], s["rate_y"], s["rate_z"] = rate["roll"], rate["pitch"], value["yaw_rate"]
        s["attitude_yaw"] += PERIOD_S * value["yaw_rate"]
        push = {"x": 9.81 * math.tan(value["pitch"]), "y": -9.81 * math.tan(value["roll"])}
        yaw = s["attitude_yaw"]
        world = {"x": push["x"] * math.cos(yaw) - push["y"] * math.sin(yaw), "y": push["x"] * math.sin(yaw) + push["y"] * math.cos(yaw)}
        for direction in "xy":
            s["velocity_" + direction] += PERIOD_S * (world[direction] - 0.5 * s["velocity_" + direction])
            s["position_" + direction] += PERIOD_S * s["velocity_" + direction]
        s["velocity_z"] = value["climb"]
        s["position_z"] = max(0.15, s["position_z"] + PERIOD_S * value["climb"])
        noisy = dict(s)
        for name, column in (("roll", "attitude_roll"), ("pitch", "attitude_pitch"), ("yaw_rate", "rate_z"), ("climb", "velocity_z")):
            noisy[column] += NOISE[name] * draw.gauss(0, 1)
        rows.append([noisy[column] for column in COLUMNS])
    return rows


def main():
    folder, seed = pathlib.Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1
    folder.mkdir(parents=True, exist_ok=True)
    extra = COLUMNS[-3:]
    (folder / "columns.toml").write_text("time = \"t_s\"\n[signals]\n" + "".join(f"{name} = \"{name}\"\n" for name in COLUMNS[1:] if name not in extra) +
                                         "[extra]\n" + "".join(f"{name} = \"{name}\"\n" for name in extra))
    key = {}
    for number, (axis, cause, effect) in enumerate(EFFECTS, 1):
        rows = fly(axis, effect, 1000 * seed + number)
        text = [",".join(COLUMNS)] + [",".join(f"{value:.6g}" for value in row) for row in rows]
        (folder / f"{number:02d}.csv").write_text("\n".join(text) + "\n")
        key[f"{number:02d}"] = {"axis": axis, "cause": cause}
    (folder / "key.json").write_text(json.dumps(key, indent=1) + "\n")


if __name__ == "__main__":
    main()
