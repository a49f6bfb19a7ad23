#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that the guide's reference pages hold every key and word that the code reads, and no others.

Usage: pages.py LAB ROOT            compares; one line per difference, exit code 1 if there is any
       pages.py LAB ROOT --write    writes the pages anew; meanings and the text around the tables stay
       pages.py --self-test         plants differences and checks that each is found

LAB is the program m100-lab, whose `reference` prints the tables with which the programs read their files. Two tables
are read from the source: the JSON of `m100-lab frames` and the exit codes.
"""
import json
import pathlib
import re
import subprocess
import sys

GUIDE = "firmware/companion/guide"
FRAMES = "host_tests/lab/frames"
JSON_KEY = re.compile(r'(?<!return )(?<!\w)\{"([a-z][a-z_0-9]*)",|(?:line|fields)\["([a-z][a-z_0-9]*)"\]')
READ_KEY = re.compile(r'reader\.(?:has|number|flag|text|bytes)\("([a-z_]+)"')
ROW = re.compile(r"^\| `(.*?)` \|(.*)\|$")


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
    for program, path in (("m100", "firmware/companion/subcommands.h"), ("m100-lab", "host_tests/lab/subcommands.h")):
        codes = re.search(r"enum ExitCode : int \{(.*?)\}", (root / path).read_text(), re.DOTALL)[1]
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
    names = dict(re.findall(r'case Verdict::(k\w+):\s*return "(\w+)";', verdicts))
    advice = {verdict: spoken(text) for verdict, text in re.findall(r"case Verdict::(k\w+):\s*return " + TEXT + ";",
                                                                   verdicts[verdicts.index("remedy(Verdict"):])}
    rows = [row("what m100 probe hears", name, advice[verdict]) for verdict, name in names.items()]
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
    rows += [row("an excitation aborted", spoken(text)) for text in re.findall(
        r"case Abort::k\w+:\s*line\.add\(" + TEXT + r"\)", words)]
    result = source("host_tests/lab/identify/output/result.h")
    findings = re.search(r"/// (\w+(?:, \w+)+), note\.", result)[1].split(", ")
    verdicts = re.findall(r'"(\w+)"', re.search(r"string verdict;.*", result)[0])
    rows += [row("what m100-lab identify says about a log", name) for name in findings + verdicts]
    return {"columns": ["what the program advises"], "rows": rows}


def code_tables(lab, root):
    answer = subprocess.run([lab, "reference"], capture_output=True, text=True, check=True).stdout
    tables = json.loads(answer)
    tables["column_keys"]["rows"] = map_rows(root) + tables["column_keys"]["rows"]
    tables["frames_json"] = frames_table(root)
    tables["exit_codes"] = exit_table(root)
    tables["messages"] = messages_table(root)
    return tables


def escaped(cell):
    return cell.replace("|", "\\|")


def page_rows(text):
    """{(section, key): [cells..., meaning]} of a page."""
    rows, section = {}, ""
    for line in text.splitlines():
        if line.startswith("## "):
            section = line[3:].strip()
        elif found := ROW.match(line):
            cells = [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", found[2])]
            rows[(section, found[1].replace("\\|", "|"))] = cells
    return rows


def shown(table, section):
    """The places of the columns that have more than "-" in a section; the others are not on the page."""
    rows = [row["cells"] for row in table["rows"] if row["section"] == section]
    return [place for place in range(len(table["columns"])) if any(cells[place] != "-" for cells in rows)]


def differences(page, table, text):
    there = page_rows(text)
    wanted = {(row["section"], row["key"]): [row["cells"][place] for place in shown(table, row["section"])]
              for row in table["rows"]}
    for (section, key), cells in wanted.items():
        found = there.get((section, key))
        if found is None:
            yield f"{page}.md: '{key}' of {section} is in the code and not on the page"
        elif found[:-1] != [cell.strip() for cell in cells]:
            yield f"{page}.md: '{key}' of {section}: the page has {found[:-1]}, the code {cells}"
        elif not found[-1]:
            yield f"{page}.md: '{key}' of {section} has no meaning in plain English"
    for section, key in there:
        if (section, key) not in wanted:
            yield f"{page}.md: '{key}' of {section} is on the page and not in the code"


def written(table, text):
    """The page with new tables; the text before the first section and between heading and table stays."""
    meanings = {place: cells[-1] for place, cells in page_rows(text).items()}
    head = text.split("\n## ", 1)[0].rstrip("\n")
    notes = {}
    for part in re.split(r"^## ", text, flags=re.MULTILINE)[1:]:
        name, _, body = part.partition("\n")
        notes[name.strip()] = "\n".join(line for line in body.splitlines() if not line.startswith("|")).strip("\n")
    out = [head]
    for section in unique(row["section"] for row in table["rows"]):
        places = shown(table, section)
        columns = ["key", *(table["columns"][place] for place in places), "meaning"]
        out += ["", f"## {section}", ""]
        if notes.get(section):
            out += [notes[section], ""]
        out += ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
        for row in table["rows"]:
            if row["section"] == section:
                cells = [f"`{row['key']}`", *(row["cells"][place] for place in places), meanings.get((section, row["key"]), "")]
                out.append("| " + " | ".join(escaped(cell) for cell in cells) + " |")
    return "\n".join(out) + "\n"


def self_test():
    table = {"columns": ["unit"], "rows": [{"section": "[a]", "key": "x_m", "cells": ["m"]},
                                           {"section": "[a]", "key": "b|c", "cells": ["-"]}]}
    sound = written(table, "# Page\n\n## [a]\n\n| `x_m` | m | how far |\n| `b\\|c` | - | either |\n")
    wrong = {"not on the page": sound.replace("| `x_m` | m | how far |\n", ""),
             "not in the code": sound + "| `y_m` | m | gone |\n",
             "the page has ['s']": sound.replace("| m |", "| s |"),
             "no meaning": sound.replace("how far", "")}
    missed = [what for what, text in wrong.items() if not any(what in one for one in differences("page", table, text))]
    if list(differences("page", table, sound)) or missed or written(table, sound) != sound:
        print("self-test: missed", missed, list(differences("page", table, sound)))
        return 1
    return 0


def main():
    if "--self-test" in sys.argv:
        return self_test()
    lab, root = sys.argv[1], pathlib.Path(sys.argv[2])
    found = []
    for page, table in code_tables(lab, root).items():
        path = root / GUIDE / f"{page}.md"
        text = path.read_text() if path.is_file() else f"# {page}\n"
        if "--write" in sys.argv:
            text = written(table, text)
            path.write_text(text)
        found += differences(page, table, text)
    for one in found:
        print(one)
    print(f"{len(found)} differences")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
