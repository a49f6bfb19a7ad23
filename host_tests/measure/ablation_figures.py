# SPDX-License-Identifier: BSD-3-Clause
"""What each special test of identify saves: answers to logs of unknown vehicles with the test and without it."""
import collections
import re

from measure.lab_figures import compact_table
from measure.workspace import Source

LOGS_OF_A_KIND = 31  # 33 kinds: about 1000 logs of each seed
SEEDS = (3100000, 7200000)
# In the order of SpecialTest (host_tests/lab/identify/request.h).
TESTS = ("frozen stick", "clock", "lead zero or clock", "tether", "names from both parts", "change", "one side of a change",
         "constant instead of change", "temporary change", "slow stick", "weak effect")
LOG = re.compile(r"^  (?P<seed>\d+) \S+ \(change at \S+: (?P<answer>\d) .* acted(?P<acted>[ \d]*): ")
KIND = re.compile(r"^(\S.*?)  +\d+ +\d+ ")
RIGHT, UNDECIDED = 0, 1  # of Classification; every other one is wrong


def answers(workspace, *words):
    """-> {(kind, seed): (answer, numbers of the tests that acted)}"""
    printed = workspace.run(workspace.program("host_tests/property/identify_adversarial_logs", ("host-release",)), "--unseen", "--verbose",
                            *words, may_fail=True)
    found, of_kind = {}, {}
    for line in printed.splitlines():  # the row of a kind follows its logs
        if log := LOG.match(line):
            of_kind[int(log["seed"])] = int(log["answer"]), sorted({int(word) for word in log["acted"].split()})
        elif kind := KIND.match(line):
            found |= {(kind[1], seed): one for seed, one in of_kind.items()}
            of_kind = {}
    return found


def counts_of(workspace, seed, logs):
    """-> how many logs were answered, and counts of (test, what became of the answer): a test that did not act changes none"""
    counts = collections.Counter()
    with_all = answers(workspace, "--logs", logs, "--seed", seed)
    for (kind, number), (before, acted) in with_all.items():
        for test in acted:
            after, _ = answers(workspace, "--logs", 1, "--seed", number, "--kind", kind, "--without", test).get((kind, number), (UNDECIDED, []))
            counts[test, "acted"] += 1
            counts[test, "wrong"] += before <= UNDECIDED < after
            counts[test, "undecided"] += (before, after) == (RIGHT, UNDECIDED)
            counts[test, "better"] += after < before and after <= UNDECIDED
    return len(with_all), counts


def ablation(workspace, logs=LOGS_OF_A_KIND):
    """Per test: in how many logs it acted, and how the answers change without it, one number per seed."""
    found = [counts_of(workspace, seed, logs) for seed in SEEDS]
    rows = [[name, *("/".join(str(counts[test, what]) for _, counts in found) for what in ("acted", "wrong", "undecided", "better"))]
            for test, name in enumerate(TESTS)]
    return {"identify.ablation": compact_table([f"without (of {'/'.join(str(count) for count, _ in found)} logs)", "acted", "wrong", "undecided", "better"], *rows)}


SOURCES = [Source(("identify.ablation",), ablation, quick=False)]
