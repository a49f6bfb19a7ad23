#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks a certificate of `m100-lab gains --certify` by a second implementation.

Usage: certificate_test.py M100_LAB VEHICLE.toml FOLDER [POINTS]

The vehicle is stepped by matrix exponentials instead of the closed form; the controller is the one that the certificate
states. At random points and corners of the box, and random frequencies, the sensitivity must stay below the bound, and
the largest must come near it.
"""
import cmath
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


def sensitivities(controller, plant, stick, gain, angle, pose_ages):
    z = cmath.exp(1j * angle)
    a, b, c, d = (controller[name] for name in "abcd")
    n = len(a)
    left = solve([[(z if i == j else 0) - a[j][i] for j in range(n)] for i in range(n)], c)  # transposed
    law = [sum(x * row[k] for x, row in zip(left, b)) + d[k] for k in range(len(d))]
    for age in pose_ages:
        response = plant.response(z, controller["command_ticks"], age, 1)
        yield 1.0 / abs(1.0 - gain * stick * sum(k * y for k, y in zip(law, response)))


def structures(vehicle):
    out = {"its own structure": {axis: vehicle["axis"][axis] for axis in ("roll", "pitch")}}
    count = {"roll": 0, "pitch": 0}
    for rival in vehicle.get("rival", []):
        count[rival["axis"]] += 1
        out.setdefault(f"rival {count[rival['axis']]}", dict(out["its own structure"]))[rival["axis"]] = rival
    return out


def check_points(body, vehicle, points):
    """The largest sensitivity with the pose as old as assumed, and at any age."""
    dice = random.Random(7)
    worst = {"bound": 0.0, "bound_at_any_pose_age": 0.0}
    for loop in body["loops"]:
        name = "pitch" if loop["axis"] == "x" else "roll"
        axis = structures(vehicle)[loop["structure"]][name]
        controller = body["controllers"][loop["axis"] + " " + loop["channel"]]
        ticks = controller["command_ticks"]
        scale = axis["scale_rad_per_count"] / controller["scale_rad_per_count"]
        stick = scale if loop["channel"] == "virtual_rc" else 1.0
        pull = (1 if loop["axis"] == "x" else -1) * GRAVITY_M_S2 * vehicle["translation"].get("tilt_gain", 1.0)
        here = dict.fromkeys(worst, 0.0)
        for k in range(points):
            def pick(key):
                low, high = loop[key]
                return dice.choice((low, high)) if k % 2 else dice.uniform(low, high)
            plant = Plant(axis["natural_frequency_rad_s"] * pick("frequency"), pick("damping"), pick("delay_s"),
                          axis.get("lead_zero_s", 0.0), vehicle["translation"]["linear_drag_per_s"], pull)
            gain = pick("gain")
            lowest = 0.3 * TICK_S * ticks
            for _ in range(6):
                angle = lowest * (math.pi / lowest) ** dice.random()
                assumed, *others = sensitivities(controller, plant, stick, gain, angle, (2, 0, 1, 3, 4))
                here["bound"] = max(here["bound"], assumed)
                here["bound_at_any_pose_age"] = max(here["bound_at_any_pose_age"], assumed, *others)
        for key, value in here.items():
            worst[key] = max(worst[key], value)
            if value > loop[key]:
                sys.exit(f"{loop['structure']}, {loop['axis']}, {loop['channel']}: {value} is above the {key} {loop[key]}")
    for key, stated in (("bound", "peak_sensitivity_bound"), ("bound_at_any_pose_age", "bound_at_any_pose_age")):
        if worst[key] < 0.5 * body[stated]:
            sys.exit(f"the largest of the second implementation, {worst[key]}, is far below the {stated}: they differ")
    return worst


def main():
    lab, vehicle_path, folder = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    points = int(sys.argv[4]) if len(sys.argv) > 4 else 60
    folder.mkdir(parents=True, exist_ok=True)
    copy = folder / "vehicle.toml"
    copy.write_bytes(vehicle_path.read_bytes())
    for mode in ("field", "robust"):
        done = subprocess.run([lab, "gains", "--vehicle", copy, "--table", folder / "v.gains", "--mode", mode, "--certify"],
                              capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(done.stdout + done.stderr)
        body = json.loads((folder / "vehicle.toml.certificate.json").read_text())["certificate"]
        for bound, sampled in (("peak_sensitivity_bound", "largest_sampled"),
                               ("bound_at_any_pose_age", "sampled_at_any_pose_age")):
            if body[bound] > 1.15 * body[sampled]:
                sys.exit(f"the {bound} is more than 1.15 times the {sampled}")
        worst = check_points(body, tomllib.loads(copy.read_text()), points)
        print(f"{mode}: bound {body['peak_sensitivity_bound']:.3f}, second implementation {worst['bound']:.3f}; with the "
              f"pose 20 ms off {body['bound_at_any_pose_age']:.3f}, {worst['bound_at_any_pose_age']:.3f}")


main()
