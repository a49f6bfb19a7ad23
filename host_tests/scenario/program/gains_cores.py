#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""`m100-lab gains --tune` writes the same files and prints the same on one core as on all.

Usage: gains_cores.py LAB VEHICLE
"""
import concurrent.futures
import os
import pathlib
import subprocess
import sys
import tempfile


def tuned(lab, vehicle, cores):
    """@returns what the program prints on these cores, and the vehicle file, table and JSON that it writes."""
    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder, name) for name in ("tuned.toml", "tuned.gains", "margins.json")]
        words = [word for pair in zip(("--tune", "--table", "--json"), map(str, files)) for word in pair]
        run = subprocess.run([lab, "gains", "--vehicle", vehicle, *words], check=True, stdout=subprocess.PIPE,
                             stderr=subprocess.DEVNULL, preexec_fn=lambda: os.sched_setaffinity(0, cores))
        return [run.stdout] + [file.read_bytes() for file in files]


def main():
    cores = os.sched_getaffinity(0)
    if len(cores) < 2:
        print("one core only")
        return 77
    with concurrent.futures.ThreadPoolExecutor() as both:
        on_all, on_one = [both.submit(tuned, *sys.argv[1:3], some) for some in (cores, {min(cores)})]
        same = on_all.result() == on_one.result()
    print("the same" if same else "DIFFERENT on one core")
    return 0 if same else 1


sys.exit(main())
