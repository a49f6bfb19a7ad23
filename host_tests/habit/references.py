#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that comments and pages refer only to existing promises, sections (protocol), decisions, files, links, tests,
and that a comment names only functions that exist, and documents only parameters of the function below it.

Usage: references.py [--self-test] ROOT. Prints one line per offence (file: what) and exits with 1 if there is any.
"""
import fnmatch
import os
import pathlib
import re
import subprocess
import sys

PROMISES, WIRE, DECISIONS = "firmware/safety/PROMISES.md", "protocol/README.md", "firmware/DECISIONS.md"
PAGES = (".md", "reference/meanings.toml")  # prose from the first line to the last
TOP = ("firmware", "hal", "protocol", "host_tests", "linker")
NUMBERS = r"\d+(?:\.\d+)?(?:(?:, | and | to )\d+(?:\.\d+)?)*"
PROMISE = re.compile(r"\bR(\d{1,2})\b")
SECTION = re.compile(rf"(?P<page>\b[Pp]rotocol(?:'s)?,? )(?:sections? )?(?P<list>{NUMBERS})|"
                     rf"\b[Ss]ections? (?P<own>{NUMBERS})")
# "decision est 12": the item 12 below the heading of the room in DECISIONS.
DECISION = re.compile(rf"\b[Dd]ecisions? (?:(?P<room>[a-z]+) )?(?P<list>{NUMBERS})")
LINK = re.compile(r"\]\(([^)#:]+)\)")
FILE = re.compile(r"(?<![\w/.*}<$-])((?:[\w-][\w.-]*/)*[\w-][\w.-]*\.(?:md|h|cpp|inc|py|sh|ld|cmake|jsonl))\b(?![\w/*])")
PATH = re.compile(rf"(?<![\w/.-])((?:{'|'.join(TOP)})/[\w./*{{}},-]*[\w*}}/])")
TEST = re.compile(r"`(?:unit|property|golden|scenario|soak)\.\w+((?:[./]+|\.\.\.)[\w./*]+)`")
ASKED_FOR = re.compile(r"(?:-R|--gtest_filter=) ?'?([^'`\s]+)")
TEST_NAME = re.compile(r"^(?:TYPED_)?(?:TEST|RC_GTEST_\w+)(?:_[FP])?\(\s*(\w+),\s*(\w+)|"
                       r"^INSTANTIATE_\w+\(\s*(\w+),\s*(\w+)", re.MULTILINE)
COMMENT = re.compile(r"(?:^ *//.*\n)+", re.MULTILINE)
PARAMETER = re.compile(r"@param (\w+)(?:, (\w+) )?")
FUNCTION = re.compile(r"\b([a-z]\w+)\(\)")
DOCSTRING = re.compile(r'"""(.*?)"""', re.DOTALL)


def spoken(name, text):
    """-> the prose of a file: the whole text of a page, the comments (and docstrings) of code."""
    if name.endswith(PAGES):
        return re.sub(r"\s+", " ", text)
    mark = "//" if name.endswith((".h", ".cpp", ".inc", ".c", ".ld")) else "#"
    if name.endswith(".ld"):
        mark = "/*"
    lines = [line.split(mark, 1)[1].strip(" /<*#") for line in text.splitlines() if mark in line and "#include" not in line]
    docstrings = DOCSTRING.findall(text) if mark == "#" else []
    return re.sub(r"\s+", " ", " ".join(lines + docstrings))


def wanted(numbers):
    """'4 to 6 and 11' -> the sections 4, 5, 6, 11"""
    out = []
    for part in re.split(r", | and ", numbers):
        ends = part.split(" to ")
        out += [str(n) for n in range(int(ends[0]), int(ends[1]) + 1)] if len(ends) == 2 and "." not in part else ends
    return out


class Project:
    def __init__(self, texts):
        self.texts = texts  # {path: text}
        self.folders = {str(parent) for name in texts for parent in pathlib.PurePosixPath(name).parents}
        self.endings = {"/".join(name.split("/")[i:]) for name in texts for i in range(name.count("/") + 1)}
        self.promises = set(re.findall(r"^### (R\d+)\.", texts.get(PROMISES, ""), re.MULTILINE))
        rooms = re.split(r"^## (\w+)$", texts.get(DECISIONS, ""), flags=re.MULTILINE)[1:]
        self.decisions = {(room, number) for room, text in zip(rooms[::2], rooms[1::2])
                          for number in re.findall(r"^(\d+)\. ", text, re.MULTILINE)}
        tests = [text for name, text in texts.items() if name.endswith(".cpp") and name.startswith("host_tests/")]
        self.tests = " ".join(" ".join(filter(None, names)) for text in tests for names in TEST_NAME.findall(text))

        code = (re.sub(r"//.*", "", text) for name, text in texts.items() if name.endswith((".h", ".cpp")))
        self.called = {name for text in code for name in re.findall(r"\b(\w+)(?:<[^;()]*>)?\(", text)}

    def sections(self, page):
        return set(re.findall(r"^#+ (\d+(?:\.\d+)*)\.? ", self.texts.get(page, ""), re.MULTILINE))

    def file_exists(self, file, holder):
        near = os.path.normpath(pathlib.PurePosixPath(holder).parent / file)
        return file in self.endings or near in self.texts

    def path_exists(self, path):
        path = path.rstrip("/.")
        alternatives = re.search(r"\{([^}]*)\}", path)
        if alternatives:
            return all(self.path_exists(path.replace(alternatives[0], one)) for one in alternatives[1].split(","))
        return (path in self.folders or path in self.texts or any(path + end in self.texts for end in (".h", ".cpp"))
                or ("*" in path and any(fnmatch.fnmatch(name, path) for name in self.texts)))

    def offences(self, name):
        text = self.texts[name]
        words = spoken(name, text)
        for promise in sorted(set(re.findall(r"\bR\d{1,2}\b", words + " ".join(re.findall(r'"promise", "([^"]*)"', text))))):
            if promise not in self.promises:
                yield f"promise {promise} does not exist"
        yield from self.of_sections(name, words)
        yield from self.of_decisions(words)
        for file in sorted(set(FILE.findall(words))):
            if not self.file_exists(file, name):
                yield f"file {file} does not exist"
        for path in sorted(set(PATH.findall(words))):
            if not FILE.fullmatch(path) and not self.path_exists(path):
                yield f"{path} does not exist"
        if name.endswith((".h", ".cpp", ".md")):
            yield from (f"function {one}() does not exist" for one in sorted(set(FUNCTION.findall(words)) - self.called))
        if name.endswith((".h", ".cpp")):
            yield from self.of_parameters(text)
        if name.endswith(PAGES):
            yield from self.of_page(name, text)

    def of_parameters(self, text):
        for comment in COMMENT.finditer(text):
            below = " ".join(text[comment.end():].split("\n", 13)[:13])
            for name in filter(None, sum(PARAMETER.findall(re.sub(r"\n *//+", "", comment[0])), ())):
                if not re.search(rf"\b{name}\b", below):
                    yield f"@param {name}: the declaration below has no such parameter"

    def of_sections(self, name, words):
        for found in SECTION.finditer(words):
            page, numbers = (WIRE, found["list"]) if found["page"] else (name, found["own"])
            for number in wanted(numbers):
                if number not in self.sections(page):
                    yield f"{found[0]!r}: {page} has no section {number}"

    def of_decisions(self, words):
        for found in DECISION.finditer(words):
            for number in wanted(found["list"]):
                if (found["room"], number) not in self.decisions:
                    yield f"{found[0]!r}: {DECISIONS} has no such decision; say room and number"

    def of_page(self, name, text):
        for link in LINK.findall(text):
            if not self.file_exists(link, name):
                yield f"link to {link}, which does not exist"
        for test in TEST.findall(text) + ASKED_FOR.findall(text):
            for word in re.findall(r"\b[A-Z]\w*[a-z]\w*", test):
                if word not in self.tests:
                    yield f"no test has {word} in its name"


def project_files(root):
    """{path: text} of all files that are tracked or not ignored; without git, of all files outside the build folder."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=root, capture_output=True, text=True,
                            check=False)
    names = listed.stdout.split("\n") if listed.returncode == 0 else [
        str(file.relative_to(root)) for file in root.rglob("*") if file.relative_to(root).parts[0] not in ("build", ".git")]
    out = {}
    for name in sorted(filter(None, names)):
        if (root / name).is_file():
            try:
                out[name] = (root / name).read_text()
            except UnicodeDecodeError:
                out[name] = ""  # binary: it exists, but has no text
    return out


def self_test():
    """Tests the check itself: it must report each line of `planted`, and none of `sound`."""
    base = {PROMISES: "### R1. No heap\n### R2. Parser\n", WIRE: "### 4. Start\n#### 4.1 Version\n### 5. Sessions\n",
            DECISIONS: "# Decisions\n\n## est\n\n1. One.\n", "firmware/est/README.md": "", "host_tests/unit/a_test.cpp": "TEST(Suite, IsRight) {\n}\n"}
    planted = {
        "a.h": ["// promise R3", "// (protocol, 7)", "// protocol, sections 4 to 6", "// the protocol's\n// section 9",
                "// see style.md", "// decision est 2", "// decision 1", "// decision mpc 1",
                "// as section 3 has it", "// firmware/old/x.cpp",
                "// in firmware/old", "// as in gone()", "// @param gone is\nvoid f(int here);", "// @param here,\n// gone are\nvoid f(int here);"],
        "a_test.cpp": ['  RecordProperty("promise", "R9");'],
        "page.md": ["[page](missing.md)", "`unit.a.Suite.IsWrong`", "`gone.h` is", "`hal/{a,b}.h`",
                    "as in `gone()`", "`ctest -R 'unit.a.(Suite|Other)'`", "`unit_a --gtest_filter=Gone.*`"]}
    sound = {"b.h": ["// promise R2; protocol, sections 4 to 5 and 4.1; firmware/est",
                     "// decision est 1", "// the decision of est",
                     "// @param here, there are\nvoid fly(int here, int there);  // as in fly()"],
             "page2.md": ["[page](firmware/est/README.md) `unit.a.Suite.IsRight` `ctest -R 'Suite|unit.a'` `b.h` section\n"]}
    missed = [(name, line) for name, lines in planted.items() for line in lines
              if not list(Project(base | {name: line}).offences(name))]
    wrong = [(name, line, offence) for name, lines in sound.items() for line in lines
             for offence in Project(base | {"b.h": "", name: line}).offences(name)]
    for one in missed + wrong:
        print("self-test:", *one)
    return 1 if missed or wrong else 0


def main():
    if "--self-test" in sys.argv:
        return self_test()
    project = Project(project_files(pathlib.Path(sys.argv[1])))
    found = 0
    for name in project.texts:
        if name.endswith((".h", ".cpp", ".inc", ".c", ".ld", *PAGES, ".py", ".sh", ".cmake", "CMakeLists.txt")) \
                or project.texts[name].startswith("#!"):
            if name != "host_tests/habit/references.py":  # it contains planted wrong references
                for offence in project.offences(name):
                    print(f"{name}: {offence}")
                    found += 1
    print(f"{len(project.texts)} files read, {found} offences")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
