#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that m100-lab prints every reference page, and that meanings.toml explains every key that the code reads and no other.

Usage: pages_test.py LAB ROOT      one line per offence, exit code 1 if there is any
       pages_test.py --self-test   plants offences and checks that each is found
"""
import json
import pathlib
import subprocess
import sys
import tomllib

LEAST_PAGES = 9


def offences(page, table, meanings, printed):
    wanted = {(row["section"], row["key"]): row["meaning"] for row in table["rows"]}
    if not wanted:
        yield f"{page}: has no keys"
    for (section, key), meaning in wanted.items():
        line = "| `" + key.replace("|", "\\|") + "` |"
        if not meaning:
            yield f"{page}: '{key}' of {section} has no meaning in meanings.toml"
        if not any(one.startswith(line) and one.endswith(f" {meaning.replace('|', chr(92) + '|')} |") for one in printed):
            yield f"{page}: '{key}' of {section} is not on the printed page"
    for section, keys in meanings.items():
        for key in keys if isinstance(keys, dict) else []:
            if (section, key) not in wanted:
                yield f"{page}: '{key}' of {section} is in meanings.toml and not in the code"
    for section in dict.fromkeys(section for section, _ in wanted):
        if f"## {section}" not in printed:
            yield f"{page}: has no section {section}"


def self_test():
    table = {"rows": [{"section": "[a]", "key": "x_m", "meaning": "how far"}, {"section": "[a]", "key": "b|c", "meaning": "either"}]}
    meanings = {"title": "Page", "[a]": {"x_m": "how far", "b|c": "either"}}
    printed = ["# Page", "## [a]", "| `x_m` | m | how far |", "| `b\\|c` | - | either |"]
    without = {"rows": [{**table["rows"][0], "meaning": ""}, table["rows"][1]]}
    wrong = {"not on the printed page": (table, meanings, printed[:3]), "no meaning": (without, meanings, printed),
             "not in the code": (table, {"[a]": {"y_m": "gone"}}, printed), "no section": (table, meanings, printed[2:]),
             "no keys": ({"rows": []}, {}, printed)}
    missed = [what for what, case in wrong.items() if not any(what in one for one in offences("page", *case))]
    sound = list(offences("page", table, meanings, printed))
    if sound or missed:
        print("self-test: missed", missed, sound)
        return 1
    return 0


def main():
    if "--self-test" in sys.argv:
        return self_test()

    def said(*words):
        return subprocess.run([sys.argv[1], "reference", *words], capture_output=True, text=True, check=True).stdout

    words = tomllib.loads((pathlib.Path(sys.argv[2]) / "host_tests/lab/reference/meanings.toml").read_text())
    tables = json.loads(said())
    found = [one for page, table in tables.items()
             for one in offences(page, table, words.get(page, {}), said(page).splitlines())]
    for one in found:
        print(one)
    print(f"{len(tables)} pages, {len(found)} offences")
    return 1 if found or len(tables) < LEAST_PAGES else 0


if __name__ == "__main__":
    sys.exit(main())
