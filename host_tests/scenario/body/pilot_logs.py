#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Identifies the pilot's logs of drawn aircraft in the guide's example world, and compares with what the world has.

Usage: pilot_logs.py M100 LAB SOURCE_FOLDER [FLIGHTS [FIRST_SEED [FOLDER]]]

Drawn: rotor drag 0.1 to 0.5 1/s, rotor lag 15 to 50 ms, trims to 60 counts, 0 to 60 ms before the loops, mean wind to 2 m/s.
Must hold: nothing is accepted falsely ("explained" although an effect is missing, or one is named that the world does not
have), and the true drag lies in its 95 % interval in at least 90 % of the flights in which it was accepted.
"""
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import time

# What the world has besides the base model, which stands for loops and rotors.
STICK = {"trim_offset", "dead_zone", "transport_delay"}
AIR = {"linear_drag", "body_drag", "steady_wind"}


class Aircraft:
    def __init__(self, seed):
        draw = random.Random(seed)
        self.seed = seed
        self.drag_per_s = draw.uniform(0.1, 0.5)
        self.lag_s = draw.uniform(0.015, 0.05)
        self.trim = {axis: draw.choice((-1, 1)) * draw.uniform(10.0, 60.0) for axis in ("roll", "pitch")}
        self.delay_s = draw.uniform(0.0, 0.06)
        self.wind = [draw.uniform(-1.4, 1.4), draw.uniform(-1.4, 1.4), 0.0]
        self.moves = draw

    def plant(self):
        return "".join(f"[axis.{axis}]\ntrim_counts = {trim:.3f}\n" for axis, trim in self.trim.items()) + \
            f"[link]\ncommand_delay_s = {self.delay_s:.4f}\n[air]\nwind_m_s = {self.wind}\n"

    def command(self, guide):
        return (f"exec /usr/bin/python3 '{guide}/quadrotor.py' {{port}} --wind={{wind}} --seed {{seed}} "
                f"--drag {self.drag_per_s:.4f} --rotor-lag {self.lag_s:.4f}")

    def script(self):
        """Kicks, pairs and chirps on roll and pitch in turn, and turns, which show how late the pose is."""
        lines, at = [], 4.0
        for _ in range(3):
            for stick in ("roll", "pitch"):
                side = self.moves.choice((-1, 1))
                lines += [f"{at} 3211 {stick} {side * self.moves.randint(110, 170)} 0.3",
                          f"{at + 6} doublet {stick} {-side * self.moves.randint(70, 120)} 0.6",
                          f"{at + 11} chirp {stick} {side * self.moves.randint(90, 140)} 0.5 2.5 6",
                          f"{at + 17.5} doublet yaw {side * 200} 1.0"]
                at += 21.0
        return "\n".join(lines) + "\n"


def record(aircraft, m100, lab, guide, place):
    world = place / "world"
    (place / "plant.toml").write_text(aircraft.plant())
    (place / "pilot.txt").write_text(aircraft.script())
    with subprocess.Popen([lab, "autopilot", "--sim", str(world), "--seed", str(aircraft.seed), "--rc-mode", "P", "--script",
                           str(place / "pilot.txt"), "--plant", str(place / "plant.toml"), "--body-command",
                           aircraft.command(guide)], stdout=subprocess.DEVNULL) as autopilot:
        while not world.exists() and autopilot.poll() is None:
            time.sleep(0.01)
        subprocess.run([m100, "record", "--port", f"sim:{world}", "--pose-port", f"sim:{world}.pose", "--log",
                        str(place / "hand.ulg"), "--hold", "132"], check=True, capture_output=True)
        autopilot.terminate()


def identify(lab, columns, place, axis, declared):
    answer = place / f"{axis}.json"
    subprocess.run([lab, "identify", "--log", str(place / "hand.ulg"), "--columns", str(columns), "--axis", axis, "--declare",
                    declared, "--split", "alternate:12", "--json", str(answer)], check=False, capture_output=True)
    return json.loads(answer.read_text())


def inside(interval, value):
    return interval["low"] <= value <= interval["high"]


def judge(aircraft, axis, answer):
    """-> falsely accepted, the drag lies in its interval (None: not accepted), one line."""
    named = set(answer["final"]["structure"][1:])
    intervals = answer["final"]["intervals"]
    accepted = answer["verdict"] != "unexplained"
    line = f"{axis}: {answer['verdict']}, {' + '.join(sorted(named)) or 'nothing'}"
    if axis != "translation":
        complete = {"trim_offset", "transport_delay"} <= named <= STICK
        trim = intervals.get("offset_counts")
        line += f", trim {aircraft.trim[axis]:.1f} in [{trim['low']:.1f}, {trim['high']:.1f}]" if trim else ""
        return accepted and (not complete or bool(answer["changes"])), None, line
    drags = [value for key, value in intervals.items() if key in ("rate_per_s", "rate_x_per_s", "rate_y_per_s")]
    within = bool(drags) and all(inside(drag, aircraft.drag_per_s) for drag in drags)
    line += f", drag {aircraft.drag_per_s:.4f} in " + " ".join(f"[{drag['low']:.4f}, {drag['high']:.4f}]" for drag in drags)
    # A name counts as right where the answer itself says that the data cannot tell it from one that the world has.
    twins = [set(pair) for pair in answer["not_separable"]]
    right = all(name in AIR or any(name in twin and twin & AIR for twin in twins) for name in named)
    return accepted and (not drags or not right or bool(answer["changes"])), within if accepted and drags else None, line


def main():
    if subprocess.run(["/usr/bin/python3", "-c", "import numpy"], capture_output=True, check=False).returncode != 0:
        print("skipped: /usr/bin/python3 has no numpy (python3-numpy)")
        return 77
    m100, lab, source, *more = sys.argv[1:]
    flights, first = (int(word) for word in (more + ["40", "1"][len(more):])[:2])
    guide = pathlib.Path(source).resolve() / "firmware/companion/guide/worlds"
    columns = pathlib.Path(source).resolve() / "host_tests/lab/logs/maps/m100_recording_with_pose.toml"
    false, within = 0, []
    with tempfile.TemporaryDirectory() as temporary:
        for seed in range(first, first + flights):
            place = pathlib.Path(more[2] if len(more) > 2 else temporary) / str(seed)
            place.mkdir(parents=True)
            aircraft = Aircraft(seed)
            record(aircraft, m100, lab, guide, place)
            for axis, declared in (("roll", "second_order"), ("pitch", "second_order"), ("translation", "rigid_body")):
                wrong, drag_within, line = judge(aircraft, axis, identify(lab, columns, place, axis, declared))
                false += wrong
                within += [drag_within] if drag_within is not None else []
                print(f"flight {seed}, {line}{', FALSE ACCEPTANCE' if wrong else ''}", flush=True)
    print(f"{flights} flights: {false} false acceptances; drag accepted in {len(within)}, inside its interval in {sum(within)}")
    return 0 if false == 0 and sum(within) >= 0.9 * len(within) else 1


if __name__ == "__main__":
    sys.exit(main())
