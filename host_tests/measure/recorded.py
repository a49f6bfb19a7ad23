# SPDX-License-Identifier: BSD-3-Clause
"""Finds the calls of RecordProperty in the tests' sources, each with the tests that make it."""
import dataclasses
import re

TEST = re.compile(r"^(?:TYPED_)?(?:TEST|RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP)(?:_F|_P)?\(\s*(\w+),\s*(\w+)", re.MULTILINE)
CLASS = re.compile(r"^(?:class|struct)\s+(\w+)[^;{]*\{", re.MULTILINE)
FUNCTION = re.compile(r"^ {0,2}(?!return |else |if |for |while |switch )(?:[\w:<>&*,]+ )+[&*]?(\w+)\([^;{}]*\)[^;{}]*\{", re.MULTILINE)
CALL = re.compile(r'RecordProperty\(\s*"([^"]*)"(\s*\+[^,]*)?,\s*(?:"([^"]*)")?')
WHOLE_SUITE = ("SetUp", "SetUpTestSuite", "TearDown")


@dataclasses.dataclass(frozen=True)
class Call:
    key: str  # ends with a dot if the program computes the rest
    value: str  # empty if the program computes it
    suite: str
    test: str  # * if every test of the suite makes the call


def blocks(pattern, text):
    """-> [(start, end, match)] of blocks that begin with the pattern and end with a brace at a line's start."""
    out = []
    for found in pattern.finditer(text):
        end = re.compile(r"^\};?", re.MULTILINE).search(text, found.end())
        out.append((found.start(), end.start() if end else len(text), found))
    return out


def tests_that_make(position, text):
    """-> [(suite, test)]: the test whose body contains the position, or the tests that call the helper around it."""
    tests = blocks(TEST, text)
    for start, end, found in tests:
        if start < position < end:
            return [(found[1], found[2])]
    helpers = FUNCTION.findall(text, 0, position)
    helper = helpers[-1] if helpers else ""
    for start, end, found in blocks(CLASS, text):
        if start < position < end and helper in WHOLE_SUITE:
            return [(found[1], "*")]
    calls = re.compile(rf"\b{re.escape(helper)}\b" if helper else r"(?!)")
    return [(found[1], found[2]) for start, end, found in tests if calls.search(text, start, end)]


def calls_of(text):
    """-> [Call] of one source. ValueError: no test makes the call."""
    out = []
    for found in CALL.finditer(text):
        line = text[text.rfind("\n", 0, found.start()) + 1:found.start()]
        if "//" in line:
            continue
        makers = tests_that_make(found.start(), text)
        if not makers:
            number = text.count("\n", 0, found.start()) + 1
            raise ValueError(f"line {number}: no test calls this RecordProperty(\"{found[1]}\", ...)")
        out += [Call(found[1], found[3] or "", suite, test) for suite, test in makers]
    return out


def gtest_filter(suite, test):
    """The names that GoogleTest may give this test: plain, with parameters, with types."""
    return ":".join((f"{suite}.{test}", f"*/{suite}.{test}/*", f"{suite}/*.{test}", f"*/{suite}/*.{test}"))
