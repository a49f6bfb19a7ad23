# SPDX-License-Identifier: BSD-3-Clause
"""Builds a test program with one file changed, and runs it: compiles only the objects that read the file, links past the libraries.

Nothing of the build that stands is written: a changed object goes into a folder of its own and stands before the libraries on the
linker's line, so that the sound one in its library is not asked for.
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

# A test program may take so many times the processor time that it takes on the sound code, and this more: what takes longer hangs.
TIMES, MORE_S = 10.0, 20.0
# A test that waits for something that never comes takes no processor time. Only for that: how busy the machine is decides nothing.
WAITS_S = 300
# The programs behind the part's own do not judge a header for which more objects of theirs would have to be compiled.
MOST_OBJECTS = 4
NEAREST = 3  # test files of a header's mutant that are built and run before the others


def spent_s():
    """Processor time of everything that was started here and has ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@dataclasses.dataclass(frozen=True)
class Link:
    """How a program is linked: its command, its own objects, and the objects of its libraries."""
    command: str
    own: tuple
    of_libraries: tuple


class Bench:
    """@param home where what is known of the sound programs is kept, for the next run."""

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
        """-> {file of the tree: {object}} of what is built now."""
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
        """-> the object of a source in its library, or None: it is a header."""
        mine = [made for made, command in self.commands.items() if command.endswith(f" -c {self.root / file}")]
        return next((made for made in mine if not made.startswith("host_tests/")), None)

    def path(self, program):
        """Where the build puts the program: some stand in a folder of their own, as golden_flight does."""
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
        """-> the changed object, or None where it does not compile. What reads a changed header is compiled with -O1: many do."""
        changed = self.out / made
        if not changed.is_file():
            changed.parent.mkdir(parents=True, exist_ok=True)
            command = self.commands[made].replace(f" -o {made}", f" -Wno-parentheses{self.level} -o {changed}")
            if subprocess.run(command, shell=True, cwd=self.build, capture_output=True, check=False).returncode != 0:
                return None
        return changed

    def same_code(self, objects):
        """Whether the compiler makes the same of the changed file: then no test can notice the change."""
        return all((self.out / made).read_bytes() == (self.build / made).read_bytes() for made in objects)

    def linked(self, program, changed, left_out=()):
        """-> the program with the changed objects, without its own objects that are left out."""
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
        """-> whether it fails, hangs, or dies."""
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
        """Builds the program from the code as it is, which has to pass, and notes what that takes; the next run knows it."""
        if program in self.ready:
            return
        if subprocess.run(["ninja", "-C", self.build, "-j", str(self.jobs), program], stdout=subprocess.DEVNULL,
                          check=False).returncode != 0:
            sys.exit(f"The code as it is does not build: {program}")
        path = self.build / self.path(program)
        key = f"{program} {hashlib.sha256(path.read_bytes()).hexdigest()}"
        if key not in self.usual_s:
            before_s = spent_s()
            if self.run(path, program):
                sys.exit(f"The code as it is fails: {program}")
            self.usual_s[key] = round(spent_s() - before_s, 2)
            self.sound_file.write_text(json.dumps(self.usual_s, indent=1) + "\n")
        self.usual_s[program] = self.usual_s[key]
        self.reads = self._who_reads()
        self.ready.add(program)

    def nearest(self, program, file):
        """-> [objects of tests] of the file's own name, and for a header of those that read it; [] where none is near."""
        stem, readers = pathlib.Path(file).stem, self.reads.get(file, set())
        tests = [made for made in self.link_of(program).own if self.suites_of(made)]
        near = [made for made in tests if stem in pathlib.Path(made).name]
        near += [made for made in tests if made in readers and made not in near]
        return near[:NEAREST]

    def suites_of(self, made):
        """The gtest filter of the tests of an object, or "" where it has none."""
        source = re.search(r" -c (\S+)$", self.commands[made])[1]
        names = re.findall(r"^(?:TYPED_)?TEST(?:_[FP])?\((\w+),", pathlib.Path(source).read_text(), re.MULTILINE)
        return ":".join(f"{name}.*:*/{name}.*:{name}/*" for name in dict.fromkeys(names))
