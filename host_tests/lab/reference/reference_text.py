#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes the words of the reference pages as a C++ source, which m100-lab contains (`m100-lab reference`).

Usage: reference_text.py ROOT OUT. The words stand in meanings.toml. The tables that the program does not have as data
are read from the sources: the JSON of `m100-lab frames`, the exit codes, the messages and the keys of a column map.
"""
import json
import pathlib
import re
import sys
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
FRAMES = "host_tests/lab/frames"
JSON_KEY = re.compile(r'(?<!return )(?<!\w)\{"([a-z][a-z_0-9]*)",|(?:line|fields)\["([a-z][a-z_0-9]*)"\]')
READ_KEY = re.compile(r'reader\.(?:has|number|flag|text|bytes)\("([a-z_]+)"')


def unique(keys):
    return list(dict.fromkeys(keys))


def keys_in(source, pattern):
    return unique(next(filter(None, found.groups())) for found in pattern.finditer(source))


def frames_table(root):
    """Every key of a JSON line, by the function that writes or reads it."""
    message = (root / FRAMES / "message_json.cpp").read_text()
    line = message[message.index("Json frame_line("):]
    command = (root / FRAMES / "command.cpp").read_text()
    parts = {"a line of decode": (line, JSON_KEY),
             "fields of commands, answers and pushes": (message[:len(message) - len(line)], JSON_KEY),
             "fields of telemetry": ((root / FRAMES / "telemetry_json.cpp").read_text(), JSON_KEY),
             "the last line of decode": (command[command.index("Json statistics("):command.index("void decode(")], JSON_KEY),
             "a line for encode": ((root / FRAMES / "frame_text.cpp").read_text(), READ_KEY)}
    rows = [{"section": section, "key": key, "cells": []}
            for section, (source, pattern) in parts.items() for key in keys_in(source, pattern)
            if not (section == "fields of commands, answers and pushes" and key == "unknown")]
    return {"columns": [], "rows": rows}


def exit_table(root):
    rows = []
    codes = re.search(r"enum ExitCode : int \{(.*?)\}", (root / "firmware/companion/subcommands.h").read_text(), re.DOTALL)[1]
    for program in ("m100", "m100-lab"):
        rows += [{"section": program, "key": code, "cells": [name]}
                 for name, code in re.findall(r"(k\w+) = (\d+)", codes)]
    return {"columns": ["name in the code"], "rows": rows}


def map_rows(root):
    """The keys of a column map that are not signals."""
    source = (root / "host_tests/lab/logs/column_map.cpp").read_text()
    rows = [("top of the file", key) for key in unique(re.findall(r'\bkey == "(\w+)"', source))]
    rows += [("{ } of one column", key) for key in unique(re.findall(r'\bname == "(\w+)"', source))]
    return [{"section": section, "key": key, "cells": ["-"]} for section, key in rows]


TEXT = r'((?:"(?:[^"\\]|\\.)*"\s*)+)'


def spoken(literal):
    """The words of adjacent string literals."""
    return "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', literal)).replace('\\"', '"')


def messages_table(root):
    """The messages with which the program refuses, descends or gives up, with its own advice."""
    def source(path):
        return (root / path).read_text()

    def row(section, key, advice=""):
        return {"section": section, "key": key, "cells": [advice or "-"]}

    verdicts = source("firmware/companion/preflight/probe/line_probe.cpp")
    rows = [row("what m100 probe hears", name, spoken(text)) for name, text in re.findall(
        r'VerdictRow\{\s*Verdict::k\w+,\s*"(\w+)",\s*\d+,\s*' + TEXT, verdicts)]
    rows += [row("who has control, and why", name, spoken(text)) for name, text in re.findall(
        r'ReasonText\{\s*AuthorityReason::k\w+,\s*"(\w+)",\s*' + TEXT, source("firmware/safety/authority.cpp"))]
    acks = source("protocol/dji/acks.cpp")
    answers = {}
    for name, text in re.findall(r'"(\w+)", k(?:Retry|Refused|Again),\s*' + TEXT, acks):
        answers[name] = "; or: ".join(filter(None, (answers.get(name), spoken(text))))
    rows += [row("answers of the autopilot", name, text) for name, text in answers.items()]
    causes = source("firmware/safety/failsafe.cpp")
    rows += [row("steps of the failsafe state machine", name) for name in re.findall(
        r'"(\w+)"', causes[causes.index("kFailsafeReasonNames{"):causes.index("static_assert")])]
    words = source("firmware/companion/operator/operator_messages.cpp")
    aborts = re.search(r"kLost = " + TEXT + r";.*?kAborts\{(.*?)\};", words, re.DOTALL)
    rows += [row("an excitation aborted", spoken(text)) for text in [*re.findall(TEXT + ",", aborts[2]), aborts[1]]]
    result = source("host_tests/lab/identify/output/result.h")
    findings = re.search(r"/// (\w+(?:, \w+)+), note\.", result)[1].split(", ")
    verdicts = re.findall(r'"(\w+)"', re.search(r"string verdict;.*", result)[0])
    rows += [row("what m100-lab identify says about a log", name) for name in findings + verdicts]
    return {"columns": ["what the program advises"], "rows": rows}


def texts(root):
    """{page: its words and, where the sources hold it, its table}"""
    scanned = {"frames_json": frames_table(root), "exit_codes": exit_table(root), "messages": messages_table(root),
               "column_keys": {"rows": map_rows(root)}}
    words = tomllib.loads((HERE / "meanings.toml").read_text())
    return {page: {"title": text.pop("title"), "introduction": text.pop("introduction"), "meanings": text,
                   **{"columns": [], "rows": []}, **scanned.get(page, {})} for page, text in words.items()}


def source(root):
    """One literal for each page: a compiler need not take more than 65 536 characters in one."""
    out = ['// Made from meanings.toml by reference_text.py.', '#include "host_tests/lab/reference/reference_text.h"', "",
           "namespace m100::lab::reference {", "", "std::map<std::string, std::string> page_texts() {", "  return {"]
    out += [f'      {{"{page}", R"json({json.dumps(text)})json"}},' for page, text in texts(root).items()]
    return "\n".join([*out, "  };", "}", "", "}  // namespace m100::lab::reference", ""])


if __name__ == "__main__":
    pathlib.Path(sys.argv[2]).write_text(source(pathlib.Path(sys.argv[1])))
