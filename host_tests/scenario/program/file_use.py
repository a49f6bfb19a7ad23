#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks the use of files by every command of both programs. None may overwrite its inputs, write two outputs to one
file, begin its work before it has checked that it can read its inputs and write its outputs, or wait for the end of a
device or a pipe.

Usage: file_use.py M100 LAB. Every text option of every subcommand must be in the table below as an input, an output, a
folder, or as no file; a new option that is not there is an offence. Prints one line per offence.
"""
import itertools
import os
import pathlib
import re
import subprocess
import sys
import tempfile

PATIENCE_S = 300  # for a busy machine; the commands themselves end at once

# command: words: further arguments that it needs; inputs; outputs; links: outputs that are created, not opened;
# folders; needed: required ones of these; other: texts that are no files; kept: (output, input) pairs that may be the
# same file
TABLE = {
    "m100 fly": dict(words="--port /nope/port --pose-port /nope/pose",
                     inputs=["--key-file", "--mavlink-key", "--vehicle", "--gains", "--flight", "--course", "--excite"],
                     outputs=["--json", "--log"], other=["--port", "--pose-port", "--channel", "--mode", "--law",
                                                         "--override", "--live", "--status"]),
    "m100 handshake": dict(words="--port /nope/port", inputs=["--key-file"], outputs=["--json"],
                           other=["--port", "--channel"]),
    "m100 record": dict(words="--port /nope/port --pose-port /nope/pose", inputs=["--key-file", "--mavlink-key"],
                        needed=["--log"], outputs=["--log", "--json"], other=["--port", "--pose-port"]),
    "m100 probe": dict(words="--port /nope/port", outputs=["--json"], other=["--port"]),
    "m100 doctor": dict(words="--load 0 --port /nope/port", outputs=["--json"],  # doctor reports a bad key as its result
                        other=["--port", "--pose-port", "--mavlink-key", "--folder", "--pose-message"]),
    "m100 check": dict(inputs=["--vehicle", "--gains", "--flight", "--course"], needed=["--vehicle", "--gains"],
                       outputs=["--json"]),
    "m100 replay": dict(inputs=["log", "--key-file"], needed=["log"], outputs=["--json"], other=["--scalar"]),
    "m100-lab autopilot": dict(words="--duration 0.01", inputs=["--plant", "--plant-from", "--key-file", "--script", "--real"],
                               outputs=["--events", "--pty"], needed=["--pty"], links=["--pty"],
                               other=["--pose-pty", "--sim", "--board", "--course", "--rc-mode", "--body", "--body-command"]),
    "m100-lab autopilot --board": dict(inputs=["--board", "--plant", "--script"], needed=["--board"],
                                       outputs=["--events"]),
    "m100-lab campaign": dict(words="--flights 1 --tasks hover", inputs=["worlds", "--vehicle", "--plant-from"],
                              needed=["worlds"], outputs=["--json"], folders=["--report"],
                              other=["--tasks", "--law", "--mode", "--channel", "--split", "--merge", "--body",
                                     "--body-command"]),
    "m100-lab campaign --merge": dict(inputs=["--merge"], needed=["--merge"], outputs=["--json"], folders=["--report"]),
    "m100-lab convert": dict(inputs=["--log", "--columns"], needed=["--log"], outputs=["--out", "--map", "--json"],
                             other=["log"]),
    "m100-lab course": dict(inputs=["courses", "--flight"], needed=["courses"], outputs=["--json"], folders=["--out"]),
    # Becomes a script whose commands stand in this table.
    "m100-lab demo": dict(other=["--out", "--logs"]),
    "m100-lab excite": dict(inputs=["--vehicle"], outputs=["--out", "--json"], other=["--axis", "--kind"]),
    "m100-lab experiments": dict(words="--only hover", inputs=["--plant", "--plant-from", "--vehicle"],
                                 outputs=["--json"], folders=["--report"],
                                 other=["--only", "--channel", "--law", "--mode", "--tasks", "--body", "--body-command"]),
    "m100-lab flight": dict(inputs=["log", "--key-file"], needed=["log", "--out"], outputs=["--out", "--json"],
                            other=["--title", "--note"]),
    "m100-lab frames decode": dict(inputs=["file", "--key-file"], needed=["file"]),
    "m100-lab frames encode": dict(inputs=["file", "--key-file"], needed=["file"]),
    "m100-lab gains": dict(inputs=["--vehicle", "--rival", "--present"], needed=["--vehicle"],
                           outputs=["--out", "--table", "--json", "--tune"], other=["--setpoint-box", "--mode"]),
    "m100-lab identify": dict(words="--axis roll --declare first_order --split alternate:6",
                              inputs=["--log", "--columns", "--validate-log", "--validate-columns",
                                      "--vehicle-believed", "--forecast"],
                              needed=["--log", "--columns", "--validate-log"], outputs=["--json", "--vehicle", "--vehicle-declared"],
                              folders=["--report"], kept=[("--vehicle", "--vehicle-believed")],
                              other=["--axis", "--declare", "--train", "--validate", "--split", "--within"]),
    "m100-lab inject": dict(words="--axis roll --effect dead_zone=10 --train 1:9", inputs=["--log", "--columns"],
                            needed=["--log", "--columns", "--out"], outputs=["--out", "--map", "--json"],
                            other=["--axis", "--declare", "--train", "--effect"]),
    "m100-lab logs": dict(inputs=["--log"], needed=["--log"], outputs=["--json", "--propose"],
                          other=["log"]),
    "m100-lab loop": dict(inputs=["--plant", "--plant-from", "--vehicle", "--models"], needed=["--plant", "--out"],
                          outputs=["--out", "--json"], folders=["--logs", "--report"],
                          other=["--law", "--tasks", "--body", "--body-command"]),
    "m100-lab mpc solve": dict(inputs=["FILE"], needed=["FILE"], other=["--scalar", "--law"]),
    "m100-lab paper": dict(inputs=["--pitch-roll", "--height", "--yaw"], needed=["--pitch-roll", "--height"],
                           outputs=["--json", "--configuration"]),
    "m100-lab report": dict(inputs=["pages", "--lead", "--identified", "--experiments", "--loop", "--margins"],
                            needed=["pages", "--out"], outputs=["--out"],
                            other=["--title", "--note", "--asked", "--source"]),
    # Uses the files of an aircraft's folder; the other names belong to the board and are not opened here.
    "m100-lab evening": dict(other=["folder", "--port", "--pose-port", "--pose-from", "--set-points-from", "--mavlink-key", "--bridge", "--key-file", "--m100", "--board"]),
    "m100-lab bridge": dict(words="--listen udp:9763 --to 127.0.0.1:9764 --duration 0.01", inputs=["--mavlink-key"],
                            needed=["--mavlink-key"], outputs=["--json"],
                            other=["--listen", "--from", "--vrpn", "--to", "--axes", "--stamp"]),
    "m100-lab reference": dict(other=["page"]),
}
SWITCHES = {"--board", "--merge"}  # options in a name of the table that change the command's meaning


class Bench:
    """Runs one command of the table with every wrong use of its files."""

    def __init__(self, programs, name, row, folder):
        self.programs, self.name, self.row, self.folder = programs, name, row, folder
        self.inputs, self.outputs = row.get("inputs", []), row.get("outputs", [])
        self.folders, self.links = row.get("folders", []), row.get("links", [])

    def fresh(self):
        """-> a path for each option; the inputs exist, each with a different text, readable only by their owner."""
        paths = {}
        for option in self.inputs + self.outputs + self.folders:
            paths[option] = self.folder / ("x" + option.strip("-"))
        for old in self.folder.iterdir():
            old.unlink()
        for option in self.inputs:
            paths[option].write_text(f"text of {option}\n")
            paths[option].chmod(0o600)
        return paths

    def run(self, paths, options):
        words = [word for word in self.name.split()[1:] if word not in SWITCHES] + self.row.get("words", "").split()
        for option in dict.fromkeys(self.row.get("needed", []) + options):
            words += ([option] if option.startswith("--") else []) + [str(paths[option])]
        done = subprocess.run([self.programs[self.name.split()[0]]] + words, capture_output=True, check=False,
                              timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
        return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace"), words

    def expect_refused(self, paths, options, says):
        before = {path: path.read_bytes() for path in self.folder.iterdir() if path.is_file()}
        code, out, err, words = self.run(paths, options)
        wrong = []
        if code != 2 or out or err.count("\n") != 1 or says not in err:
            wrong.append(f"exit code {code}, stdout '{out[:60]}', stderr '{err[:160].strip()}', wanted '{says}'")
        after = {path: path.read_bytes() for path in self.folder.iterdir() if path.is_file()}
        if before != after:
            wrong.append("files changed: " + ", ".join(str(path.name) for path in before.keys() ^ after.keys()
                                                       or [p for p in before if before[p] != after[p]]))
        return [f"{self.name} {' '.join(words)}: {one}" for one in wrong]

    def offences(self):
        for output, taken in itertools.product(self.outputs, self.inputs):
            for by_link in (False, True):
                if (output, taken) in self.row.get("kept", []) and not by_link:
                    continue
                paths = self.fresh()
                if by_link:
                    paths[output].symlink_to(paths[taken])
                else:
                    paths[output] = paths[taken]
                yield from self.expect_refused(paths, [taken, output], "would be overwritten")
        for one, other in itertools.combinations(self.outputs, 2):
            paths = self.fresh()
            paths[other] = paths[one]
            yield from self.expect_refused(paths, [one, other], "would be lost")
        for output in self.outputs:
            paths = self.fresh()
            paths[output] = "/nope/x"
            if output not in self.links:
                yield from self.expect_refused(paths, [output], "/nope/x: cannot be written")
            paths = self.fresh()
            os.mkfifo(paths[output])  # no process reads it
            says = "exists already" if output == "--log" else "is a named pipe"
            if output not in self.links:
                yield from self.expect_refused(paths, [output], says)
        for output in self.folders:
            paths = self.fresh()
            paths[output].write_text("a file, no folder\n")
            yield from self.expect_refused(paths, [output], "cannot be written")
            paths[output] = "/proc/nope"
            yield from self.expect_refused(paths, [output], "cannot be written")
        for taken in self.inputs:
            for kind in ("device", "pipe", "folder", "missing"):
                paths = self.fresh()
                paths[taken].unlink()
                says = "not a regular file"
                if kind == "device":
                    paths[taken] = "/dev/zero"
                elif kind == "pipe":
                    os.mkfifo(paths[taken])
                elif kind == "folder":
                    paths[taken] = self.folder
                else:
                    says = "cannot be read"
                yield from self.expect_refused(paths, [taken], says)


def options_of(programs, command):
    """Names of the options and positionals of a subcommand that take a text."""
    words = [word for word in command.split() if word not in SWITCHES]
    run = subprocess.run([programs[words[0]]] + words[1:] + ["--help"], capture_output=True, text=True, check=True)
    for line in run.stdout.splitlines():
        if found := re.match(r"^  (\S+) (?:FLOAT|UINT|INT|TEXT)", line):
            names = found[1].split(",")
            if " TEXT" in line:
                yield next((name for name in names if name.startswith("--")), names[-1])


def subcommands(program, words=()):
    """-> the words of every subcommand."""
    run = subprocess.run([program, *words, "--help"], capture_output=True, text=True, check=True)
    names = re.findall(r"^  (\S+) ", run.stdout.split("Subcommands:")[1], re.M) if "Subcommands:" in run.stdout else []
    if not names:
        yield words
    for name in names:
        yield from subcommands(program, (*words, name))


def main():
    programs = {"m100": sys.argv[1], "m100-lab": sys.argv[2]}
    found, runs = [], 0
    for name, program in programs.items():
        for words in subcommands(program):
            command = " ".join((name, *words))
            rows = [row for title, row in TABLE.items()
                    if " ".join(word for word in title.split() if word not in SWITCHES) == command]
            if not rows:
                found.append(f"{command} has no row in the table")
            known = {option for row in rows for part in ("inputs", "outputs", "folders", "other")
                     for option in row.get(part, [])}
            found += [f"{command}: the table lacks {option}" for option in options_of(programs, command)
                      if option not in known]
    with tempfile.TemporaryDirectory() as folder:
        for name, row in TABLE.items():
            bench = Bench(programs, name, row, pathlib.Path(folder))
            before = len(found)
            found += bench.offences()
            runs += 1
            print(f"{name}: {len(found) - before} offences")
    for one in found:
        print(one)
    print(f"{runs} commands, {len(found)} offences")
    return 1 if found or runs == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
