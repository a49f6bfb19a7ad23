# SPDX-License-Identifier: BSD-3-Clause
"""Finds, compares and replaces text between markers in Markdown, `<!-- figure: NAME -->TEXT<!-- end -->`.

TEXT is a few words within a line, or whole lines if a line break follows the opening marker.
"""
import dataclasses
import re

OPEN, CLOSE = re.compile(r"(?<!`)<!-- figure:"), re.compile(r"(?<!`)<!-- end -->")  # not those quoted as code
MARKED = re.compile(r"(?<!`)<!-- figure: (?P<name>[\w.-]+) -->(?P<text>.*?)<!-- end -->", re.DOTALL)
NUMBER = re.compile(r"\d[\d ]*\d(?:\.\d+)?(?:e-?\d+)?|\d(?:\.\d+)?(?:e-?\d+)?")


@dataclasses.dataclass(frozen=True)
class Figure:
    """A measured figure, as text; `spread` is the relative difference that is ignored."""
    text: str
    spread: float = 0.0


def names(text):
    """-> names of the figures on a page. ValueError: a marker is not closed, or is inside another one."""
    found = list(MARKED.finditer(text))
    opened, closed = len(OPEN.findall(text)), len(CLOSE.findall(text))
    if not opened == closed == len(found) or any("<!--" in one["text"] for one in found):
        raise ValueError(f"{opened} opening markers and {closed} closing markers form only {len(found)} pairs")
    return [one["name"] for one in found]


def same(old, new, spread):
    """Whether two texts are equal. With a spread: the same words, and numbers that differ by at most the spread."""
    old, new = old.strip(), new.strip()
    if old == new or spread == 0.0:
        return old == new
    if NUMBER.sub("#", old) != NUMBER.sub("#", new):
        return False
    pairs = zip(NUMBER.findall(old), NUMBER.findall(new))
    values = [(float(a.replace(" ", "")), float(b.replace(" ", ""))) for a, b in pairs]
    return all(abs(a - b) <= spread * abs(b) for a, b in values)


def rewrite(text, figures):
    """-> the page with the measured figures, and the changes [(name, old, new)]. Other figures stay as they are."""
    changes = []

    def replaced(found):
        figure = figures.get(found["name"])
        if figure is None or same(found["text"], figure.text, figure.spread):
            return found[0]
        changes.append((found["name"], found["text"].strip(), figure.text.strip()))
        body = f"\n{figure.text.strip()}\n" if found["text"].startswith("\n") else figure.text.strip()
        return f"<!-- figure: {found['name']} -->{body}<!-- end -->"

    return MARKED.sub(replaced, text), changes
