#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs the service of the package as its unit file says, with a stand-in for the service manager.

Usage: service_test.py M100 LAB UNIT ENVIRONMENT VEHICLE TABLE FLIGHT

The stand-in reads the unit, starts the command of ExecStart, and listens on $NOTIFY_SOCKET. Like the real manager it
ends a main process that is silent for WatchdogSec, and restarts it. Checks: the service reports that it is ready and
sends its heartbeat; it requests control only on SIGUSR1; when it hangs in flight, control goes back although only the
main process is ended; after a restart it requests nothing; a stop gives control back; if the second process is killed or
stopped too, ExecStopPost gives control back. The test waits for events, and a
failure counts only if the machine did not stall (real_time.py).
"""
import json
import os
import pathlib
import re
import shlex
import signal
import socket
import subprocess
import sys
import tempfile
import time

import real_time

PATIENCE_S = 240.0


def expect(holds, what):
    if not holds:
        raise SystemExit(f"FAILED: {what}")


def wait_for(happened, what):
    end = time.monotonic() + PATIENCE_S
    while not happened():
        expect(time.monotonic() < end, f"{what}: never happened")
        time.sleep(0.02)


class Autopilot:
    """The emulated autopilot on a pseudo-terminal, and its events."""

    def __init__(self, lab, work, port="port", pose="pose"):
        self.port, self.pose, self.events = work / port, work / pose, work / "events.json"
        self.process = subprocess.Popen([lab, "autopilot", "--pty", self.port, "--pose-pty", self.pose, "--events",
                                         self.events, "--duration", "36000"], stdout=subprocess.DEVNULL)
        wait_for(lambda: self.port.exists() and self.pose.exists(), "the start of the autopilot")

    def count(self, name, what="did"):
        """-> number of events with this name."""
        seen = 0
        for line in self.events.read_text().splitlines() if self.events.exists() else []:
            try:
                event = json.loads(line)
            except json.JSONDecodeError:  # the line is still being written
                continue
            seen += event.get("name") == name and event.get("what") == what
        return seen

    def asked(self):
        return self.count("obtain_control", "received")

    def is_ours(self):
        return self.count("obtained") > self.count("released")


class Manager:
    """Does for one unit what the service manager does."""

    def __init__(self, unit, environment, m100, work):
        lines = unit.read_text().split("[Service]", 1)[1].splitlines()
        self.unit = dict(line.split("=", 1) for line in lines if "=" in line and not line.startswith("#"))
        self.m100 = m100
        self.listener = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.listener.bind(str(work / "notify"))
        self.environment = environment | {"NOTIFY_SOCKET": str(work / "notify"), "STATE_DIRECTORY": str(work),
                                          "PATH": os.environ["PATH"]}
        self.watchdog_s = float(self.unit["WatchdogSec"])

    def words(self, line):
        """-> the command of a line, with the manager's escapes and variables replaced, and with our program."""
        line = line.removeprefix("+").replace("%%", "%").replace("/usr/bin/m100", shlex.quote(self.m100))
        line = re.sub(r"\$\{(\w+)\}", lambda found: shlex.quote(self.environment[found[1]]), line)
        return [word.replace("$$", "$") for word in shlex.split(line)]

    def start(self):
        check = subprocess.run(self.words(self.unit["ExecStartPre"]), env=self.environment, capture_output=True, text=True,
                               check=False)
        expect(check.returncode == 0, f"ExecStartPre: {check.stderr}")
        end = time.monotonic() + PATIENCE_S
        said = ""
        while not said and time.monotonic() < end:  # as RestartSec does: the port may still be in use
            self.main = subprocess.Popen(self.words(self.unit["ExecStart"]), env=self.environment, stdin=subprocess.DEVNULL,
                                         stdout=subprocess.DEVNULL)
            said = self.heard(PATIENCE_S, lambda: self.main.poll() is None)
            time.sleep(0.0 if said else 1.0)
        expect("READY=1" in said, f"the service reports that it is ready: {said}")
        expect(f"WATCHDOG_USEC={int(self.watchdog_s * 1e6)}" in said, f"the service reports the unit's WatchdogSec: {said}")

    def ends_with(self, result):
        """Runs ExecStopPost, as root does."""
        subprocess.run(self.words(self.unit["ExecStopPost"]), env=self.environment | {"SERVICE_RESULT": result},
                       stdout=subprocess.DEVNULL, check=False)

    def backup_process(self):
        """-> the second process of the flight."""
        children = pathlib.Path(f"/proc/{self.main.pid}/task/{self.main.pid}/children").read_text().split()
        found = [int(child) for child in children if "m100-backup" in pathlib.Path(f"/proc/{child}/comm").read_text()]
        expect(len(found) == 1, f"the flight has one second process: {children}")
        return found[0]

    def heard(self, within_s, as_long_as=lambda: True):
        """-> the next message of the service; empty if there is none in that time."""
        end = time.monotonic() + within_s
        while time.monotonic() < end and as_long_as():
            self.listener.settimeout(min(0.1, within_s))
            try:
                return self.listener.recv(4096).decode()
            except TimeoutError:
                continue
        return ""

    def lives(self, words):
        for _ in range(words):
            expect(self.heard(PATIENCE_S) == "WATCHDOG=1", "the service sends its heartbeat")

    def end_what_hangs(self):
        while self.heard(self.watchdog_s):
            pass  # messages from before the hang
        self.main.send_signal(signal.SIGABRT)  # to the main process only: KillMode=process
        self.main.send_signal(signal.SIGCONT)
        expect(self.main.wait(PATIENCE_S) != 0, "a hang ends as a failure, so that Restart=on-failure restarts the service")


def flown(manager, autopilot):
    manager.start()
    manager.lives(20)
    expect(autopilot.asked() == 0, "the service does not request control by itself")
    take_control(manager, autopilot)
    manager.main.send_signal(signal.SIGSTOP)
    manager.end_what_hangs()
    wait_for(lambda: not autopilot.is_ours(), "control goes back after the watchdog")
    asked = autopilot.asked()
    manager.start()
    manager.lives(20)
    expect(autopilot.asked() == asked, "the restarted service does not request control")
    take_control(manager, autopilot)
    manager.main.terminate()
    wait_for(lambda: not autopilot.is_ours(), "systemctl stop gives control back")
    code = manager.main.wait(PATIENCE_S)
    expect(code in (0, 1), f"the service ends by itself with 0 or 1, not {code}")  # 1: handed over to the pilot, on a busy machine
    for how in (signal.SIGKILL, signal.SIGSTOP):
        both_are_gone(manager, autopilot, how)


def both_are_gone(manager, autopilot, how):
    """Nothing but the manager is left: what it starts after the end gives control back."""
    while manager.heard(0.2):
        pass  # messages of the program before
    manager.start()
    take_control(manager, autopilot)
    backup_process = manager.backup_process()
    os.kill(backup_process, how)
    os.kill(manager.main.pid, how)
    manager.main.kill()  # what the watchdog does to a main process that is stopped
    manager.main.wait(PATIENCE_S)
    expect(autopilot.is_ours(), f"nobody has given control back after {how.name}")
    manager.ends_with("watchdog")
    wait_for(lambda: not autopilot.is_ours(), f"the manager gives control back when both processes got {how.name}")
    if how == signal.SIGSTOP:
        os.kill(backup_process, signal.SIGKILL)


def take_control(manager, autopilot):
    """Sends the operator's order, SIGUSR1. The service refuses it if it comes too early, so it is repeated."""
    for _ in range(60):
        manager.main.send_signal(signal.SIGUSR1)
        for _ in range(250):
            if autopilot.is_ours():
                return
            expect(manager.main.poll() is None, "the service keeps running until the order")
            time.sleep(0.02)
    expect(False, "SIGUSR1 takes control")


def in_a_place_of_its_own(m100, lab, unit, environment, vehicle, table, flight):
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        autopilot = Autopilot(lab, work)
        given = dict(line.split("=", 1) for line in pathlib.Path(environment).read_text().splitlines()
                     if line and not line.startswith("#"))
        given |= {"M100_PORT": str(autopilot.port), "M100_POSE_PORT": str(autopilot.pose), "M100_VEHICLE": vehicle,
                  "M100_GAINS": table, "M100_FLIGHT": flight}
        manager = Manager(pathlib.Path(unit), given, m100, work)
        try:
            flown(manager, autopilot)
        finally:
            if getattr(manager, "main", None) and manager.main.poll() is None:
                manager.main.kill()
            autopilot.process.terminate()
            autopilot.process.wait()


def main():
    code = real_time.judge_in_real_time(lambda: in_a_place_of_its_own(*sys.argv[1:]))
    if code == 0:
        print("the service: ready, sends its heartbeat, restarts without authority, is ended by its watchdog")
    return code


if __name__ == "__main__":
    sys.exit(main())
