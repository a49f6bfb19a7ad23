#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Flies in the guide's example world, with good and with bad manners. Everything is judged in lockstep time.

Usage: body_test.py M100 LAB SOURCE_FOLDER TABLE
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
# Frames of 1/400 s from the first packet: on the ground, taking off, in the middle of the flight.
ON_GROUND, TAKING_OFF, FLYING = 100, 800, 12000
# What the one line must say, for every manner that no flight survives.
REFUSED = {"dies": "has ended", "malformed": "not a JSON object", "not_a_number": "not finite", "no_velocity": "'velocity'",
           "slow_rate": "steps by 20 ms", "restarts": "begun anew", "hangs": "no answer within", "stands_still": "stands still"}


def expect(holds, what):
    if not holds:
        raise SystemExit(f"FAILED: {what}")


def left(bench):
    """The physics programs that run, by their process ids."""
    found = subprocess.run(["pgrep", "-f", f"^/usr/bin/python3 .*{bench.guide}"], capture_output=True, text=True, check=False)
    return found.stdout.split()


class Bench:
    def __init__(self, m100, lab, source, table, work):
        self.m100, self.lab, self.table, self.work = m100, lab, table, work
        self.guide = source / "firmware/companion/guide/worlds"
        self.rude = source / "host_tests/scenario/body/rude_world.py"
        self.vehicle = source / "firmware/mpc/generated/vehicle.toml"
        self.count = 0

    def world(self, manner="", first=0):
        """The command of a physics program."""
        if manner:
            return f"exec /usr/bin/python3 '{self.rude}' {{port}} {manner} {first} '{self.guide}'"
        return f"exec /usr/bin/python3 '{self.guide}/quadrotor.py' {{port}} --wind={{wind}} --seed {{seed}}"

    def run_lab(self, *words):
        done = subprocess.run([self.lab, *words], capture_output=True, text=True, check=False, cwd=self.work)
        expect(not left(self), f"nothing is left running after {words}: {left(self)}")
        return done

    def campaign(self, manner="", first=0):
        """One hover of 30 s. -> its numbers, and what was said."""
        self.count += 1
        plant, result = self.work / "plant.toml", self.work / f"campaign{self.count}.json"
        plant.write_text("# the rude world takes no wind\n" if manner else "[air]\nwind_m_s = [3, 2, 0]\n")
        done = self.run_lab("campaign", str(plant), "--tasks", "hover", "--flights", "1", "--jobs", "1", "--body-command",
                            self.world(manner, first), "--json", str(result))
        return done, json.loads(result.read_text())["worlds"]["plant"] if done.returncode < 2 else None


def hovers(bench):
    """A body in 3.6 m/s of wind holds its place; the same flight again gives the same numbers."""
    done, flown = bench.campaign()
    expect(done.returncode == 0 and flown["stayed"] == 1 and flown["oscillating"] == 0, f"it stays: {done.stderr}")
    # The paper's measured hover in wind. (The identified response does 0.0235 m in this wind.)
    expect(flown["pose_rms_m"]["max"] < 0.041, f"it hovers: {flown['pose_rms_m']}")
    again = bench.campaign()[1]
    expect(again == flown, "the same flight gives the same numbers")


def survives(bench):
    """Lost, doubled and late packets change nothing at all."""
    clean = bench.campaign("none")[1]
    for manner in ("loses", "doubles", "late"):
        done, flown = bench.campaign(manner, FLYING)
        expect(done.returncode == 0, f"{manner}: {done.stderr}")
        expect(flown == clean, f"{manner}: the flight is the same, bit for bit")


def refuses(bench):
    for manner, says in REFUSED.items():
        for first in (ON_GROUND, TAKING_OFF, FLYING) if manner == "malformed" else (FLYING,):
            done = bench.campaign(manner, first)[0]
            lines = [line for line in done.stderr.splitlines() if line.startswith("m100-lab:")]
            expect(done.returncode == 2 and len(lines) == 1 and says in lines[0] and "hover, seed 1" in lines[0],
                   f"{manner} at {first}: exit code {done.returncode}, {done.stderr}")
    done = bench.run_lab("campaign", str(bench.work / "plant.toml"), "--body-command", "exit 3; {port}")
    expect(done.returncode == 2 and "ended with exit code 3" in done.stderr, f"one that does not start: {done.stderr}")
    ignored = bench.work / "ignored.toml"
    ignored.write_text("[axis.roll]\ntrim_counts = 9\n\n[air]\nlinear_drag_per_s = 0.3\n")
    for words in (["campaign", str(ignored)], ["experiments", "--plant", str(ignored)],
                  ["loop", "--out", "found.toml", "--plant", str(ignored)], ["autopilot", "--sim", "world", "--plant", str(ignored)]):
        done = bench.run_lab(*words, "--body-command", bench.world())
        expect(done.returncode == 2 and done.stderr.count("\n") == 1 and "ignored.toml:5: 'air.linear_drag_per_s'" in done.stderr,
               f"{words}: what the body does not have is refused: {done.stderr}")
    for words in (["--body", "json:9002"], ["--body", "gazebo"], ["--body-command", "no port"],
                  ["--body", "json:127.0.0.1:9002", "--jobs", "2"]):
        done = bench.run_lab("campaign", str(bench.work / "plant.toml"), *words)
        expect(done.returncode == 2 and done.stderr.count("\n") == 1, f"{words}: {done.stderr}")


def leaves_nothing_when_killed(bench):
    """SIGKILL runs no destructor; the shell that starts the program has a child of its own."""
    command = "cd / && " + bench.world("none").removeprefix("exec ")
    with subprocess.Popen([bench.lab, "campaign", str(bench.work / "plant.toml"), "--jobs", "1", "--body-command", command],
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as lab:
        while not left(bench):
            time.sleep(0.01)
        lab.kill()
    for _ in range(1000):
        if not left(bench):
            return
        time.sleep(0.01)
    expect(False, f"nothing is left running: {left(bench)}")


def gives_the_sticks_back(bench, manner):
    """The physics program fails while m100 flies: the pilot has the sticks, and both programs end."""
    place = bench.work / f"fly_{manner}"
    place.mkdir()
    socket, events = place / "world", place / "events.jsonl"
    (place / "flight.toml").write_text("[fence]\nx_m = [-5, 5]\ny_m = [-5, 5]\nz_m = [0.3, 4]\n")
    with subprocess.Popen([bench.lab, "autopilot", "--sim", str(socket), "--events", str(events), "--body-command",
                           bench.world(manner, 2 * FLYING)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as autopilot:
        while not socket.exists() and autopilot.poll() is None:
            time.sleep(0.01)
        flown = subprocess.run([bench.m100, "fly", "--port", f"sim:{socket}", "--pose-port", f"sim:{socket}.pose", "--vehicle",
                                str(bench.vehicle), "--gains", bench.table, "--flight", str(place / "flight.toml"),
                                "--take-control", "--hold", "200", "--once"], capture_output=True, text=True, check=False)
        said, wrong = autopilot.communicate()
    expect("response of the body beside the measured aircraft" in said, f"the response is printed: {said}")
    expect(autopilot.returncode == 2 and wrong.count("\n") == 1 and REFUSED[manner] in wrong, f"{manner}: {wrong}")
    expect("control_lost" in flown.stdout and "ended" in flown.stdout, f"m100 sees it: {flown.stdout[-300:]}")
    last = json.loads(events.read_text().splitlines()[-1])
    expect(last["virtual_rc_taken"] > 0, "it had flown")
    expect(not last["client_in_control"] and not last["virtual_rc_on"] and last["control_after_loss"] == 0 and
           last["transmitter_since_s"] > 0.0, f"the pilot has the sticks: {last}")


def main():
    if subprocess.run(["/usr/bin/python3", "-c", "import numpy"], capture_output=True, check=False).returncode != 0:
        print("skipped: /usr/bin/python3 has no numpy (python3-numpy)")
        return SKIPPED
    m100, lab, source, table = sys.argv[1:]
    with tempfile.TemporaryDirectory() as work:
        bench = Bench(m100, lab, pathlib.Path(source).resolve(), table, pathlib.Path(work))
        hovers(bench)
        survives(bench)
        refuses(bench)
        leaves_nothing_when_killed(bench)
        for manner in ("dies", "malformed"):
            gives_the_sticks_back(bench, manner)
    return 0


if __name__ == "__main__":
    sys.exit(main())
