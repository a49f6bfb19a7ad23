#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks that the pictures of the guide's courses equal what the program draws, and that it reports unflyable ones.

Usage: course_pictures.py M100_LAB             compares; one line per offence, exit code 1 if there is any
       course_pictures.py M100_LAB --write     writes the pictures again
"""
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[3]
COURSES = ROOT / "firmware/companion/guide/courses"
FLIGHT = ROOT / "firmware/companion/files/example/flight.toml"


def shipped():
    return sorted(file for file in COURSES.iterdir() if file.suffix in (".txt", ".csv"))


def draw(lab, courses, folder):
    words = [lab, "course", *courses, "--flight", FLIGHT, "--out", folder, "--json", folder / "courses.json"]
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    answer = folder / "courses.json"
    return done, json.loads(answer.read_text())["courses"] if answer.is_file() else []


def stale_pictures(lab, folder):
    done, _ = draw(lab, shipped(), folder)
    if done.returncode != 0:
        yield f"the guide's courses: exit {done.returncode}: {done.stdout}{done.stderr}"
        return
    page = (COURSES / "README.md").read_text()
    for course in shipped():
        picture = course.with_suffix(".svg")
        if not picture.is_file() or picture.read_bytes() != (folder / picture.name).read_bytes():
            yield f"{picture.relative_to(ROOT)} differs from what m100-lab course draws; course_pictures.py --write updates it"
        if f"({course.name})" not in page or f"({picture.name})" not in page:
            yield f"{course.name} or its picture is missing on the page"


def hostile(lab, folder):
    """A tilt limit is in degrees. A refused course is reported with the place and drawn; an unreadable one is not."""
    (folder / "tilt.txt").write_text("limits tilt_deg 9 acceleration_m_s2 50 speed_m_s 50\nthrough 4 0 0 0\nthrough 4 3 0 0\n")
    (folder / "outside.txt").write_text("circle 4 1 1\n")
    (folder / "fast.txt").write_text("quintic 3 0 0 0 1\n")
    done, answer = draw(lab, [folder / name for name in ("tilt.txt", "outside.txt", "fast.txt")], folder)
    if done.returncode != 1 or [one["flyable"] for one in answer] != [True, False, False]:
        yield f"exactly one of three courses should be flyable: exit {done.returncode}, {answer}, {done.stderr}"
        return
    if not 8.8 < answer[0]["tilt_deg"] < 9.1:
        yield f"a course limited to 9 degrees of tilt reaches {answer[0]['tilt_deg']} degrees"
    for one, words in ((answer[1], "outside the fence, y_m"), (answer[2], "the tilt is ")):
        if words not in one["why_not"] or "m from the start" not in one["why_not"]:
            yield f"{one['course']}: {one['why_not']}"
        if not (folder / f"{pathlib.Path(one['course']).stem}.svg").is_file():
            yield f"{one['course']} is not drawn"
    (folder / "gap.csv").write_text("t_s,x_m,y_m,z_m\n0,0,0,0\n1,nan,0,0\n")
    done, _ = draw(lab, [folder / "gap.csv"], folder)
    if done.returncode != 2 or "gap.csv:3: 't_s': 'nan' is not a number" not in done.stderr:
        yield f"a table with NaN: exit {done.returncode}, {done.stderr}"


def main():
    lab = pathlib.Path(sys.argv[1]).resolve()
    if "--write" in sys.argv:
        with tempfile.TemporaryDirectory() as name:
            done, _ = draw(lab, shipped(), pathlib.Path(name))
            print(done.stdout, end="")
            for course in shipped():
                picture = course.with_suffix(".svg").name
                (COURSES / picture).write_bytes((pathlib.Path(name) / picture).read_bytes())
        return done.returncode
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        offences = [*stale_pictures(lab, pathlib.Path(first)), *hostile(lab, pathlib.Path(second))]
    print("\n".join(offences), end="\n" if offences else "")
    return 1 if offences else 0


if __name__ == "__main__":
    sys.exit(main())
