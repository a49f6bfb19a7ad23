# SPDX-License-Identifier: BSD-3-Clause
"""Builds a test program with one changed file, and runs it. Only the objects that read the file are compiled.

The existing build is not modified: changed objects go into a folder of their own and precede the libraries on the
linker's command line, so that the linker does not take the original object from its library.
"""
import dataclasses
import hashlib
import json
import os
import pathlib
import re
import resource
import shlex
import subprocess
import sys

from mutate import areas

# A test program counts as hanging after TIMES the processor time that it takes on the unchanged code, plus MORE_S.
TIMES, MORE_S = 10.0, 20.0
# Real time, only for a test that waits for ever and takes no processor time; long enough for a busy machine.
WAITS_S = 300
# Programs other than the part's own do not judge a header if more than this many of their objects had to be compiled.
MAX_OBJECTS = 4
NEAREST = 3  # number of test files that are built and run before the others


def spent_s():
    """Processor time of all child processes that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@dataclasses.dataclass(frozen=True)
class Link:
    """How a program is linked: its command, its own objects, and the objects of its libraries."""
    command: str
    own: tuple
    of_libraries: tuple


class Bench:
    """@param home folder that keeps the processor times of the unchanged programs for the next run."""

    def __init__(self, root, build, home, jobs):
        self.root, self.build, self.out, self.jobs = root, build, home / "changed", jobs
        self.commands = {}
        for entry in json.loads((build / "compile_commands.json").read_text()):
            self.commands[re.search(r" -o (\S+)", entry["command"])[1]] = entry["command"]
        self.reads, self.paths, self.links, self.archives, self.ready = {}, {}, {}, {}, set()
        self.sound_file = home / "sound.json"
        self.level = ""
        self.usual_s = json.loads(self.sound_file.read_text()) if self.sound_file.is_file() else {}

    def _ninja(self, *words):
        return subprocess.run(["ninja", "-C", self.build, *words], capture_output=True, text=True, check=True).stdout

    def _who_reads(self):
        """-> {file of the tree: {object that reads it}}, for the present build."""
        out, made = {}, ""
        beginning = f"{self.root}/"
        for line in self._ninja("-t", "deps").splitlines():
            if line and not line.startswith(" "):
                made = line.split(":")[0]
            elif line.startswith("    "):
                file = os.path.normpath(self.build / line.strip())
                if file.startswith(beginning):
                    out.setdefault(file[len(beginning):], set()).add(made)
        return out

    def _members(self, archive):
        if archive not in self.archives:
            found = [line.strip() for line in self._ninja("-t", "query", archive).splitlines()]
            self.archives[archive] = tuple(word for word in found[:found.index("outputs:")] if word.endswith(".o"))
        return self.archives[archive]

    def object_of(self, file):
        """-> the object of a source in its library, or None for a header."""
        mine = [made for made, command in self.commands.items() if command.endswith(f" -c {self.root / file}")]
        return next((made for made in mine if not made.startswith("host_tests/")), None)

    def path(self, program):
        """Path of the program in the build; some have a folder of their own, for example golden_flight."""
        if program not in self.paths:
            said = [line.strip() for line in self._ninja("-t", "query", program).splitlines()]
            self.paths[program] = next(word for word in said if pathlib.Path(word).name == program)
        return self.paths[program]

    def link_of(self, program):
        if program not in self.links:
            command = self._ninja("-t", "commands", self.path(program)).splitlines()[-1]
            command = command.removeprefix(": && ").removesuffix(" && :")
            words = shlex.split(command)
            archives = dict.fromkeys(word for word in words if word.endswith(".a") and not word.startswith("/"))
            self.links[program] = Link(command, tuple(word for word in words if word.endswith(".o")),
                                       tuple(member for archive in archives for member in self._members(archive)))
        return self.links[program]

    def touched(self, program, file):
        """-> ([objects of the program itself], [objects of its libraries]) that read the file."""
        link, readers = self.link_of(program), self.reads.get(file, set())
        return [word for word in link.own if word in readers], [word for word in link.of_libraries if word in readers]

    def compiled(self, made):
        """-> the changed object, or None if it does not compile. A changed header means -O1, because many read it."""
        changed = self.out / made
        if not changed.is_file():
            changed.parent.mkdir(parents=True, exist_ok=True)
            command = self.commands[made].replace(f" -o {made}", f" -Wno-parentheses{self.level} -o {changed}")
            if subprocess.run(command, shell=True, cwd=self.build, capture_output=True, check=False).returncode != 0:
                return None
        return changed

    def same_code(self, objects):
        """Whether the changed file compiles to the same objects: then no test can notice the change."""
        return all((self.out / made).read_bytes() == (self.build / made).read_bytes() for made in objects)

    def linked(self, program, changed, left_out=()):
        """-> the program linked with the changed objects and without the objects in left_out."""
        link, out = self.link_of(program), self.out / program
        words = []
        for word in shlex.split(link.command):
            if word not in left_out:
                words.append(str(self.out / word) if word in changed else word)
        at = next(index for index, word in enumerate(words) if word.endswith(".o"))
        words[at:at] = [str(self.out / made) for made in changed if made not in link.own]
        words[words.index("-o") + 1] = str(out)
        return out if subprocess.run(words, cwd=self.build, capture_output=True, check=False).returncode == 0 else None

    def run(self, path, program, gtest_filter="*"):
        """-> whether it fails, hangs, or crashes."""
        limit_s = int(TIMES * self.usual_s.get(program, 600.0) + MORE_S)
        unasked = areas.UNASKED.get(program, "")
        command = [str(path), "--gtest_brief=1", "--gtest_fail_fast", f"--gtest_filter={gtest_filter}-{unasked}"]
        try:
            return subprocess.run(command, cwd=self.root, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT, check=False,
                                  timeout=WAITS_S, preexec_fn=lambda: resource.setrlimit(
                                      resource.RLIMIT_CPU, (limit_s, limit_s + 5))).returncode != 0
        except subprocess.TimeoutExpired:
            return True

    def make_ready(self, program):
        """Builds the program from the unchanged code, which has to pass, and keeps its processor time."""
        if program in self.ready:
            return
        if subprocess.run(["ninja", "-C", self.build, "-j", str(self.jobs), program], stdout=subprocess.DEVNULL,
                          check=False).returncode != 0:
            sys.exit(f"The unchanged code does not build: {program}")
        path = self.build / self.path(program)
        key = f"{program} {hashlib.sha256(path.read_bytes()).hexdigest()}"
        if key not in self.usual_s:
            before_s = spent_s()
            if self.run(path, program):
                sys.exit(f"The unchanged code fails its tests: {program}")
            self.usual_s[key] = round(spent_s() - before_s, 2)
            self.sound_file.write_text(json.dumps(self.usual_s, indent=1) + "\n")
        self.usual_s[program] = self.usual_s[key]
        self.reads = self._who_reads()
        self.ready.add(program)

    def nearest(self, program, file):
        """-> [object of tests] with the file's name, then those that read the file (a header); [] if there are none."""
        stem, readers = pathlib.Path(file).stem, self.reads.get(file, set())
        tests = [made for made in self.link_of(program).own if self.suites_of(made)]
        near = [made for made in tests if stem in pathlib.Path(made).name]
        near += [made for made in tests if made in readers and made not in near]
        return near[:NEAREST]

    def suites_of(self, made):
        """-> the GoogleTest filter of the tests in an object, or "" if it has none."""
        source = re.search(r" -c (\S+)$", self.commands[made])[1]
        names = re.findall(r"^(?:TYPED_)?TEST(?:_[FP])?\((\w+),", pathlib.Path(source).read_text(), re.MULTILINE)
        return ":".join(f"{name}.*:*/{name}.*:{name}/*" for name in dict.fromkeys(names))
