#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Walks through the guide as a new user would: runs every line of its code blocks unchanged and in order.

Usage: guide_walk.py M100 LAB SOURCE TABLE [FOLDER]

SOURCE is the project's folder, TABLE the gain table of the shipped vehicle file. Replacements: the emulated autopilot,
in simulated time, replaces the aircraft at /dev/ttyUSB0 and /dev/ttyUSB1; a folder as in the package replaces
/usr/share/doc/m100/examples; the window in excite.json replaces FROM:TO. Lines that build or install (NOT_HERE) belong
to other tests. FOLDER keeps the files made, and walk.txt with the output of every line.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

NOT_HERE = re.compile(r"^(host_tests/|sudo |export PATH=)")
ANSWER_MAY_BE_NO = re.compile(r"^m100 doctor|^m100-lab identify")
EXAMPLES = "/usr/share/doc/m100/examples"
END = "END"
LEAST_LINES = 25  # of the guide; with fewer, the walk did not find its page
WAITS_FOR_EVER_S = 1800  # the limit is for a command that waits for a person, not for a slow one
PLANTED = """```
m100 probe --port /dev/ttyUSB0
m100 probe --prot /dev/ttyUSB0
m100-lab logs no_such_file.ulg
cp no_such_file.toml .
```
m100 this is prose
"""


def lines_of(page):
    """(number, line) of the code blocks; a here-document counts as one line, comments are skipped."""
    inside, block = False, []
    for number, line in enumerate(page.splitlines(), 1):
        if line.startswith("```"):
            inside = not inside
        elif inside and block:
            block[1].append(line)
            if line == END:
                yield block[0], "\n".join(block[1])
                block = []
        elif inside and line.endswith(f"<<'{END}'"):
            block = [number, [line]]
        elif inside and line.strip() and not line.startswith("#"):
            yield number, line


class Walk:
    def __init__(self, m100, lab, source, table, work):
        self.lab, self.work = lab, work
        self.here = work / "home"
        self.here.mkdir()
        programs = work / "bin"
        programs.mkdir()
        for name, path in (("m100", m100), ("m100-lab", lab)):
            (programs / name).symlink_to(path)
        self.environment = os.environ | {"PATH": f"{programs}:{os.environ['PATH']}"}
        self.background, self.count = None, 0
        self.said = ""
        (work / "examples").mkdir()
        for path, name in ((source / "firmware/mpc/generated/vehicle.toml", "vehicle.toml"),
                           (source / "firmware/companion/files/example/flight.toml", "flight.toml"), (table, "gains.bin")):
            shutil.copy(path, work / "examples" / name)

    def put_in_place(self, line, world):
        if not line.startswith("m100 doctor"):  # it examines the ports of this machine
            line = line.replace("/dev/ttyUSB0", f"sim:{world}").replace("/dev/ttyUSB1", f"sim:{world}.pose")
        line = line.replace(EXAMPLES, str(self.work / "examples")).replace("/tmp/m100", str(self.work / "m100"))
        if "FROM:TO" in line:
            flown = json.loads((self.here / "excite.json").read_text())["excitation"]
            line = line.replace("FROM:TO", f"{flown['from_s']}:{flown['to_s']}")
        return line

    def autopilot(self, line, world):
        """The emulated aircraft for one command, where the guide does not start its own autopilot."""
        arguments = [self.lab, "autopilot", "--sim", str(world), "--seed", "7"]
        if line.startswith("m100 record"):
            arguments += ["--rc-mode", "P", "--script", str(self.work / "pilot.txt")]
        return self.started(subprocess.Popen(arguments, stdout=subprocess.DEVNULL), world)

    @staticmethod
    def started(process, world):
        """Waits until its two ports exist: from then on it hears a program that opens them, at any time."""
        while not all(pathlib.Path(f"{world}{port}").exists() for port in ("", ".pose")) and process.poll() is None:
            time.sleep(0.01)
        return process

    @staticmethod
    def end(process):
        if process is not None:
            process.terminate()
            process.wait()

    def end_background(self):
        self.end(self.background)
        self.background = None

    def run(self, line):
        """@returns the exit code and the output, or None if the line is not run here."""
        if NOT_HERE.match(line):
            return None
        self.count += 1
        world = self.work / f"w{self.count}"
        typed = self.put_in_place(line, world)
        if line.startswith("cd "):
            self.here = (self.here / typed[3:].strip()).resolve()
            return (0, "") if self.here.is_dir() else (1, "no such folder")
        if line.startswith("m100-lab autopilot"):
            self.end_background()
            self.background = self.started(subprocess.Popen(typed.removesuffix("&").split(), cwd=self.here,
                                                            env=self.environment, stdout=subprocess.DEVNULL),
                                           self.work / "m100")
            return (0, "") if self.background.poll() is None else (self.background.returncode, "ended at once")
        aircraft = self.autopilot(line, world) if line.startswith("m100 ") and str(world) in typed else None
        try:
            run = subprocess.run(["timeout", str(WAITS_FOR_EVER_S), "bash", "-c", typed], cwd=self.here,
                                 env=self.environment, capture_output=True, text=True, stdin=subprocess.DEVNULL,
                                 check=False)
        finally:
            self.end(aircraft)
        return run.returncode, run.stdout + run.stderr

    def offences(self, page):
        for _, line in lines_of(page):  # the pilot script at the guide's end is for the recording in its middle
            if line.startswith("cat > pilot.txt"):
                subprocess.run(["bash", "-c", line], cwd=self.work, check=True)
        for number, line in lines_of(page):
            result = self.run(line)
            if result is None:
                continue
            code, said = result
            self.said += f"\n$ {line}\n{said}[{code}]\n"
            (self.work / "walk.txt").write_text(self.said)
            if code != 0 and not (code == 1 and ANSWER_MAY_BE_NO.match(line)):
                yield f"{number}: '{line}' ended with {code}: {said[-400:]}"
        self.end_background()


def self_test(paths):
    """Checks that only the first of the planted lines works, and that prose is not run."""
    with tempfile.TemporaryDirectory() as folder:
        walk = Walk(*paths, pathlib.Path(folder))
        found = list(walk.offences(PLANTED))
    as_planted = walk.count == 4 and [one.split(":")[0] for one in found] == ["3", "4", "5"]
    return [] if as_planted else [f"self-test: of {walk.count} lines these are offences: {found}"]


def main():
    paths = [pathlib.Path(name).resolve() for name in sys.argv[1:5]]
    found = self_test(paths)
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(sys.argv[5] if len(sys.argv) > 5 else folder).resolve()
        work.mkdir(exist_ok=True)
        walk = Walk(*paths, work)
        found += walk.offences((paths[2] / "firmware/companion/guide/README.md").read_text())
        for one in found:
            print(one)
        print(f"{walk.count} lines of the guide were run, {len(found)} offences")
    return 1 if found or walk.count < LEAST_LINES else 0


if __name__ == "__main__":
    sys.exit(main())
