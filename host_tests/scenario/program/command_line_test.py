#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks the command lines of both programs: --version, an example with existing options in every --help, refusal of
malformed numbers and lists, --json for every command that reports, and one printable line for every error.

Usage: command_line_test.py M100 LAB VEHICLE TABLE FLIGHT. Prints one line per offence.
"""
import json
import pathlib
import re
import shlex
import stat
import subprocess
import sys
import tempfile

from file_use import subcommands

NO_REPORT = {"m100-lab autopilot", "m100-lab frames decode", "m100-lab frames encode", "m100-lab mpc solve",
             "m100-lab reference", "m100-lab report", "m100-lab evening", "m100-lab demo"}  # their output is the result itself


def run(program, *words):
    done = subprocess.run([program, *map(str, words)], capture_output=True, check=False, stdin=subprocess.DEVNULL,
                          timeout=300)
    return done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")


def help_offences(name, program):
    code, out, _ = run(program, "--version")
    if code != 0 or not re.match(rf"{name} \d+\.\d+\.\d+.*\ntables: ", out):
        yield f"{name} --version: exit code {code}: {out.strip()}"
    for words in subcommands(program):
        command = " ".join((name, *words))
        _, text, _ = run(program, *words, "--help")
        options = set(re.findall(r"^\s+(?:-\w,)?(--[\w-]+)", text, re.M))
        # A positional that has an option's name too is listed as "log,--log".
        options |= set(re.findall(r",(--[\w-]+)", text))
        example = re.search(r"^Example: (.*)$", text, re.M)
        if not example or not example[1].startswith(command):
            yield f"{command} --help: has no example of {command}"
            continue
        unknown = {word.split("=")[0] for word in shlex.split(example[1]) if word.startswith("--")} - options
        if unknown:
            yield f"{command} --help: the command does not know {unknown} of its example"
        if command not in NO_REPORT and "--json" not in options:
            yield f"{command}: reports something and has no --json"


def one_line(program, words, says):
    """The command must be refused with one line, without control characters, that contains `says`."""
    code, out, err = run(program, *words)
    plain = all(c == "\n" or c.isprintable() for c in err)
    if code != 2 or err.count("\n") != 1 or not plain or says not in err:
        yield f"{pathlib.Path(program).name} {words}: exit code {code}, {err!r}, wanted {says!r} (stdout {out[:60]!r})"


def file_of(folder, name, text, mode=0o600):
    path = folder / name
    path.write_text(text)
    path.chmod(mode)
    return path


def escape_offences(m100, folder, vehicle, table):
    """Text from a file or a command line must not reach the terminal as a control character."""
    bad = "no\x1b[31mpe"
    spoilt = file_of(folder, "f.toml", '"a\\u001b[31mb" = 1\n')
    course = file_of(folder, "c.course", "st\x1bep 1\n")
    check = ["check", "--vehicle", vehicle, "--gains", table]
    cases = [[bad], ["replay", bad], ["check", "--vehicle", bad, "--gains", table], ["fly", "--port", bad],
             [*check, "--flight", spoilt], [*check, "--course", course], ["probe", "--json", f"/nope/{bad}"]]
    for words in cases:
        yield from one_line(m100, words, "\\x1b")
    code, out, err = run(m100, "probe", "--port", bad, "--seconds", "0.1")
    if "\x1b" in out + err:
        yield f"m100 probe --port: exit code {code}: {out + err!r}"


def key_offences(programs, folder):
    good = "0123456789abcdef" * 4
    keys = {"two.key": (f"{good}\n{good}\n", ":2: something follows the key"),
            "word.key": (f"{good} spare\n", ":1: something follows the key"),
            "short.key": ("0123\n", ":1: the key needs 64")}
    empty = file_of(folder, "empty.bin", "")
    for name, (text, says) in keys.items():
        path = file_of(folder, name, text)
        yield from one_line(programs["m100"], ["handshake", "--port", "/nope", "--key-file", path], name + says)
        yield from one_line(programs["m100-lab"], ["frames", "decode", empty, "--key-file", path], name + says)
    good_key = file_of(folder, "good.key", good + "\n")
    if run(programs["m100-lab"], "frames", "decode", empty, "--key-file", good_key)[0] != 0:
        yield "a file that holds only a key is refused"
    assert stat.S_IMODE(good_key.stat().st_mode) == 0o600


def option_offences(lab, m100, folder):
    log = file_of(folder, "l.csv", "t_s,rc_roll,roll\n" + "".join(f"{k / 100:.2f},1024,0\n" for k in range(600)))
    columns = file_of(folder, "c.toml", 'time = "t_s"\n[signals]\nstick_roll = "rc_roll"\nattitude_roll = "roll"\n')
    lacking = file_of(folder, "m.toml", 'time = "t_s"\n[signals]\nstick_roll = "rc_roll"\nattitude_roll = "phi"\n')
    identify = ["identify", "--log", log, "--columns", columns, "--axis", "roll", "--declare", "first_order", "--split",
                "alternate:3"]
    inject = ["inject", "--log", log, "--columns", columns, "--axis", "roll", "--train", "0:5", "--out",
              folder / "o.csv", "--effect"]
    script = file_of(folder, "s.txt", "1 lose_acks 1.5\n")
    world = file_of(folder, "w.toml", "# as measured\n")
    encrypted = file_of(folder, "e.jsonl", '{"session":0,"is_ack":false,"encrypted":true,"seq":1,"cmd_set":0,'
                                           '"cmd_id":0,"payload_hex":"00"}\n')
    part = file_of(folder, "a.json", "{}")
    for words, says in [
            ([*identify, "--noise-floor", "nan"], "--noise-floor"), ([*identify, "--noise-floor", "-1"], "--noise-floor"),
            ([*identify, "--refits", "-1"], "--refits"), (["campaign", world, "--seed", "-3"], "--seed"),
            (["experiments", "--seed", "-3"], "--seed"), (["loop", "--plant", world, "--out", "x", "--seed", "-1"], "--seed"),
            ([*identify, "--validate-columns", columns], "--validate-columns"),
            (["campaign", "--merge", part, part, "--seed", "4"], "--seed"),
            (["campaign", "--merge", part, part, "--flights", "3"], "--flights"),
            ([*inject, "dead_zone=-5"], "dead_zone=-5"), ([*inject, "dead_zone=1e9"], "dead_zone=1e9"),
            ([*inject, "stick_curve=0"], "stick_curve=0"), ([*inject, "steady_wind=1"], "added to roll"),
            (["excite", "--fence", "-1"], "--fence"), (["excite", "--fence", "nan"], "--fence"),
            (["autopilot", "--pty", folder / "pty", "--duration", "0.01", "--script", script], "s.txt:1: 'lose_acks'"),
            (["experiments", "--rate", "1000"], "--rate"),
            (["convert", log, "--columns", lacking, "--out", folder / "o.csv"], "m.toml:4: 'attitude_roll'"),
            (["frames", "encode", encrypted], "e.jsonl:1: 'key_hex'"),
            (["identify", "--foo"], "--foo"), (["mpc", "solve", "--foo"], "--foo")]:
        yield from one_line(lab, words, says)
        code, _, err = run(lab, *words)
        if len(err) > 400:
            yield f"{words}: a line of {len(err)} characters (exit code {code})"
    yield from one_line(m100, ["fly", "--foo"], "--foo")


def number_offences(program):
    """Every numeric option of every subcommand refuses texts that are no number, or that could be misread."""
    odd = {"UINT": ["nan", "0x10", "010", "1e1", "99999999999999999999", "-1", "1.5"], "INT": ["0x10", "010", "1.5", "9" * 20],
           "FLOAT": ["nan", "inf", "-inf", "0x10", "1e400", " 5", "5s"]}
    for words in subcommands(program):
        for option, kind in re.findall(r"^\s+(?:-\w,)?(--[\w-]+)\S* (UINT|INT|FLOAT)", run(program, *words, "--help")[1], re.M):
            for number in odd[kind]:
                yield from one_line(program, [*words, f"{option}={number}"], option)


def list_offences(lab, folder):
    """A list with an empty word is refused: a word was forgotten, or a shell variable was not set."""
    log = file_of(folder, "e.csv", "t_s,rc_roll,roll\n" + "".join(f"{k / 100:.2f},1024,0\n" for k in range(600)))
    columns = file_of(folder, "e.toml", 'time = "t_s"\n[signals]\nstick_roll = "rc_roll"\nattitude_roll = "roll"\n')
    world = file_of(folder, "v.toml", "# as measured\n")
    of_log = ["--log", log, "--columns", columns, "--axis", "roll"]
    identify = ["identify", *of_log, "--declare", "first_order"]
    inject = ["inject", *of_log, "--out", folder / "eo.csv"]
    for words, option, good in [
            (["excite"], "--axis", "roll"), (["campaign", world, "--flights", 1], "--tasks", "hover"),
            (["loop", "--plant", world, "--out", folder / "eo.toml"], "--tasks", "hover"),
            (["identify", *of_log, "--split", "alternate:3"], "--declare", "first_order"),
            ([*identify, "--validate", "3:5"], "--train", "0:2"), ([*identify, "--train", "0:2"], "--validate", "3:5"),
            ([*identify, "--split", "alternate:3"], "--within", "0:5"),
            ([*inject, "--train", "0:5"], "--effect", "dead_zone=20"),
            ([*inject, "--train", "0:5", "--effect", "dead_zone=20"], "--declare", "second_order")]:
        for text in (f"{good},", f",{good}", f"{good},,{good}", ","):
            yield from one_line(lab, [*words, option, text], option)
    for words, says in [(["excite", "--axis", "roll,bank"], "'bank'"), (["excite", "--axis", "roll,roll"], "each once"),
                        ([*inject, "--train", "0:5", "--effect", "dead_zone=20,dead_zone=30"], "is named twice"),
                        ([*inject, "--train", "0:5:", "--effect", "dead_zone=20"], "FROM:TO"),
                        ([*inject, "--train", "0:5", "--effect", "dead_zone=20="], "NAME=VALUE"),
                        ([*inject, "--train", "0:5", "--effect", "dead_zone=0x14"], "not a number"),
                        ([*identify, "--split", "alternate:3:"], "alternate:SECONDS"),
                        ([*identify, "--split", "alternate:0x3"], "not a number")]:
        code, out, _ = run(lab, *words)
        yield from one_line(lab, words, says)
        if out:
            yield f"{words}: begins its work before it refuses (exit code {code}): {out[:60]!r}"


def merge_offences(lab, folder):
    """A malformed value in a part of a campaign is refused with the file's name; a world's name is escaped."""
    world = file_of(folder, "wi\x1b[31mnd.toml", "# as measured\n")
    whole = folder / "whole.json"
    flown = ["campaign", world, "--flights", 1, "--tasks", "hover", "--json", whole]
    code, out, err = run(lab, *flown, "--report", folder / "pages")
    if code != 0 or not all(c == "\n" or c.isprintable() for c in out + err):
        yield f"{flown}: exit code {code}, {out + err!r}"
    sound = json.loads(whole.read_text())
    if run(lab, "campaign", "--merge", whole)[0] != 0:
        yield "m100-lab campaign --merge: refuses a complete campaign"
    flight = {"number", "world", "task", "seed", "stayed", "coasted", "released", "fence_breach", "oscillating",
              "worst_tilt_deg", "pose_rms_m", "tilt_rms_deg", "command_deg_s", "nees_sum", "nees_count", "at_s", "why"}
    places = [("flown", 0, key) for key in sorted(flight)]
    places += [("campaign", key) for key in ("worlds", "tasks", "flights")] + [("campaign", "worlds", 0, "name"), ("flown", 0)]
    for place in places:
        for wrong in (None, -1, 1e300, "x", [], {}):
            spoilt = json.loads(json.dumps(sound))
            inner = spoilt
            for step in place[:-1]:
                inner = inner[step]
            was = inner[place[-1]]
            counts = place[-1] in ("number", "seed", "flights")
            if (type(wrong) in (int, float) and type(was) in (int, float) and not counts) or type(wrong) is type(was) is str:
                continue  # another number, another text
            inner[place[-1]] = wrong
            part = file_of(folder, "spoilt.json", json.dumps(spoilt))
            yield from one_line(lab, ["campaign", "--merge", part], "spoilt.json")


def json_file_offences(lab, folder):
    """A result that is nested too deep, has too many names, or has a value of a wrong type is refused at once, with its
    name: copying deep nesting would overflow the stack, and a lookup in ordered names takes linear time."""
    page = file_of(folder, "p.html", "<html><body><h1>x</h1></body></html>")
    log = file_of(folder, "f.csv", "t_s,rc_roll,roll\n" + "".join(f"{k / 100:.2f},1024,0\n" for k in range(600)))
    columns = file_of(folder, "f.toml", 'time = "t_s"\n[signals]\nstick_roll = "rc_roll"\nattitude_roll = "roll"\n')
    deep = "[" * 400000 + "]" * 400000
    many = "{" + ",".join(f'"k{k}":1' for k in range(200000)) + "}"
    texts = [deep, f'{{"a":{deep},"b":1,"c":1,"campaign":2,"flown":[]}}', many, f'{{"campaign":1,"flown":[{many}]}}', "[" * 400000,
             '{"forecast":' + many + "}"]
    kinds = {"--identified": '{"axis":1}', "--experiments": '{"hover":{"calm":{"compared":"x"}}}', "--margins": '{"flown":[1]}'}
    for text in texts:
        spoilt = file_of(folder, "spoilt.json", text)
        for words in [["campaign", "--merge", spoilt], ["frames", "encode", spoilt], ["mpc", "solve", spoilt],
                      ["identify", "--log", log, "--columns", columns, "--axis", "roll", "--declare", "first_order",
                       "--split", "alternate:3", "--forecast", spoilt],
                      *(["report", page, "--out", folder / "o.html", option, spoilt] for option in kinds)]:
            yield from one_line(lab, words, "spoilt.json")
    for option, text in kinds.items():
        spoilt = file_of(folder, "spoilt.json", text)
        yield from one_line(lab, ["report", page, "--out", folder / "o.html", option, spoilt], "spoilt.json: is not a result")
    for text in ('{"axis":"roll","forecast":[{"effect":1}]}', '{"axis":"roll","forecast":[{"enough":null}]}',
                 '{"axis":[],"forecast":[]}', '{"axis":"roll","forecast":[1]}'):
        spoilt = file_of(folder, "spoilt.json", text)
        yield from one_line(lab, ["identify", "--log", log, "--columns", columns, "--axis", "roll", "--declare", "first_order",
                                  "--split", "alternate:3", "--forecast", spoilt], "spoilt.json: is not a forecast")


def json_offences(m100, folder, vehicle, table, flight):
    """The JSON report of m100 check; results_test.py tests that of replay, which needs a log."""
    answer = folder / "check.json"
    code, out, err = run(m100, "check", "--vehicle", vehicle, "--gains", table, "--flight", flight, "--json", answer)
    read = json.loads(answer.read_text()) if code == 0 else {}
    if not read.get("agrees") or len(read["findings"]) != out.count("\n"):
        yield f"m100 check --json: exit code {code}, {read}, {err}"


def lab_json_offences(lab, folder):
    log = file_of(folder, "j.csv", "t_s,rc_roll,roll\n" + "".join(
        f"{k / 100:.2f},{1024 + 100 * (k // 50 % 2)},{0.01 * (k // 60 % 2)}\n" for k in range(1200)))
    columns = file_of(folder, "j.toml", 'time = "t_s"\n[signals]\nstick_roll = { column = "rc_roll", offset = -1024 }\n'
                                        'attitude_roll = "roll"\n')
    answer = folder / "j.json"
    code, _, err = run(lab, "convert", log, "--columns", columns, "--out", folder / "jo.csv", "--json", answer)
    read = json.loads(answer.read_text()) if code == 0 else {}
    if read.get("signals") != ["stick_roll", "attitude_roll"] or read["samples"] < 1000:
        yield f"m100-lab convert --json: exit code {code}, {read}, {err}"
    page, whole = file_of(folder, "p.html", "<html><title>p</title><body></body></html>"), folder / "o.html"
    margins = {"flown": {"f": {"x": {"movement": {"stable": True, "ranges": {"gain": [0.8, 1.2]}}, "corners": {"movement": {"stable": False}}}}}, "yaw": {"stable": True}}
    code, _, err = run(lab, "report", page, "--out", whole, "--margins", file_of(folder, "m.json", json.dumps(margins)))
    if code != 0 or "1 goal was not reached: a stable loop: flown, f, x, corners, movement." not in whole.read_text():
        yield f"m100-lab report --margins: exit code {code}, {err}"
    blind = file_of(folder, "blind.toml", "[pose]\ndropout_per_s = 100.0\n")
    code, _, err = run(lab, "experiments", "--plant", blind)
    if code != 1 or "never obtained control" not in err:
        yield f"m100-lab experiments without a flight: exit code {code}, {err}"
    code, _, err = run(lab, "convert", log, "--list", "--json", answer)
    if code != 0 or json.loads(answer.read_text())["columns"] != ["t_s", "rc_roll", "roll"]:
        yield f"m100-lab convert --list --json: exit code {code}, {err}"
    code, _, err = run(lab, "inject", "--log", log, "--columns", columns, "--axis", "roll", "--declare", "first_order",
                       "--train", "0:11", "--effect", "dead_zone=20", "--out", folder / "ji.csv", "--json", answer)
    read = json.loads(answer.read_text()) if code == 0 else {}
    if read.get("effects") != {"dead_zone": 20.0} or "time_constant_s" not in read["declared"]["parameters"]:
        yield f"m100-lab inject --json: exit code {code}, {read}, {err}"


def main():
    programs = {"m100": sys.argv[1], "m100-lab": sys.argv[2]}
    vehicle, table, flight = sys.argv[3:6]
    found = [one for name, program in programs.items() for one in help_offences(name, program)]
    found += [one for name, program in programs.items() for one in number_offences(program)]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        found += escape_offences(programs["m100"], folder, vehicle, table)
        found += key_offences(programs, folder)
        found += option_offences(programs["m100-lab"], programs["m100"], folder)
        found += list_offences(programs["m100-lab"], folder)
        found += merge_offences(programs["m100-lab"], folder)
        found += json_file_offences(programs["m100-lab"], folder)
        found += json_offences(programs["m100"], folder, vehicle, table, flight)
        found += lab_json_offences(programs["m100-lab"], folder)
    for one in found:
        print(one)
    print(f"{len(found)} offences")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
