# SPDX-License-Identifier: BSD-3-Clause
"""The workspace of a measurement: the project's folder, its builds and tools, and a way to run programs there."""
import dataclasses
import os
import pathlib
import shutil
import subprocess


class NotMeasuredHere(Exception):
    """A measurement lacks something, which the text names. The old figure stays."""


@dataclasses.dataclass(frozen=True)
class Source:
    """A group of figures, whose names begin with one of the `prefixes`, and the function that measures them all."""
    prefixes: tuple
    measure: object  # (Workspace) -> {name: Figure}; may raise NotMeasuredHere
    quick: bool = True  # takes seconds; the others are for the nightly run


@dataclasses.dataclass(frozen=True)
class Workspace:
    root: pathlib.Path

    def program(self, path, builds=("host-release", "host-debug")):
        """-> a built program by its path inside a build folder; the newest, if several builds have it."""
        files = [self.root / "build" / build / path for build in builds]
        built = [file for file in files if file.is_file()]
        if not built:
            raise NotMeasuredHere(f"{path} is not built")
        return max(built, key=lambda file: file.stat().st_mtime)

    def tool(self, name):
        if shutil.which(name) is None:
            raise NotMeasuredHere(f"{name} is not installed")
        return name

    def measured_log(self, name):
        """-> a file of the measured flights."""
        for folder in (os.environ.get("M100_SHARED", ""), self.root.parent / "shared"):
            file = pathlib.Path(folder) / "data" / "m100" / name
            if folder and file.is_file():
                return file
        raise NotMeasuredHere(f"the measured flight {name} is not here")

    def run(self, *command, may_fail=False):
        """-> stdout of the command, which runs in the project's folder. RuntimeError if it fails, unless it may."""
        done = subprocess.run([str(word) for word in command], cwd=self.root, capture_output=True, text=True, check=False)
        if done.returncode != 0 and not may_fail:
            said = done.stdout[-2000:] + done.stderr[-2000:]
            raise RuntimeError(f"{' '.join(map(str, command))}: exit {done.returncode}\n{said}")
        return done.stdout
