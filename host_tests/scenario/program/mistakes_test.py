#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A beginner's mistakes, one row each: the exit code and the words of the remedy in one line.

Usage: mistakes_test.py M100 LAB VEHICLE TABLE. Prints one line per offence.
"""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

FENCE = "[fence]\nx_m = [-5, 5]\ny_m = [-5, 5]\nz_m = [0.3, 4]\n"
FILES = {
    "key.toml": "[axis.roll]\ndamping_rato = 0.5\n", "axis.toml": "[axis.rol]\ndamping_ratio = 0.5\n",
    "section.toml": "[paylod]\nmass_kg = 1.0\n", "change.toml": "[change]\nat_s = 1.0\n\"air.gust_ms\" = 1.0\n",
    "flight.toml": FENCE, "fence_key.toml": FENCE.replace("z_m", "z_mm"), "mode.toml": 'mode = "feild"\n' + FENCE,
    "centimetres.toml": "[fence]\nx_m = [-500, 500]\ny_m = [-500, 500]\nz_m = [30, 400]\n",
    "map.toml": 'time = "t_s"\n[signals]\nstick_rol = "a"\n', "map_key.toml": 'tiem = "t_s"\n[signals]\n',
    "course.txt": "step 1 0 0 0 5\n", "word.txt": "sqare 1 2 3\n", "degrees.txt": "quintic 1 0 0 90 5\n",
    "limit.txt": "limits sped_m_s 1\n", "script.txt": "1 silense 2\n", "script_value.txt": "1 tasks stuk\n",
    "script_fault.txt": "1 fault pose_nann\n", "data.csv": "t_s,rc_roll,foo\n0,1,2\n0.1,2,3\n0.2,3,4\n",
    "world.toml": "# as measured\n", "binary.bin": "\x00\x01",
    "roll.csv": "t,stick,roll\n" + "".join(f"{k / 50},{k % 7 / 7},{k % 5 / 50}\n" for k in range(2000)),
    "fraction.toml": 'time = "t"\n[signals]\nstick_roll = "stick"\nattitude_roll = "roll"\n',
    "no_stick.toml": 'time = "t"\n[signals]\nattitude_roll = "roll"\n'}
ROLL = ["identify", "--log", "roll.csv", "--axis", "roll", "--declare", "second_order", "--split", "alternate:5"]

# Program, words (names of FILES become paths), exit code, words of the line on the standard error.
MISTAKES = [
    # Misspelt words.
    ("m100", ["probee"], 2, "no subcommand 'probee'; did you mean `probe`?"),
    ("m100", ["probee", "--help"], 2, "did you mean `probe`?"),
    ("m100", ["probe", "--prot", "x"], 2, "--prot: no such option; did you mean `--port`?"),
    ("m100", ["fly", "--dry-run", "--port", "x", "--chanel", "movement"], 2, "did you mean `--channel`?"),
    ("m100", ["fly", "--dry-run", "--port", "x", "--channel", "movment"], 2, "did you mean `movement`?"),
    ("lab", ["frames", "decde"], 2, "did you mean `decode`?"),
    ("lab", ["experiments", "--mode", "feild"], 2, "did you mean `field`?"),
    ("lab", ["campaign", "world.toml", "--tasks", "hoverr"], 2, "did you mean `hover`?"),
    ("lab", ["loop", "--plant", "world.toml", "--out", "o", "--tasks", "trajectry"], 2, "did you mean `trajectory`?"),
    ("lab", ["excite", "--axis", "yawrate"], 2, "did you mean `yaw_rate`?"),
    ("lab", ["excite", "--kind", "doubelt"], 2, "did you mean `doublet`?"),
    ("lab", ["campaign", "key.toml"], 2, "key.toml:2: 'axis.roll.damping_rato': unknown key; did you mean `damping_ratio`?"),
    ("lab", ["campaign", "axis.toml"], 2, "did you mean `axis.roll`?"),
    ("lab", ["campaign", "section.toml"], 2, "did you mean `payload`?"),
    ("lab", ["campaign", "change.toml"], 2, "did you mean `gust_m_s`?"),
    ("m100", ["check", "--vehicle", "key.toml", "--gains", "TABLE"], 2, "did you mean `damping_ratio`?"),
    ("lab", ["course", "course.txt", "--flight", "fence_key.toml"], 2, "did you mean `z_m`?"),
    ("lab", ["course", "course.txt", "--flight", "mode.toml"], 2, "did you mean `field`?"),
    ("lab", ["course", "word.txt", "--flight", "flight.toml"], 2, "word.txt:1: 'sqare': no such piece; did you mean `square`?"),
    ("lab", ["course", "limit.txt", "--flight", "flight.toml"], 2, "did you mean `speed_m_s`?"),
    ("lab", ["autopilot", "--pty", "PTY", "--script", "script.txt"], 2, "did you mean `silence`?"),
    ("lab", ["autopilot", "--pty", "PTY", "--script", "script_value.txt"], 2, "did you mean `stuck`?"),
    ("lab", ["autopilot", "--pty", "PTY", "--script", "script_fault.txt"], 2, "did you mean `pose_nan`?"),
    ("lab", ["convert", "data.csv", "--columns", "map.toml", "--out", "o"], 2, "did you mean `stick_roll`?"),
    ("lab", ["convert", "data.csv", "--columns", "map_key.toml", "--out", "o"], 2, "did you mean `time`?"),
    # Files of another kind.
    ("lab", ["campaign", "flight.toml"], 2, "'fence': unknown section; this looks like a flight file (--flight)"),
    ("lab", ["campaign", "VEHICLE"], 2, "this looks like a vehicle file (--vehicle)"),
    ("lab", ["course", "course.txt", "--flight", "VEHICLE"], 2, "this looks like a vehicle file (--vehicle)"),
    ("lab", ["course", "course.txt", "--flight", "course.txt"], 2, "this looks like a course or a script, not TOML"),
    ("lab", ["convert", "data.csv", "--columns", "data.csv", "--out", "o"], 2, "this looks like a table (CSV), not TOML"),
    ("lab", ["convert", "data.csv", "--columns", "VEHICLE", "--out", "o"], 2, "this looks like a vehicle file"),
    ("lab", ["campaign", "binary.bin"], 2, "is no text: a log or another binary file"),
    ("lab", ["gains", "--vehicle", "VEHICLE", "--certify"], 2, "--certify: is gone: --corners samples the box"),
    ("lab", ["gains", "--vehicle", "map.toml"], 2, "this looks like a column map (--columns)"),
    # Folders.
    ("lab", ["demo", "--logs", "FOLDER"], 2, "has neither pitch_roll.csv and height.csv nor"),
    ("lab", ["demo", "--out", "course.txt"], 2, "course.txt/report.html: cannot be written: Not a directory (--out)"),
    ("lab", ["evening", "FOLDER"], 2, "holds other files: name a new or an empty folder"),
    # Units.
    ("lab", [*ROLL, "--columns", "fraction.toml", "--vehicle", "o.toml"], 2, "fraction.toml: 'stick_roll': stays within 5"),
    ("lab", [*ROLL, "--columns", "no_stick.toml"], 2, "no_stick.toml: 'stick_roll': axis roll needs this signal"),
    ("lab", ["course", "degrees.txt", "--flight", "flight.toml"], 2, "the heading is in rad, and 90 is more than a turn"),
    ("lab", ["course", "course.txt", "--flight", "centimetres.toml"], 2, "the fence is in metres, not in centimetres"),
    ("lab", ["excite", "--amplitude", "10"], 2, "10 counts are inside the dead zone of roll"),
    ("lab", ["excite", "--amplitude", "15"], 1, "no effect but a trim would be found"),
    ("lab", ["excite", "--axis", "yaw_rate", "--amplitude", "0.1"], 1, "take a larger --amplitude or --duration"),
    # Ports.
    ("m100", ["probe", "--port", "/nope"], 2, "/nope: does not exist: plug the adapter in"),
    ("m100", ["probe", "--port", "sim:/nope"], 2, "start m100-lab autopilot --sim /nope"),
    ("m100", ["probe", "--port", "FOLDER"], 2, "is not a serial port"),
    ("m100", ["fly", "--dry-run", "--port", "x", "--pose-port", "x"], 2, "x is the autopilot's port, too"),
    ("m100", ["record", "--port", "x", "--pose-port", "x", "--log", "o"], 2, "x is the autopilot's port, too"),
    # Logs.
    ("lab", ["logs", "data.csv", "--propose", "o.toml"], 1, ""),
    ("lab", ["logs", "flight.toml"], 2, "flight.toml: is text, but no log"),
]


def run(program, words, **more):
    done = subprocess.run([program, *words], capture_output=True, check=False, stdin=subprocess.DEVNULL, timeout=300,
                          **more)
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def told(programs, words, wanted, says, folder):
    """One offence unless the command ends with this exit code and one line that says this."""
    code, _, err = run(programs[0], words, cwd=folder)
    if code != wanted or says not in err or err.count("\n") != (1 if says else 0):
        yield f"{words}: exit code {code}, {err!r}; wanted {wanted}, {says!r}"


def port_without_right(m100, folder):
    port = folder / "locked"
    port.touch(mode=0o000)
    if os.geteuid() == 0:  # root may open it: then it is no serial port
        yield from told([m100], ["probe", "--port", str(port)], 2, "is not a serial port", folder)
    else:
        yield from told([m100], ["probe", "--port", str(port)], 2, "no permission to read and write: sudo usermod", folder)


class World:
    """The emulated autopilot in simulated time."""

    def __init__(self, lab, folder, *words):
        self.name = folder / "world"
        self.process = subprocess.Popen([lab, "autopilot", "--sim", str(self.name), *words], stdout=subprocess.DEVNULL)
        end = time.monotonic() + 60
        while not self.name.exists() and time.monotonic() < end:
            time.sleep(0.05)
        self.port = f"sim:{self.name}"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


def flight_offences(m100, lab, folder, vehicle, table):
    models = ["--vehicle", vehicle, "--gains", table, "--flight", str(folder / "flight.toml"), "--once", "--take-control"]
    slow = folder / "slow.toml"
    slow.write_text("[pose]\nrate_hz = 10.0\n")
    with World(lab, folder, "--plant", str(slow)) as world:
        _, out, err = run(m100, ["fly", "--port", world.port, "--pose-port", world.port + ".pose", *models, "--hold", "3"])
        if "poses come 10 times a second, fewer than 45: send 50 or more" not in out:
            yield f"poses at 10 Hz are flown without a word: {out + err}"
    with World(lab, folder) as world:
        code, out, err = run(m100, ["fly", "--port", world.port + ".pose", "--pose-port", world.port, *models])
        if code != 2 or "--port and --pose-port are exchanged" not in err:
            yield f"exchanged ports: exit code {code}: {out + err}"
    recording, flight = folder / "hand.ulg", folder / "flight.ulg"
    with World(lab, folder) as world:
        run(m100, ["record", "--port", world.port, "--hold", "2", "--log", str(recording)])
    yield from told([m100], ["replay", str(recording)], 2, "is a recording of m100 record, which has no ticks", folder)
    with World(lab, folder) as world:  # the shell's limit is a medium that takes no more
        words = ["fly", "--port", world.port, "--pose-port", world.port + ".pose", *models, "--hold", "5", "--log", flight]
        code, out, err = run("/bin/sh", ["-c", 'ulimit -f 200; exec "$@"', "sh", m100, *map(str, words)])
        if code != 0 or "the log is cut short: the file size limit is reached" not in out.splitlines()[-1]:
            yield f"a full disk is not repeated at the end: exit code {code}: {out[-300:] + err}"


def interrupted_gains(lab, folder, vehicle):
    terminal, of_program = os.openpty()
    gains = subprocess.Popen([lab, "gains", "--vehicle", vehicle, "--table", str(folder / "interrupted.bin")],
                             stdout=subprocess.DEVNULL, stderr=of_program)
    os.close(of_program)
    said = os.read(terminal, 1000).decode()  # on a terminal it names its first stage, and from then on it can be stopped
    gains.send_signal(signal.SIGINT)
    code = gains.wait()
    said += os.read(terminal, 1000).decode()
    os.close(terminal)
    if code != 1 or "stopped, no table was written; the same command starts again" not in said:
        yield f"gains, Ctrl-C: exit code {code}: {said!r}"


def main():
    m100, lab, vehicle, table = sys.argv[1:5]
    offences = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for file, text in FILES.items():
            (folder / file).write_text(text)
        named = {"VEHICLE": vehicle, "TABLE": table, "FOLDER": name, "PTY": str(folder / "pty")}
        for program, words, wanted, says in MISTAKES:
            line = [named.get(word, word) for word in words]
            offences += told([m100 if program == "m100" else lab], line, wanted, says, folder)
        offences += port_without_right(m100, folder)
        offences += interrupted_gains(lab, folder, vehicle)
        offences += flight_offences(m100, lab, folder, vehicle, table)
    print("\n".join(offences))
    return 1 if offences else 0


if __name__ == "__main__":
    sys.exit(main())
