#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The worked example of host_tests/lab/identify/METHOD.md, in plain Python: a simulated record, two fits, the evidence for the effect.

Usage: method_example.py [LOG.csv]. Prints the numbers; with LOG.csv it also writes the record, as `m100-lab identify` reads it. It shares no
code with identify. The equations are numbered as on the page.
"""
import math
import random
import sys

PERIOD_S = 0.01
TRAIN_S, VALIDATE_S = (3.0, 43.0), (43.0, 63.0)
BLOCK_S, FOLDS, START_SAMPLES = 2.5, 5, 11
# gain [rad/count], time constant [s], trim [counts], delay [s], half width of the dead zone [counts]
TRUE = (8.5e-4, 0.25, 0.0, 0.07, 20.0)
STARTS = (8e-4, 0.4, 0.0, 0.03, 8.0)
UNITS = (1e-4, 0.1, 10.0, 0.01, 10.0)  # of one step of the search, so that all its numbers are near 1
BOUNDS = ((1e-5, 1e-2), (0.005, 5.0), (-300.0, 300.0), (0.0, 0.5), (0.0, 300.0))
DECLARED = 4  # so many of the numbers has the declared model: all but the dead zone


def commands(theta, stick):
    """Equation (1): trim, dead zone counted from its edge, gain."""
    gain, _, trim, _, width = theta
    return [gain * math.copysign(max(0.0, abs(u - trim) - width), u - trim) for u in stick]


def simulate(theta, command, begin, end, y):
    """Equations (2) and (3): the delayed command, interpolated between samples, through a first-order lag. -> y at begin to end - 1"""
    decay = math.exp(-PERIOD_S / theta[1])
    whole = math.floor(theta[3] / PERIOD_S)
    part = theta[3] / PERIOD_S - whole
    out = []
    for newer, older in zip(command[begin - whole:end - whole], command[begin - whole - 1:end - whole - 1]):
        out.append(y)
        arrived = newer + part * (older - newer)
        y = arrived + decay * (y - arrived)
    return out


def record():
    """-> (stick [counts], roll [rad]): a hand that holds and moves the stick, coloured air, and sensor noise."""
    draw = random.Random(20).random

    def normal():
        return sum(draw() for _ in range(12)) - 6.0
    samples = round(VALIDATE_S[1] / PERIOD_S) + 1
    stick, goal, hold = [0.0], 0.0, 100
    while len(stick) < samples:
        if hold == 0:
            goal, hold = normal() * (35.0 if draw() < 0.6 else 160.0), round(20 + 80 * draw())
        stick.append(stick[-1] + max(-15.0, min(15.0, goal - stick[-1])))
        hold -= 1
    stick = [round(u) for u in stick]
    air, memory = 0.0, math.exp(-PERIOD_S / 0.3)
    pad = 100  # samples at rest before the record
    roll = simulate(TRUE, commands(TRUE, [0] * pad + stick), pad, pad + samples, 0.0)
    for i in range(samples):
        air = memory * air + 0.007 * math.sqrt(1 - memory * memory) * normal()
        roll[i] = round(roll[i] + air + 0.001 * normal(), 6)
    return stick, roll


def start_value(roll, at):
    """-> the value at `at` of the least-squares quadratic through START_SAMPLES samples around it."""
    half = START_SAMPLES // 2
    xs = range(-half, half + 1)
    s0, s2, s4 = (sum(x ** k for x in xs) for k in (0, 2, 4))
    return sum((s4 - s2 * x * x) / (s0 * s4 - s2 * s2) * roll[at + x] for x in xs)


def blocks_of(span, roll):
    """-> (first sample, end, initial value) of each block of BLOCK_S"""
    length, first, last = (round(s / PERIOD_S) for s in (BLOCK_S, *span))
    return [(at, at + length, start_value(roll, at)) for at in range(first, last - length + 1, length)]


def errors(theta, data, blocks):
    """-> simulated minus measured, block by block; each block starts from the measured value"""
    stick, roll = data
    command = commands(theta, stick)
    return [[s - m for s, m in zip(simulate(theta, command, begin, end, y), roll[begin:end])] for begin, end, y in blocks]


def dot(a, b):
    return sum(map(float.__mul__, a, b))


def flat(blocks):
    return [value for block in blocks for value in block]


def solve(matrix, right):
    """-> x with matrix x = right, by Gaussian elimination; the matrix is symmetric and positive"""
    rows = [list(row) + [value] for row, value in zip(matrix, right)]
    n = len(rows)
    for k in range(n):
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k])]
    out = [0.0] * n
    for k in reversed(range(n)):
        out[k] = (rows[k][n] - sum(rows[k][j] * out[j] for j in range(k + 1, n))) / rows[k][k]
    return out


def fit(start, free, data, blocks):
    """Equation (4), by Levenberg-Marquardt: the first `free` numbers of theta that minimise the sum of squared errors."""
    theta, damping = list(start), 1e-3
    left = flat(errors(theta, data, blocks))
    for _ in range(40):
        columns = []
        for k in range(free):
            step = 0.02 * UNITS[k]
            moved = theta[:k] + [theta[k] + step] + theta[k + 1:]
            columns.append([(a - b) / 0.02 for a, b in zip(flat(errors(moved, data, blocks)), left)])
        normal = [[dot(a, b) for b in columns] for a in columns]
        slope = [dot(a, left) for a in columns]
        before = dot(left, left)
        for _ in range(12):
            damped = [[value * (1 + damping) if i == j else value for j, value in enumerate(row)] for i, row in enumerate(normal)]
            step = solve(damped, slope)
            trial = [min(max(theta[k] - step[k] * UNITS[k], BOUNDS[k][0]), BOUNDS[k][1]) for k in range(free)] + theta[free:]
            tried = flat(errors(trial, data, blocks))
            if dot(tried, tried) < before:
                theta, left, damping = trial, tried, damping / 5
                break
            damping *= 6
        if before - dot(left, left) < 1e-7 * before:
            break
    return theta


def cross_validated(theta, free, data, blocks):
    """Equation (5) -> sum of squares of each block, predicted by the fit to the other folds"""
    out = [0.0] * len(blocks)
    for fold in range(FOLDS):
        kept = fit(theta, free, data, [block for k, block in enumerate(blocks) if k % FOLDS != fold])
        for k in range(fold, len(blocks), FOLDS):
            (error,) = errors(kept, data, [blocks[k]])
            out[k] = dot(error, error)
    return out


def lagged(blocks, lag):
    return sum(dot(block[lag:], block[:len(block) - lag]) for block in blocks)


def effective_samples(blocks):
    """-> n of equation (6)"""
    time, lag = 1.0, 1
    while (product := lagged(blocks, lag)) > 0.0:
        time, lag = time + 2 * product / lagged(blocks, 0), lag + 1
    return sum(map(len, blocks)) / time


def whitened(without, with_effect, extra):
    """Equation (7): means of five samples, filtered by the autoregression of order 4 of the errors with the effect."""
    def means(blocks):
        return [[sum(block[at:at + 5]) / 5 for at in range(0, len(block) - 4, 5)] for block in blocks]
    fine = means(with_effect)
    pairs = [(block[at - 4:at][::-1], block[at]) for block in fine for at in range(4, len(block))]
    normal = [[sum(past[i] * past[j] for past, _ in pairs) for j in range(4)] for i in range(4)]
    weights = solve(normal, [sum(past[i] * now for past, now in pairs) for i in range(4)])

    def power(blocks):
        return sum((block[at] - dot(weights, block[at - 4:at][::-1])) ** 2 for block in blocks for at in range(4, len(block)))
    return len(pairs) * math.log(power(means(without)) / power(fine)) - extra * math.log(len(pairs))


def student_t(degrees):
    """97.5 % quantile (Abramowitz and Stegun 26.7.5)"""
    return 1.959964 + (2.3723 + (2.8225 + 2.5559 / degrees) / degrees) / degrees


def jackknife(theta, free, data, blocks):
    """Equation (8) -> half widths of the 95 % intervals"""
    n = len(blocks)
    refits = [fit(theta, free, data, blocks[:k] + blocks[k + 1:]) for k in range(n)]
    out = []
    for values in list(zip(*refits))[:free]:
        mean = sum(values) / n
        out.append(student_t(n - 1) * math.sqrt((n - 1) / n * sum((value - mean) ** 2 for value in values)))
    return out


def rms(blocks):
    return math.sqrt(lagged(blocks, 0) / sum(map(len, blocks)))


def evidence(data):
    """-> {name: number} of the page's table"""
    blocks, unseen = blocks_of(TRAIN_S, data[1]), blocks_of(VALIDATE_S, data[1])
    declared = fit([*STARTS[:DECLARED], 0.0], DECLARED, data, blocks)
    found = fit([*declared[:DECLARED], STARTS[DECLARED]], DECLARED + 1, data, blocks)
    e0, e1 = (errors(theta, data, blocks) for theta in (declared, found))
    cv0, cv1 = (cross_validated(theta, free, data, blocks) for theta, free in ((declared, DECLARED), (found, DECLARED + 1)))
    better = [a - b for a, b in zip(cv0, cv1)]
    mean = sum(better) / len(better)
    spread = math.sqrt(sum((value - mean) ** 2 for value in better) / (len(better) - 1) / len(better))
    effective = effective_samples(e1)
    half = jackknife(found, DECLARED + 1, data, blocks)
    return {"declared": declared, "found": found, "half": half, "effective": effective,
            "train": (rms(e0), rms(e1)), "validation": tuple(rms(errors(theta, data, unseen)) for theta in (declared, found)),
            "cv_gain": 1 - sum(cv1) / sum(cv0), "t": mean / spread,
            "delta_bic": effective * math.log(rms(e0) ** 2 / rms(e1) ** 2) - math.log(effective), "delta_white": whitened(e0, e1, 1)}


def main():
    data = record()
    if len(sys.argv) > 1:
        write(data, sys.argv[1])
    for name, value in evidence(data).items():
        print(name, value)


def write(data, path):
    with open(path, "w", encoding="utf-8") as file:
        file.write("t_s,stick,roll\n")
        file.writelines(f"{PERIOD_S * i:.2f},{u},{y}\n" for i, (u, y) in enumerate(zip(*data)))


if __name__ == "__main__":
    main()
