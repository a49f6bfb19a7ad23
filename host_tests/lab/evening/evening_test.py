#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""m100-lab evening as a person uses it.

Usage: evening_test.py M100 LAB            what it asks, refuses, resumes and notices; nothing flies
       evening_test.py M100 LAB --whole    the whole evening against the emulated autopilot, in simulated time

The whole evening is recorded by hand on the bare aircraft; then a payload, another trim and a longer delay are hidden
in it. The error before and after the correction is printed; what was hidden must be found, and after must not be
larger by more than a twentieth.
"""
import hashlib
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import time

HIDDEN = """[payload]
mass_kg = 0.4
[axis.roll]
trim_counts = 95.0
transport_delay_s = 0.13
[axis.pitch]
trim_counts = 10.0
transport_delay_s = 0.13
"""
FENCE = "[fence]\nx_m = [-12.0, 12.0]\ny_m = [-12.0, 12.0]\nz_m = [0.3, 6.0]\n"


def pilot_script():
    """Pairs of kicks, chirps and 3211s on roll and pitch in turn; seconds from power-up."""
    lines, at = [], 4.0
    for turn in range(3):
        side = 1 if turn % 2 == 0 else -1
        for stick in ("roll", "pitch"):
            lines += [f"{at} 3211 {stick} {150 * side} 0.3", f"{at + 6} doublet {stick} {-90 * side} 0.6",
                      f"{at + 11} chirp {stick} {120 * side} 0.5 2.5 6"]
            at += 20.0
    return "\n".join(lines) + "\n"


REVERSED_MAP = """time = "t_s"
[signals]
stick_roll = "roll_stick"
stick_pitch = "pitch_stick"
attitude_roll = "roll_rad"
attitude_pitch = "pitch_rad"
"""


def reversed_log():
    """A minute as CSV in which each axis answers its stick with the wrong sign: as a column map with a sign slip reads."""
    chance, rows = random.Random(7), ["t_s,roll_stick,pitch_stick,roll_rad,pitch_rad"]
    sticks, tilts, speeds, late = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [(0.0, 0.0)] * 5
    for k in range(3000):
        for axis in range(2):
            if k % 25 == 0:
                sticks[axis] = chance.choice((-150.0, 0.0, 150.0))
            speeds[axis] += 0.02 * (49.0 * (-8.65e-4 * late[0][axis] - tilts[axis]) - 9.8 * speeds[axis])
            tilts[axis] += 0.02 * speeds[axis]
        late = [*late[1:], tuple(sticks)]
        seen = [tilt + chance.gauss(0.0, 0.002) for tilt in tilts]
        rows.append(f"{0.02 * k:.2f},{sticks[0]},{sticks[1]},{seen[0]:.6f},{seen[1]:.6f}")
    return "\n".join(rows) + "\n"


class Evening:
    def __init__(self, m100, lab, work):
        self.m100, self.lab, self.work = m100, lab, work
        self.folder = work / "aircraft"
        self.world = work / "world"
        self.begin = ["--port", f"sim:{self.world}", "--pose-port", f"sim:{self.world}.pose", "--m100", m100]

    def call(self, *more):
        run = subprocess.run([self.lab, "evening", str(self.folder), *more], capture_output=True, text=True, check=False)
        print(run.stdout, run.stderr, sep="", end="", flush=True)
        return run.returncode, run.stdout + run.stderr

    def state(self):
        return json.loads((self.folder / "evening.json").read_text())

    def put(self, name, content):
        (self.folder / name).write_text(content if isinstance(content, str) else json.dumps(content))

    def on_board(self, step, argv):
        """Runs the command that the evening printed, with an autopilot of its own."""
        arguments = ["autopilot", "--sim", str(self.world), "--seed", "7"]
        if step == "record":
            (self.work / "pilot.txt").write_text(pilot_script())
            arguments += ["--rc-mode", "P", "--script", str(self.work / "pilot.txt")]
        else:
            (self.work / "hidden.toml").write_text(HIDDEN)
            arguments += ["--plant", str(self.work / "hidden.toml")]
        with subprocess.Popen([self.lab, *arguments], stdout=subprocess.DEVNULL) as autopilot:
            while not self.world.exists() and autopilot.poll() is None:
                time.sleep(0.01)
            run = subprocess.run([self.m100, *argv[1:]], cwd=self.folder, capture_output=True, text=True, check=False)
            autopilot.terminate()
        self.world.unlink(missing_ok=True)
        expect(run.returncode == 0, f"{step} on the board ended with {run.returncode}: {run.stdout[-600:]}{run.stderr}")


def expect(holds, what):
    if not holds:
        raise SystemExit(f"FAILED: {what}")


def without_flight(evening):
    code, said = evening.call()
    expect(code == 2 and "--pose-port" in said, "a new folder needs to be told its ports")
    code, said = evening.call(*evening.begin)
    expect(code == 0 and "next: probe" in said and f"m100 probe --port sim:{evening.world}" in said, "begins with probe")
    evening.put("probe.json", {"verdict": "wrong_baud", "remedy": "set the baud rate"})
    code, said = evening.call()
    expect(code == 1 and "wrong_baud" in said and "set the baud rate" in said, "a failed check stops the evening")
    expect((evening.folder / "not_passed/probe.1/probe.json").is_file(), "what did not pass makes room")
    evening.put("probe.json", {"verdict": "autopilot"})
    code, said = evening.call()
    expect(code == 0 and "next: record" in said, "resumed where it was left")
    evening.put("hand.ulg", "no log")
    evening.put("record.json", {"recorded": True, "sticks": {"roll": {"most_counts": 150, "least_counts": -150},
                                                             "pitch": {"most_counts": 150, "least_counts": -20}}})
    code, said = evening.call()
    expect(code == 1 and "the pitch stick moved from -20 to 150" in said, "a stick that hardly moved is named")
    evening.put("hand.ulg", "no log")
    evening.put("record.json", {"recorded": True, "sticks": {stick: {"most_counts": 150, "least_counts": -150}
                                                             for stick in ("roll", "pitch")}})
    for _ in range(2):
        code, said = evening.call()
        expect(code == 1 and "identify: NOT PASSED" in said, "a step of the PC that fails stops the evening, each time")
    refuses_a_misread_log(evening)
    notices_changes(evening)


def refuses_a_misread_log(evening):
    """Catches an evening that goes on to the flight with a model that identify refused to write."""
    evening.put("columns_hand.toml", REVERSED_MAP)
    evening.put("hand.ulg", reversed_log())
    code, said = evening.call()
    expect(code == 1 and "a sign of the column map is probably wrong" in said, "identify refuses a log whose sign is wrong")
    expect("identify: NOT PASSED: the command ended with 1" in said and "gains:" not in said, "and the evening stops")


def notices_changes(evening):
    """A state as after `gains`; then the file that the tables were made from becomes another."""
    def sha(name):
        return hashlib.sha256((evening.folder / name).read_bytes()).hexdigest()

    for name in ("identified.toml", "vehicle.toml"):
        evening.put(name, f"# {name}\n")
    state = evening.state()
    state["done"] = ["probe", "record", "identify", "gains"]
    state["files"] |= {"identified.toml": {"sha256": sha("identified.toml"), "made_by": "identify",
                                           "from": {"hand.ulg": sha("hand.ulg")}},
                       "vehicle.toml": {"sha256": sha("vehicle.toml"), "made_by": "gains",
                                        "from": {"identified.toml": sha("identified.toml")}}}
    evening.put("evening.json", state)
    code, said = evening.call("--list")
    expect(code == 0 and "changed" not in said and "done  gains" in said, "nothing has changed yet")
    evening.put("identified.toml", "# by hand\n")
    code, said = evening.call("--list")
    expect("identified.toml changed after it was used: to be done again with it: 'gains'" in said, "a change is said")
    expect("done  identify" in said and "done  gains" not in said, "what was made from it is to be done again")
    evening.put("evening.json", state)
    evening.put("hand.ulg", "another log")
    code, said = evening.call("--list")
    expect("hand.ulg changed" in said and "done  identify" not in said and "done  gains" not in said,
           "a change reaches what was made from what was made from it")


def whole(evening):
    evening.call(*evening.begin)
    evening.put("flight.toml", FENCE)
    for _ in range(20):
        code, said = evening.call()
        expect(code == 0, f"the evening stopped: {said}")
        ahead = evening.state()["next"]
        if ahead["step"] == "over":
            break
        expect(ahead["where"] == "board", "the PC's steps are done without a person")
        evening.on_board(ahead["step"], ahead["argv"])
    numbers = evening.state()["numbers"]
    before, after = numbers["pose_m.course"], numbers["pose_m.corrected"]
    print(f"distance from the reference, root mean square: {before:.4f} m before, {after:.4f} m after")
    for name, value in sorted(numbers.items()):
        print(f"  {name} = {value:.4g}")
    expect((evening.folder / "evening.html").is_file(), "the page is there")
    for axis, trim in (("roll", 95.0), ("pitch", 10.0)):
        expect(abs(numbers[f"trim_counts.{axis}.after"] - trim) < 8.0, f"the hidden trim of {axis} is found")
        expect(0.12 < numbers[f"transport_delay_s.{axis}.after"] < 0.17, f"the hidden delay of {axis} is found")
    expect(after < 1.05 * before, "the corrected flight is worse")
    code, said = evening.call()
    expect(code == 0 and "the evening is over" in said, "called again, it says that it is over")


def main():
    with tempfile.TemporaryDirectory() as work:
        evening = Evening(sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[4] if len(sys.argv) > 4 else work))
        whole(evening) if "--whole" in sys.argv else without_flight(evening)
    return 0


if __name__ == "__main__":
    sys.exit(main())
