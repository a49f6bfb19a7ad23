#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks the programs' machine-readable output against the names on the pages: the events of the emulated autopilot,
the column map proposed for a recording, the findings of identify, the answer of replay, and the place in errors.

Usage: results_test.py M100 LAB VEHICLE TABLE. Prints one line per offence.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import time

from command_line_test import file_of, one_line, run
from mistakes_test import World

SCRIPT = """0.02 silence 0.05
0.04 lose_acks 2 obtain_control
0.06 delay_acks 0.1
0.08 double_acks 2
0.10 noise 20
0.12 loss 0.01
0.14 ioc on
0.16 activation 3
0.18 end_virtual_rc
0.20 rc off
0.22 rc on
0.24 take mobile
0.26 take rc
0.28 mode A
0.30 mode A
0.32 mode F
0.34 stick roll 10 0.1
0.36 doublet roll 10 0.1
0.38 3211 roll 10 0.1
0.40 chirp roll 10 1 2 0.1
0.42 restart
"""
DID = ["silence", "lose_acks", "delay_acks", "double_acks", "noise", "loss", "ioc", "activation", "end_virtual_rc",
       "rc_off", "rc_on", "take_mobile", "take_rc", "mode", "mode", "mode", "stick", "stick", "stick", "stick", "restart"]


def event_offences(lab, folder):
    events = folder / "events"
    code, _, err = run(lab, "autopilot", "--pty", folder / "pty", "--duration", "1", "--events", events, "--script",
                       file_of(folder, "script", SCRIPT))
    lines = [json.loads(line) for line in events.read_text().splitlines()] if code == 0 else []
    words = {line["what"] for line in lines}
    if not words <= {"received", "answered", "did", "ignored", "truth", "summary"}:
        yield f"events: exit code {code}, unexpected 'what' in {words}, {err}"
    did = [line["name"] for line in lines if line["what"] == "did" and not line["name"].startswith("transmitter_")]
    if did != DID:
        yield f"events: the script causes {did}"


def wait_for(path):
    for _ in range(1000):
        if path.exists():
            return
        time.sleep(0.01)


def recording_offences(programs, folder, vehicle, table):
    """A recording and a dry run with the same emulated autopilot."""
    m100, lab = programs["m100"], programs["m100-lab"]
    pty, pose = folder / "n1", folder / "pose"
    autopilot = subprocess.Popen([lab, "autopilot", "--pty", pty, "--pose-pty", pose, "--duration", "60"],
                                 stdout=subprocess.DEVNULL)
    wait_for(pose)
    recording, flown = folder / "rec.ulg", folder / "dry.ulg"
    code, _, err = run(m100, "record", "--port", pty, "--pose-port", pose, "--log", recording, "--hold", "1.5")
    if code != 0:
        yield f"m100 record: exit code {code}, {err}"
    code, _, err = run(m100, "fly", "--dry-run", "--port", pty, "--pose-port", pose, "--vehicle", vehicle, "--gains",
                       table, "--hold", "1", "--log", flown)
    if code != 0:
        yield f"m100 fly --dry-run: exit code {code}, {err}"
    autopilot.terminate()
    autopilot.wait()
    proposed = folder / "map.toml"
    code, out, err = run(lab, "logs", recording, "--propose", proposed)
    text = proposed.read_text() if code == 0 else ""
    shipped = pathlib.Path(__file__).parents[2] / "lab/logs/maps/m100_recording_with_pose.toml"
    wanted = {line.split(" = ")[0] for line in shipped.read_text().splitlines() if " = " in line}
    if "our own recording" not in out or not wanted <= {line.split(" = ")[0] for line in text.splitlines()}:
        yield f"logs --propose of a recording: exit code {code}, {out} {err} {text}"
    answer = folder / "converted.json"
    maps = {}
    for name, columns in (("proposed", proposed), ("shipped", shipped)):
        code, _, err = run(lab, "convert", recording, "--columns", columns, "--out", folder / f"{name}.csv", "--json",
                           answer)
        maps[name] = (folder / f"{name}.csv").read_text() if code == 0 else err
    if maps["proposed"] != maps["shipped"]:
        yield f"the proposed map reads a recording differently from the shipped map: {maps['proposed'][:200]}"
    yield from replay_offences(m100, folder, flown)


def refusal_offences(programs, folder, vehicle, table):
    """The message of a flight that ends by itself must not ask the operator for an input to the ended program."""
    flight = pathlib.Path(__file__).parents[3] / "firmware/companion/files/example/flight.toml"
    with World(programs["m100-lab"], folder, "--rc-mode", "P") as world:
        code, out, err = run(programs["m100"], "fly", "--port", world.port, "--pose-port", world.port + ".pose", "--vehicle",
                             vehicle, "--gains", table, "--flight", flight, "--take-control", "--once")
    said = out + err
    if code != 1 or "refused: " not in said or "start it again" not in said or "Enter" in said:
        yield f"fly --once in mode P: exit code {code}, {said}"


def replay_offences(m100, folder, flown):
    answer = folder / "replay.json"
    code, out, err = run(m100, "replay", flown, "--json", answer)
    read = json.loads(answer.read_text()) if code == 0 else {}
    if not read.get("same") or read["sha256"] != out.split("\n")[0] or read["ticks_unlike"] != 0 or read["ticks"] == 0:
        yield f"m100 replay --json: exit code {code}, {read}, {out}, {err}"
    spoilt = folder / "spoilt.ulg"
    spoilt.write_bytes(flown.read_bytes().replace(b"[axis.roll]", b"[axis\xff\x1broll]", 1))
    yield from one_line(m100, ["replay", spoilt], "spoilt.ulg: ")


def plant_offences(lab, folder):
    """Every command that reads a plant refuses endless files at once, and its errors name line and key."""
    for words in (["autopilot", "--pty", folder / "p", "--duration", "0.01"], ["experiments", "--only", "hover"],
                  ["loop", "--out", folder / "o.toml"]):
        for device in ("/dev/zero", "/"):
            yield from one_line(lab, [*words, "--plant", device], f"{device}: is ")
    yield from one_line(lab, ["campaign", "/dev/zero"], "/dev/zero: is not a regular file")
    for text, says in (('[sensors]\npose_noise_m = "text"\n', ":2: 'sensors.pose_noise_m'"),
                       ("[axis.roll]\ndamping_ratio = 0\n", ":2: 'axis.roll.damping_ratio'"),
                       ("[axis.yaw_rate]\ndamping_ratio = 0.3\n", ":2: 'axis.yaw_rate.damping_ratio'"),
                       ("axis = 3\n", ":1: 'axis': must be a table")):
        plant = file_of(folder, "plant.toml", text)
        yield from one_line(lab, ["autopilot", "--pty", folder / "p", "--duration", "0.01", "--plant", plant],
                            "plant.toml" + says)


def mpc_offences(lab, folder):
    model = {"type": "model", "name": "m", "nx": 3, "N": 20, "dt": 0.1, "A": [[1, 0.1, 0], [0, 1, 0.9], [0, 0, 0.8]],
             "B": [0, 0, 0.2], "Bd": [0, 0.1, 0], "Q": [1, 1, 1], "R": 1, "Rd": 0,
             "P": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "u_min": -1, "u_max": 1}
    problem = {"type": "qp", "id": 7, "model": "m", "x0": [1, 0, 0], "u_prev": 0, "d": 0, "p_ref": 0, "v_ref": 0,
               "th_ref": 0, "u_ref": 0}

    def written(of_model, of_problem):
        lines = [{k: v for k, v in {**one, **change}.items() if v is not None}
                 for one, change in ((model, of_model), (problem, of_problem))]
        return file_of(folder, "i.jsonl", "".join(json.dumps(line) + "\n" for line in lines))
    code, out, err = run(lab, "mpc", "solve", written({}, {}))
    if code != 0 or json.loads(out)["id"] != 7:
        yield f"mpc solve: exit code {code}, {out}, {err}"
    for of_model, of_problem, says in (({"dt": None}, {}, ":1: 'dt'"), ({"dt": 1e-30}, {}, ":1: 'dt'"),
                                       ({"Rd": -1}, {}, ":1: 'Rd'"), ({"Q": [-1, 1, 1]}, {}, ":1: 'Q'"),
                                       ({}, {"id": 1.5}, ":2: 'id'"), ({}, {"type": None}, ":2: 'type'")):
        yield from one_line(lab, ["mpc", "solve", written(of_model, of_problem)], "i.jsonl" + says)


def identify_offences(lab, folder):
    """Each finding, notes included, has a start and an end time."""
    rows, roll = ["t_s,rc_roll,roll"], 0.0
    for k in range(6000):
        stick = 200 * math.sin(0.02 * k) * math.cos(0.0031 * k)
        roll += 0.05 * (9e-4 * stick - roll)
        rows.append(f"{k / 100:.2f},{1024 + stick:.3f},{roll + 0.001 * math.sin(7.3 * k):.6f}")
    log = file_of(folder, "l.csv", "\n".join(rows) + "\n")
    columns = file_of(folder, "c.toml", 'time = "t_s"\n[signals]\nstick_roll = { column = "rc_roll", offset = -1024 }\n'
                                        'attitude_roll = "roll"\n')
    answer = folder / "found.json"
    code, _, err = run(lab, "identify", "--log", log, "--columns", columns, "--axis", "roll", "--declare", "first_order",
                       "--train", "2:30", "--validate", "30:58", "--draws", "0", "--json", answer)
    read = json.loads(answer.read_text()) if code == 0 else {"findings": []}
    if not read["findings"]:
        yield f"identify: exit code {code}, no finding: {err}"
    for finding in read["findings"]:
        if not 2.0 <= finding.get("from_s", -1) < finding.get("to_s", -1) <= 58.0:
            yield f"identify: a finding without a valid time: {finding}"


def main():
    programs = {"m100": sys.argv[1], "m100-lab": sys.argv[2]}
    lab = programs["m100-lab"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        found = [*event_offences(lab, folder), *plant_offences(lab, folder), *mpc_offences(lab, folder),
                 *identify_offences(lab, folder), *recording_offences(programs, folder, *sys.argv[3:5]),
                 *refusal_offences(programs, folder, *sys.argv[3:5])]
    for one in found:
        print(one)
    print(f"{len(found)} offences")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
