# SPDX-License-Identifier: BSD-3-Clause
"""Judges one mutant with as little work as possible: the nearest tests run first, and the first failure ends it."""
import hashlib
import json
import os
import shutil

from mutate import areas, bench, operators

NOT_COMPILED, SAME_CODE, ALIVE = "not compiled", "same code", ""


def lasting_name(mutant):
    return f"{mutant.file} [{mutant.operator}] {mutant.before}  ->  {mutant.after}"


def stages_for(file, part_only):
    return areas.programs_for(file)[:1 if part_only else None]


def all_compile(machine, objects):
    return all(machine.compiled(made) is not None for made in objects)


def by_nearest(machine, program, file, changed):
    """-> whether the tests nearest to the file notice the mutant. Linked without the other tests, to save builds."""
    near = machine.nearest(program, file)
    others = [made for made in machine.link_of(program).own if machine.suites_of(made) and made not in near]
    mine = [made for made in changed if made not in others]
    if not near or not all_compile(machine, mine):
        return False
    path = machine.linked(program, mine, left_out=others)
    return path is not None and machine.run(path, program)


def by_program(machine, program, file):
    """-> the verdict of one program: its name if it notices the mutant, otherwise SAME_CODE, NOT_COMPILED or ALIVE."""
    own, deep = machine.touched(program, file)
    if not all_compile(machine, deep):
        return NOT_COMPILED
    if not own and not machine.level and machine.same_code(deep):
        return SAME_CODE
    if by_nearest(machine, program, file, deep + own):
        return program
    if not all_compile(machine, own):
        return NOT_COMPILED
    path = machine.linked(program, deep + own)
    if path is None:
        return NOT_COMPILED
    return program if machine.run(path, program) else ALIVE


class Planted:
    """Holds the mutant in the copy of the tree during a `with`; then restores the file and its time stamp."""

    def __init__(self, root, mutant):
        self.path, self.mutant = root / mutant.file, mutant
        self.sound, self.times = self.path.read_text(), self.path.stat()

    def __enter__(self):
        self.path.write_text(operators.planted(self.sound, self.mutant))

    def __exit__(self, *_):
        self.path.write_text(self.sound)
        os.utime(self.path, ns=(self.times.st_atime_ns, self.times.st_mtime_ns))


def verdict_on(machine, mutant, part_only):
    """-> NOT_COMPILED, SAME_CODE, ALIVE, or the name of the program that notices the mutant."""
    said = []
    shutil.rmtree(machine.out, ignore_errors=True)
    machine.level = " -O1" if mutant.file.endswith(".h") else ""
    made = machine.object_of(mutant.file)
    if made is not None:
        with Planted(machine.root, mutant):  # before any program is built: it may not be needed
            if machine.compiled(made) is None:
                return NOT_COMPILED
    for stage, programs in enumerate(stages_for(mutant.file, part_only)):
        for program in programs:
            machine.make_ready(program)
            own, deep = machine.touched(program, mutant.file)
            if not own + deep or (stage > 0 and len(own + deep) > bench.MAX_OBJECTS):
                continue
            with Planted(machine.root, mutant):
                said.append(by_program(machine, program, mutant.file))
            if said[-1] not in (ALIVE, SAME_CODE):
                return said[-1]
    # SAME_CODE of these programs is final for a source; other programs could still compile a header to different code.
    return SAME_CODE if said and all(verdict == SAME_CODE for verdict in said) else ALIVE


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


class Kept:
    """The verdicts so far, in a file, for the next run. A verdict is void when the mutant's file has changed."""

    def __init__(self, file, root, copy):
        self.file, self.root, self.copy = file, root, copy
        self.verdicts = json.loads(file.read_text()) if file.is_file() else {}

    def get(self, mutant, part_only):
        """-> the verdict, or None: the file has changed since, or only the part's own tests have judged a survivor."""
        kept = self.verdicts.get(mutant.name())
        if not kept or kept["file"] != digest(self.root / mutant.file):
            return None
        return None if kept["verdict"] == ALIVE and kept["part"] and not part_only else kept["verdict"]

    def put(self, mutant, verdict, part_only, seconds):
        """@param mutant as it was judged in the copy."""
        self.verdicts[mutant.name()] = {"verdict": verdict, "file": digest(self.copy / mutant.file), "part": part_only,
                                        "processor_s": round(seconds, 1)}
        new = self.file.with_suffix(".new")
        new.write_text(json.dumps(self.verdicts, indent=1) + "\n")
        new.replace(self.file)
