#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Uses the installed service under systemd as a person does; service_manager.sh starts this script there.

Usage: service_managed.py LAB FILE.deb

Installs the package, copies its examples as the package's README says, and lets the emulated autopilot stand in for the
two adapters, with the access rights of the udev rules. Checks: `systemctl enable --now` returns when the service runs
its ticks, without control; only SIGUSR1 takes control; the watchdog ends a hang and systemd notices a kill; control
goes back in both cases, and the restarted service requests nothing; `systemctl stop` gives control back and ends the
service; every start writes its own log.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import time

from service_test import Autopilot, expect, wait_for


def run(*words):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    expect(done.returncode == 0, f"{' '.join(words)}: {done.returncode} {done.stdout}{done.stderr}")
    return done.stdout.strip()


def property_of(name):
    return run("systemctl", "show", "m100", "--value", "--property", name)


def main_is():
    return int(property_of("MainPID"))


def installed(package):
    run("dpkg", "--install", "--no-triggers", package)
    for file in pathlib.Path("/usr/share/doc/m100/examples").iterdir():
        shutil.copy(file, "/etc/m100")


def autopilot_with_adapters(lab):
    """Makes the links with the rights of 60-m100.rules: only group dialout may read and write."""
    autopilot = Autopilot(lab, pathlib.Path("/dev"), "m100-autopilot", "m100-pose")
    for link in (autopilot.port, autopilot.pose):
        line = link.resolve()
        shutil.chown(line, group="dialout")
        line.chmod(0o660)
    return autopilot


def lives_for(seconds):
    """Only waits. The caller then compares the main process: systemd replaces one that sends no heartbeat."""
    time.sleep(seconds)


def takes_control(autopilot):
    for _ in range(60):
        run("systemctl", "kill", "--kill-whom=main", "--signal=SIGUSR1", "m100")
        for _ in range(250):
            if autopilot.is_ours():
                return
            time.sleep(0.02)
    expect(False, "SIGUSR1 takes control")


def comes_back(autopilot, before, how):
    """After an end in flight, control is with the pilot; then a new main process runs, which requests nothing."""
    wait_for(lambda: not autopilot.is_ours(), f"control goes back after {how}")
    asked = autopilot.asked()
    wait_for(lambda: property_of("ActiveState") == "active" and main_is() not in (0, before), f"systemd restarts the service after {how}")
    lives_for(3.0)
    expect(autopilot.asked() == asked, f"the service restarted after {how} does not request control")
    expect(not autopilot.is_ours(), f"after {how} the pilot keeps control")


def used(autopilot):
    run("systemctl", "enable", "--now", "m100")
    expect(property_of("ActiveState") == "active", "systemd regards the service as active")
    first = main_is()
    lives_for(4.0)
    expect(main_is() == first and property_of("NRestarts") == "0", "the service sends its heartbeat to the watchdog")
    expect(autopilot.asked() == 0, "the service does not request control by itself")
    expect(os.stat(f"/proc/{first}").st_uid != 0, "the service does not run as root")
    print("started by `systemctl enable --now m100`: ready, alive for four times its watchdog time, without control, not root")

    takes_control(autopilot)
    os.kill(first, 19)  # SIGSTOP: a hang
    comes_back(autopilot, first, "a hang")
    expect(int(property_of("NRestarts")) >= 1, "systemd has restarted the service")
    print("hang in flight: ended by the watchdog, control back with the pilot, restarted without authority")

    takes_control(autopilot)
    second = main_is()
    os.kill(second, 9)
    comes_back(autopilot, second, "a kill")
    print("killed in flight: control back with the pilot, restarted without authority")

    takes_control(autopilot)
    run("systemctl", "stop", "m100")
    wait_for(lambda: not autopilot.is_ours(), "systemctl stop gives control back")
    expect(property_of("ActiveState") in ("inactive", "failed"), "the service has ended")  # failed: on a busy machine
    print(f"stopped in flight: control back with the pilot, ended as {property_of('ActiveState')}")


def main():
    lab, package = sys.argv[1:]
    installed(package)
    autopilot = autopilot_with_adapters(lab)
    try:
        used(autopilot)
        logs = list(pathlib.Path("/var/lib/private/m100").glob("*.ulg"))
        expect(len(logs) >= 3, f"every start writes its own log: {logs}")
        run("dpkg", "--purge", "--no-triggers", "m100")
        expect(not pathlib.Path("/usr/bin/m100").exists(), "the package is removed")
    except SystemExit:
        print(subprocess.run(["journalctl", "--no-pager", "--lines=60"], capture_output=True, text=True, check=False).stdout)
        raise
    finally:
        autopilot.process.terminate()
        autopilot.process.wait()
    print(f"{pathlib.Path('/proc/1/comm').read_text().strip()} {run('systemctl', '--version').split()[1]}: "
          f"the service starts, sends its heartbeat, restarts without authority and stops; {len(logs)} logs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
