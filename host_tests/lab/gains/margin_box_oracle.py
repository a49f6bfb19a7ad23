#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks the worst points of `m100-lab gains --corners` by a second implementation.

Usage: margin_box_oracle.py M100_LAB VEHICLE.toml FOLDER [POINTS]

The vehicle is stepped by matrix exponentials; the controller is the one that the JSON states. At each stated worst point
the sensitivity must be the stated peak, so the peak is not above what the loop has. Nowhere in a dense sample of the box
(all corners, middles of its edges and POINTS random aircraft, 60 frequencies, all ages of the pose) may it be more than
2 % larger.
"""
import cmath
import itertools
import json
import math
import pathlib
import random
import subprocess
import sys
import tomllib

TICK_S = 0.01
GRAVITY_M_S2 = 9.8066


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def exponential(matrix):
    """By its series, of a matrix whose entries are made small first."""
    n = len(matrix)
    halvings = max(0, math.ceil(math.log2(max(1e-9, max(sum(abs(x) for x in row) for row in matrix)))) + 4)
    small = [[x / 2.0**halvings for x in row] for row in matrix]
    term = [[float(i == j) for j in range(n)] for i in range(n)]
    out = [row[:] for row in term]
    for k in range(1, 14):
        term = [[x / k for x in row] for row in product(term, small)]
        out = [[x + y for x, y in zip(a, b)] for a, b in zip(out, term)]
    for _ in range(halvings):
        out = product(out, out)
    return out


def solve(matrix, right):
    """Gaussian elimination with pivots; complex."""
    n = len(matrix)
    rows = [list(row) + [value] for row, value in zip(matrix, right)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(i + 1, n):
            factor = rows[k][i] / rows[i][i]
            if factor != 0:
                rows[k] = [x - factor * y for x, y in zip(rows[k], rows[i])]
    out = [0j] * n
    for i in reversed(range(n)):
        out[i] = (rows[i][n] - sum(rows[i][k] * out[k] for k in range(i + 1, n))) / rows[i][i]
    return out


class Plant:
    """x(k+1) = a x + early u(k-n-1) + late u(k-n) from tick to tick."""

    def __init__(self, frequency, damping, delay_s, lead_s, drag_per_s, pull):
        f = [[0, 1, 0, 0, 0], [0, -drag_per_s, pull, pull * lead_s, 0], [0, 0, 0, 1, 0],
             [0, 0, -frequency**2, -2 * damping * frequency, frequency**2], [0, 0, 0, 0, 0]]
        self.ticks = math.floor(delay_s / TICK_S + 1e-9)
        rest = delay_s - self.ticks * TICK_S
        first = exponential([[x * rest for x in row] for row in f])
        second = exponential([[x * (TICK_S - rest) for x in row] for row in f])
        self.a = product([row[:4] for row in second[:4]], [row[:4] for row in first[:4]])
        self.early = [sum(second[i][k] * first[k][4] for k in range(4)) for i in range(4)]
        self.late = [second[i][4] for i in range(4)]
        self.tilt = [0, 0, 1, lead_s]
        self.rate = [0, 0, -lead_s * frequency**2, 1 - 2 * damping * frequency * lead_s]
        self.rate_per_input = lead_s * frequency**2

    def response(self, z, command_ticks, pose_age, attitude_age):
        """Position, tilt, rate as they arrive in the ticks of one period, for commands z^k."""
        def command(tick):
            return z ** math.floor((tick - self.ticks) / command_ticks)
        powers = [[[float(i == j) for j in range(4)] for i in range(4)]]
        forced = [[0j] * 4]
        for tick in range(command_ticks):
            x = [sum(p * q for p, q in zip(row, forced[-1])) for row in self.a]
            forced.append([v + e * command(tick - 1) + l * command(tick) for v, e, l in zip(x, self.early, self.late)])
            powers.append(product(self.a, powers[-1]))
        start = solve([[(z if i == j else 0) - powers[-1][i][j] for j in range(4)] for i in range(4)], forced[-1])

        def state(tick):
            turns = math.floor(tick / command_ticks)
            inside = tick - turns * command_ticks
            x = [sum(p * q for p, q in zip(row, start)) + v for row, v in zip(powers[inside], forced[inside])]
            return [z**turns * v for v in x]
        out = []
        for tick in range(command_ticks):
            seen = tick - attitude_age
            x = state(seen)
            out += [state(tick - pose_age)[0], sum(p * q for p, q in zip(self.tilt, x)),
                    sum(p * q for p, q in zip(self.rate, x)) + self.rate_per_input * command(seen - 1)]
        return out


def law(controller, z):
    """c (z - a)^-1 b + d."""
    a, b, c, d = (controller[name] for name in "abcd")
    n = len(a)
    left = solve([[(z if i == j else 0) - a[j][i] for j in range(n)] for i in range(n)], c)  # transposed
    return [sum(x * row[k] for x, row in zip(left, b)) + d[k] for k in range(len(d))]


def structures(vehicle):
    out = {"its own structure": {axis: vehicle["axis"][axis] for axis in ("roll", "pitch")}}
    count = {"roll": 0, "pitch": 0}
    for rival in vehicle.get("rival", []):
        count[rival["axis"]] += 1
        out.setdefault(f"rival {count[rival['axis']]}", dict(out["its own structure"]))[rival["axis"]] = rival
    return out


class Loop:
    """One structure, axis and channel, as its box in the JSON states it."""

    def __init__(self, body, vehicle, structure, axis, channel):
        self.box = body["flown"][structure][axis]["box"][channel]
        self.axis = structures(vehicle)[structure]["pitch" if axis == "x" else "roll"]
        self.controller = body["controllers"][axis + " " + channel]
        self.stick = 1.0
        if channel == "virtual_rc":
            self.stick = self.axis["scale_rad_per_count"] / self.controller["scale_rad_per_count"]
        self.pull = (1 if axis == "x" else -1) * GRAVITY_M_S2 * vehicle["translation"].get("tilt_gain", 1.0)
        self.drag_per_s = vehicle["translation"]["linear_drag_per_s"]
        self.ticks = self.controller["command_ticks"]

    def plant(self, frequency, damping, delay_s):
        return Plant(self.axis["natural_frequency_rad_s"] * frequency, damping, delay_s, self.axis.get("lead_zero_s", 0.0),
                     self.drag_per_s, self.pull)

    def sensitivity(self, plant, at_rad_s, row, age, gain):
        """-> the largest over the range of gains"""
        z = cmath.exp(1j * at_rad_s * TICK_S * self.ticks)
        loop = -self.stick * sum(k * y for k, y in zip(row, plant.response(z, self.ticks, age, 1)))
        best = min(max(-loop.real / abs(loop) ** 2, gain[0]), gain[1])
        return 1.0 / abs(1.0 + best * loop)

    def at_worst(self):
        """-> the sensitivity at the stated worst point"""
        at = self.box["worst"]
        row = law(self.controller, cmath.exp(1j * at["at_rad_s"] * TICK_S * self.ticks))
        plant = self.plant(at["frequency"], at["damping"], at["delay_s"])
        return self.sensitivity(plant, at["at_rad_s"], row, round(at["pose_age_s"] / TICK_S), (at["gain"], at["gain"]))

    def dense(self, dice, points):
        """-> the largest sensitivity of a dense sample"""
        ranges = [self.box["ranges"][key] for key in ("frequency", "damping", "delay_s")]
        aircraft = list(itertools.product(*[(low, 0.5 * (low + high), high) for low, high in ranges]))
        aircraft += [[dice.uniform(low, high) for low, high in ranges] for _ in range(points)]
        frequencies = [1.0 * (math.pi / (TICK_S * self.ticks)) ** (k / 60) for k in range(60)]  # below 1 rad/s it is small
        rows = [law(self.controller, cmath.exp(1j * w * TICK_S * self.ticks)) for w in frequencies]
        plants = [self.plant(*one) for one in aircraft]
        return max(self.sensitivity(plant, w, row, age, self.box["ranges"]["gain"])
                   for plant in plants for w, row in zip(frequencies, rows) for age in range(5))


def check(body, vehicle, points):
    dice = random.Random(7)
    worst = 0.0
    for structure, axes in body["flown"].items():
        for axis, channel in itertools.product(axes, ("virtual_rc", "movement")):
            loop = Loop(body, vehicle, structure, axis, channel)
            stated, here, largest = loop.box["peak_sensitivity"], loop.at_worst(), loop.dense(dice, points)
            name = f"{structure}, {axis}, {channel}: stated peak {stated:.4f}"
            print(f"{name}, second implementation there {here:.4f}, in a dense sample {largest:.4f}", flush=True)
            if abs(here / stated - 1.0) > 1e-4:
                sys.exit(f"{name}: at the stated worst point the sensitivity is {here:.4f}")
            if largest > 1.02 * stated:
                sys.exit(f"{name}: an aircraft of the box has {largest:.4f}")
            worst = max(worst, stated)
    if body["box"]["peak_sensitivity"] != worst:
        sys.exit(f"the box of all loops has {body['box']['peak_sensitivity']}, the worst loop {worst}")


def main():
    lab, vehicle, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    points = int(sys.argv[4]) if len(sys.argv) > 4 else 100
    folder.mkdir(parents=True, exist_ok=True)
    for mode in ("field", "robust"):
        answer = folder / f"{mode}.json"
        done = subprocess.run([lab, "gains", "--vehicle", vehicle, "--corners", "--mode", mode, "--json", answer,
                               "--setpoint-box", *["0.01"] * 6], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(done.stdout + done.stderr)
        print(mode)
        check(json.loads(answer.read_text()), tomllib.loads(vehicle.read_text()), points)


main()
