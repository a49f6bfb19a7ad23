#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Flies all tasks with every combination of latency, jitter and reported age of the pose, 30 to 240 Hz, drift up to 100 ppm.

Usage: matrix.py M100_LAB [--flights N] [--record JSON]
Writes the worlds, flies N (default 6: 2160 flights) seeds of each task in each, and prints the matrix. Exit 1 if a flight
did not stay; with --record the report goes to a file and the exit code is 0 even then.
"""
import itertools
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

LATENCIES_MS = (0, 25, 50, 75, 100)
JITTERS_MS = (0, 10, 20, 40)
AGES = ("true", "constant", "none")
RATES_HZ = (100, 30, 240, 60, 120, 50, 200)  # 7 rates and 4 drifts have no common divisor: they meet in all combinations
DRIFTS_PPM = (0, 100, -50, -100)


def name(latency_ms, jitter_ms, age):
    return f"latency_{latency_ms}_jitter_{jitter_ms}_{age}"


def write_worlds(folder):
    """-> the paths, in the order of the matrix."""
    paths = []
    for number, (latency_ms, jitter_ms, age) in enumerate(itertools.product(LATENCIES_MS, JITTERS_MS, AGES)):
        path = pathlib.Path(folder) / f"{name(latency_ms, jitter_ms, age)}.toml"
        path.write_text(f"[pose]\nrate_hz = {RATES_HZ[number % len(RATES_HZ)]}.0\nlatency_s = {latency_ms / 1000}\n"
                        f"jitter_s = {jitter_ms / 1000}\nreported_age = \"{age}\"\nreported_age_s = 0.02\n"
                        f"clock_drift_ppm = {DRIFTS_PPM[number % len(DRIFTS_PPM)]}.0\n")
        paths.append(path)
    return paths


def rows(report):
    """-> the matrix: a row for each latency, a column for each jitter; all ages together."""
    out = [["latency"] + [f"jitter {jitter_ms} ms" for jitter_ms in JITTERS_MS]]
    for latency_ms in LATENCIES_MS:
        out.append([f"{latency_ms} ms"])
        for jitter_ms in JITTERS_MS:
            worlds = [report["worlds"][name(latency_ms, jitter_ms, age)] for age in AGES]
            stayed, flights = (sum(world[key] for world in worlds) for key in ("stayed", "flights"))
            swings = sum(world["oscillating"] for world in worlds)
            tilts_deg = [world["tasks"]["hover"]["tilt_rms_deg"] for world in worlds]
            flown_deg = [tilt_deg for tilt_deg in tilts_deg if tilt_deg is not None]  # null: no hover flew
            tilt = f"{max(flown_deg):.2f} deg" if flown_deg else "none flew"
            out[-1].append(f"{stayed} of {flights}, {swings} swing, {tilt}")
    return out


def latencies(report):
    """-> errors of the estimated latency, against the true one plus the time on the line: a sentence each for the
    steps, the slow trajectory, and the sources at 240 Hz, whose poses fill the line and queue before it."""
    worlds = [name(*which) for which in itertools.product(LATENCIES_MS, JITTERS_MS, AGES)]
    full = {world for number, world in enumerate(worlds) if RATES_HZ[number % len(RATES_HZ)] == 240}
    flown = [flight for flight in report["flown"] if flight["scored"]]
    groups = (("steps", [f for f in flown if f["task"].startswith("step") and f["world"] not in full]),
              ("trajectory", [f for f in flown if f["task"] == "trajectory" and f["world"] not in full]),
              ("steps at 240 Hz", [f for f in flown if f["task"].startswith("step") and f["world"] in full]))
    out = []
    for label, flights in groups:
        errors_ms = sorted(1e3 * abs(flight["latency_error_s"]) for flight in flights)
        observable = sum(flight["latency_sigma_s"] <= 0.01 for flight in flights)
        inside = sum(error_ms <= 5.0 for error_ms in errors_ms)
        out.append(f"{label}: median {statistics.median(errors_ms):.1f} ms, within 5 ms in {inside} of {len(flights)}, 99 % within "
                   f"{errors_ms[int(0.99 * len(errors_ms))]:.1f} ms, worst {errors_ms[-1]:.1f} ms; reported as observable in {observable}")
    return out


def fly(program, flights, answer):
    """-> exit code of the campaign"""
    with tempfile.TemporaryDirectory() as folder:
        words = [str(program), "campaign", *map(str, write_worlds(folder)), "--flights", str(flights), "--json", str(answer)]
        return subprocess.run(words, stdout=subprocess.DEVNULL, check=False).returncode


def main():
    words = sys.argv[1:]
    flights = int(words[words.index("--flights") + 1]) if "--flights" in words else 6
    with tempfile.TemporaryDirectory() as folder:
        record = "--record" in words
        answer = words[words.index("--record") + 1] if record else pathlib.Path(folder) / "answer.json"
        code = fly(words[0], flights, answer)
        if code > 1:
            return code
        for row in rows(json.loads(pathlib.Path(answer).read_text())):
            print(" | ".join(row))
        for sentence in latencies(json.loads(pathlib.Path(answer).read_text())):
            print(sentence)
    return 0 if record else code


if __name__ == "__main__":
    sys.exit(main())
