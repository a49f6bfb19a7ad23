#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws the first page's picture: measured roll, both models and their residuals in the part of the flight that no fit has seen.

Usage: first_picture.py M100_LAB PITCH_ROLL_CSV OUT.svg   (the published flight; identified anew)
"""
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

MAP = pathlib.Path(__file__).resolve().parent.parent / "lab" / "columns" / "m100_csv.toml"
WIDTH, LEFT, RIGHT = 860, 62, 16
PANELS = [("roll [deg]", 34, 190), ("residual [deg]", 256, 110)]  # label, top, height
COLORS = {"measured": "#333333", "declared": "#d55e00", "final": "#0072b2"}
NAMES = {"measured": "measured", "declared": "declared model: first order", "final": "identified model"}
EVERY = 4  # of 100 Hz: 25 points a second are more than the picture has pixels


def identified(lab, log):
    """-> {column: values} of the validation part"""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([lab, "identify", "--log", log, "--columns", MAP, "--axis", "roll", "--declare", "first_order", "--train", "12:38",
                        "--validate", "38:55.5", "--report", folder], check=True, capture_output=True)
        rows = [row for row in csv.DictReader((pathlib.Path(folder) / "roll.csv").open()) if row["validation"] == "1"][::EVERY]
    return {name: [float(row[name]) if row[name] else math.nan for row in rows] for name in rows[0]}


def panel(label, top, height, times, curves):
    """-> SVG of one pair of axes. @param curves  (values in degrees, colour)"""
    low = 5.0 * math.floor(min(min(values) for values, _ in curves) / 5.0)
    high = 5.0 * math.ceil(max(max(values) for values, _ in curves) / 5.0)
    x = lambda t: LEFT + (t - times[0]) / (times[-1] - times[0]) * (WIDTH - LEFT - RIGHT)
    y = lambda value: top + (high - value) / (high - low) * height
    out = [f'<text x="{LEFT}" y="{top - 8}">{label}</text>']
    step = 10.0 if high - low > 25.0 else 5.0
    for k in range(int((high - low) / step) + 1):
        value = low + k * step
        out.append(f'<path d="M{LEFT} {y(value):.1f}H{WIDTH - RIGHT}" stroke="#dddddd"/>'
                   f'<text x="{LEFT - 6}" y="{y(value) + 4:.1f}" text-anchor="end">{value:g}</text>')
    for values, color in curves:
        points = " ".join(f"{x(t):.1f},{y(value):.1f}" for t, value in zip(times, values))
        out.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="1.5"/>')
    return out, x


def picture(data):
    degrees = {name: [math.degrees(value) for value in values] for name, values in data.items() if name != "t_s"}
    times, (upper, lower) = data["t_s"], PANELS
    height = lower[1] + lower[2] + 44
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
           'font-family="sans-serif" font-size="13" fill="#333333">', '<rect width="100%" height="100%" fill="white"/>']
    body, x = panel(*upper, times, [(degrees[name], COLORS[name]) for name in ("measured", "declared", "final")])
    svg += body
    body, _ = panel(*lower, times, [(degrees[f"{name}_residual"], COLORS[name]) for name in ("declared", "final")])
    svg += body
    for t in range(math.ceil(times[0] / 5.0) * 5, int(times[-1]) + 1, 5):
        svg.append(f'<text x="{x(t):.1f}" y="{height - 24}" text-anchor="middle">{t}</text>')
    svg.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{height - 6}" text-anchor="middle">time [s]</text>')
    at = 190
    for name, text in NAMES.items():
        svg.append(f'<path d="M{at} 21h26" stroke="{COLORS[name]}" stroke-width="2"/><text x="{at + 32}" y="26">{text}</text>')
        at += 60 + 7.4 * len(text)
    return "\n".join(svg + ["</svg>"]) + "\n"


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    pathlib.Path(sys.argv[3]).write_text(picture(identified(sys.argv[1], sys.argv[2])))
