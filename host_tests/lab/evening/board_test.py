#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""m100-lab evening --board against an ssh server on this machine, used from a terminal as a person does.

Usage: board_test.py M100 LAB. Exit code 77: this machine has no ssh server, or refuses its temporary key.

The board is this machine: its program m100 is the real one for `probe`; for `record` a script stands in for it, which notes
the keys that arrive and ends at Ctrl-C.
"""
import json
import os
import pathlib
import pty
import select
import shutil
import signal
import socket
import socket
import subprocess
import sys
import tempfile
import time

SSHD = "/usr/sbin/sshd"
WAITS_FOR_EVER_S = 120
STAND_IN = """#!/bin/sh
[ "$1" = record ] || exec '{m100}' "$@"
[ -t 0 ] && [ -t 1 ] || {{ echo 'no terminal'; exit 3; }}
stop() {{ printf '{{"recorded": false, "trouble": "key %s, then stopped"}}' "$key" >record.json; echo log >hand.ulg; exit 1; }}
trap stop INT
echo 'recording'
read -r key
echo "heard $key"
while :; do sleep 0.05; done
"""


def expect(holds, what):
    if not holds:
        raise SystemExit(f"FAILED: {what}")


def skip(why):
    print(f"board: test skipped: {why}")
    raise SystemExit(77)


class Server:
    """An ssh server with a temporary key, whose commands run in the folder `home`."""

    def __init__(self, work, m100):
        self.work, self.home = work, work / "home"
        self.home.mkdir()
        (self.home / "m100").write_text(STAND_IN.format(m100=m100))
        (self.home / "m100").chmod(0o755)
        for name in ("host", "key"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(work / name)], check=True)
        shutil.copy(work / "key.pub", work / "authorized")
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        (work / "sshd_config").write_text(
            f"Port {self.port}\nListenAddress 127.0.0.1\nHostKey {work}/host\nAuthorizedKeysFile {work}/authorized\n"
            f"PidFile none\nStrictModes no\nUsePAM no\nPasswordAuthentication no\nPermitRootLogin yes\n"
            f"SetEnv PATH={self.home}:/usr/bin:/bin\n"
            f"ForceCommand cd {self.home} && exec sh -c \"$SSH_ORIGINAL_COMMAND\"\n")
        (work / "ssh_config").write_text(
            f"IdentityFile {work}/key\nIdentitiesOnly yes\nBatchMode yes\nStrictHostKeyChecking no\n"
            f"UserKnownHostsFile {work}/known\nLogLevel ERROR\n")
        (work / "bin").mkdir()
        (work / "bin/ssh").write_text(f"#!/bin/sh\nexec {shutil.which('ssh')} -F {work}/ssh_config \"$@\"\n")
        (work / "bin/ssh").chmod(0o755)
        self.environment = os.environ | {"PATH": f"{work}/bin:{os.environ['PATH']}"}
        if os.geteuid() == 0:
            pathlib.Path("/run/sshd").mkdir(exist_ok=True)
        self.start()
        user = subprocess.run(["id", "-un"], capture_output=True, text=True, check=True).stdout.strip()
        self.destination = f"ssh://{user}@127.0.0.1:{self.port}"
        tried = subprocess.run(["ssh", self.destination, "true"], env=self.environment, capture_output=True, text=True, check=False)
        if tried.returncode != 0:
            self.stop()
            skip(f"the ssh server refuses its key: {tried.stderr.strip()}")

    def start(self):
        self.process = subprocess.Popen([SSHD, "-D", "-f", str(self.work / "sshd_config"), "-E", str(self.work / "sshd.log")])
        for _ in range(200):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            time.sleep(0.05)
        skip("the ssh server does not start: " + (self.work / "sshd.log").read_text())

    def stop(self):
        self.process.terminate()
        self.process.wait()


class Terminal:
    """m100-lab evening on a terminal of its own."""

    def __init__(self, argv, environment):
        self.said, self.at = "", 0
        self.process, self.terminal = pty.fork()
        if self.process == 0:
            os.execvpe(argv[0], argv, environment)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self.terminal)  # hangs up, if the evening still runs

    def read(self, until):
        """Reads on until the text stands behind what was read before."""
        end = time.monotonic() + WAITS_FOR_EVER_S
        while until not in self.said[self.at:]:
            expect(time.monotonic() < end and self.more(), f"'{until}' is said; instead: {self.said}")
        self.at = self.said.index(until, self.at) + len(until)

    def more(self):
        if not select.select([self.terminal], [], [], 1.0)[0]:
            return True
        try:
            data = os.read(self.terminal, 65536)
        except OSError:
            return False
        self.said += data.decode(errors="replace")
        return bool(data)

    def type(self, keys):
        os.write(self.terminal, keys.encode())

    def ended(self):
        while self.more():
            pass
        _, status = os.waitpid(self.process, 0)
        return os.waitstatus_to_exitcode(status)


class Autopilot(subprocess.Popen):
    """The emulated autopilot; it ends with the test."""

    def __init__(self, lab, world):
        super().__init__([lab, "autopilot", "--sim", str(world)], stdout=subprocess.DEVNULL)

    def __exit__(self, *failed):
        self.terminate()
        super().__exit__(*failed)


def uses_the_board(m100, lab, server, work):
    folder, world = work / "my M100, Flugübung", work / "world"
    by_hand = [lab, "evening", str(folder)]
    evening = [*by_hand, "--board", server.destination]
    there = server.home / "m100_evening" / folder.name
    begin = ["--port", f"sim:{world}", "--pose-port", f"sim:{world}.pose", "--m100", m100]
    with Autopilot(lab, world) as autopilot, Terminal(evening + begin, server.environment) as person:
        person.read("next: probe")
        person.read("Enter runs it on the board")
        listed = subprocess.run([*evening, "--list"], capture_output=True, text=True, check=False)
        expect(listed.returncode == 0 and "now   probe" in listed.stdout, f"--list works beside it: {listed}")
        second = subprocess.run(evening, capture_output=True, text=True, check=False)
        expect(second.returncode == 2 and "another evening works" in second.stderr, "a second evening does not")
        person.type("\n")
        person.read("probe: done")
        autopilot.terminate()
        expect((folder / "probe.json").is_file() and not (there / "probe.json").exists(), "the result is here, no more there")
        person.read("next: record")
        person.type("\n")
        person.read("recording")
        person.type("q7\n")
        person.read("heard q7")
        person.type("\x03")
        person.read("record: NOT PASSED: nothing useful was recorded: key q7, then stopped")
        expect(person.ended() == 1, "the evening ends as when a check fails")
    expect((folder / "not_passed/record.1/hand.ulg").read_text() == "log\n", "the log of the stopped run came back")
    fetches_what_was_left(evening, server, folder, there)
    starts_the_bridge(evening, server, folder, work)
    stops_at_the_prompt(evening, server)
    is_not_reached(by_hand, evening, server)


def fetches_what_was_left(evening, server, folder, there):
    """Files of a run whose connection was lost are brought back, not recorded again."""
    (there / "record.json").write_text(json.dumps({"recorded": False, "trouble": "left behind"}))
    (there / "hand.ulg").write_text("the log that was left")
    run = subprocess.run(evening, capture_output=True, text=True, check=False, env=server.environment, stdin=subprocess.DEVNULL)
    expect(run.returncode == 1 and "left behind" in run.stdout, f"what was left on the board is judged: {run}")
    expect((folder / "not_passed/record.2/hand.ulg").read_text() == "the log that was left", "and is here")
    (there / "hand.ulg").write_text("half a log")
    with Terminal(evening, server.environment) as person:
        person.read("Enter runs it on the board")
        person.type("\n")
        person.read("recording")
        person.type("\n")
        person.read("heard")
        person.type("\x03")
        person.read("NOT PASSED")
        person.ended()
    aside = list((there / "not_passed").iterdir())
    expect([one.read_text() for one in aside] == ["half a log"], f"half a result makes room on the board: {aside}")


def starts_the_bridge(evening, server, folder, work):
    """The bridge passes poses on while a step runs on the board, and no longer."""
    key = work / "mavlink.key"
    key.write_text("01" * 32 + "\n")
    key.chmod(0o600)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as room, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as board:
        room.bind(("127.0.0.1", 0))
        listens = room.getsockname()[1]
        room.close()  # the port is free again
        board.bind(("127.0.0.1", 0))
        board.settimeout(0.2)
        options = f"--listen udp:{listens} --to 127.0.0.1:{board.getsockname()[1]}"
        bridged = [*evening, "--pose-port", "udp:14560", "--mavlink-key", str(key), "--bridge"]
        run = subprocess.run([*bridged, "--listen tcp:1"], capture_output=True, text=True, check=False, env=server.environment,
                             input="\n")
        expect(run.returncode == 2 and "bridge.txt" in run.stderr, f"a bridge that does not start is told: {run}")
        with Terminal([*bridged, options], server.environment) as person:
            person.read("Enter runs it on the board")
            expect(not passes_on(listens, board), "no bridge runs before the step")
            person.type("\n")
            person.read("recording")
            expect(passes_on(listens, board), f"the step has its bridge: {(folder / 'bridge.txt').read_text()}")
            person.type("\n")
            person.read("heard")
            person.type("\x03")
            person.read("NOT PASSED")
            person.ended()
        expect(not passes_on(listens, board), "the bridge has ended with the step")


def passes_on(listens, board):
    """Whether a pose to the port of the room arrives at the board within two seconds."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for number in range(10):
            sender.sendto(f"{time.time() + number} 0 0 1 1 0 0 0".encode(), ("127.0.0.1", listens))
            try:
                if board.recv(2000):
                    return True
            except TimeoutError:
                pass
    return False


def stops_at_the_prompt(evening, server):
    with Terminal(evening, server.environment) as person:
        person.read("Enter runs it on the board")
        person.type("\x03")
        person.read("stopped; nothing is lost: m100-lab evening ")
        expect(person.ended() == -signal.SIGINT, "Ctrl-C ends the evening")


def is_not_reached(by_hand, evening, server):
    server.stop()
    run = subprocess.run(evening, capture_output=True, text=True, check=False, env=server.environment, stdin=subprocess.DEVNULL)
    expect(run.returncode == 2 and "not reached by ssh" in run.stderr, f"a board that does not answer is named: {run}")
    run = subprocess.run(by_hand, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)
    expect(run.returncode == 0 and "on the board, in a copy of" in run.stdout, f"without a board it is done by hand: {run}")


def main():
    m100, lab = (str(pathlib.Path(one).resolve()) for one in sys.argv[1:3])
    if not pathlib.Path(SSHD).is_file() or not shutil.which("ssh") or not shutil.which("ssh-keygen"):
        skip("no ssh server (Debian: openssh-server)")
    with tempfile.TemporaryDirectory() as name:
        work = pathlib.Path(name)
        server = Server(work, m100)
        try:
            uses_the_board(m100, lab, server, work)
        finally:
            server.stop()
    print("board: keys, Ctrl-C and files arrive")
    return 0


if __name__ == "__main__":
    sys.exit(main())
