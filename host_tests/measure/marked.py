# SPDX-License-Identifier: BSD-3-Clause
"""Text between markers in Markdown, `<!-- figure: NAME -->TEXT<!-- end -->`: found, compared, replaced.

TEXT is a few words within a line, or whole lines where a line break follows the opening marker.
"""
import dataclasses
import re

OPEN, CLOSE = re.compile(r"(?<!`)<!-- figure:"), re.compile(r"(?<!`)<!-- end -->")  # in code they are only talked about
MARKED = re.compile(r"(?<!`)<!-- figure: (?P<name>[\w.-]+) -->(?P<text>.*?)<!-- end -->", re.DOTALL)
NUMBER = re.compile(r"\d[\d ]*\d(?:\.\d+)?(?:e-?\d+)?|\d(?:\.\d+)?(?:e-?\d+)?")


@dataclasses.dataclass(frozen=True)
class Figure:
    """What was measured, as it is printed; `spread` is the relative difference that is no news."""
    text: str
    spread: float = 0.0


def names(text):
    """The figures that a page shows. A marker that is not closed, or stands inside another one, is a ValueError."""
    found = list(MARKED.finditer(text))
    opened, closed = len(OPEN.findall(text)), len(CLOSE.findall(text))
    if not opened == closed == len(found) or any("<!--" in one["text"] for one in found):
        raise ValueError(f"{opened} markers are opened, {closed} are closed, {len(found)} fit together")
    return [one["name"] for one in found]


def same(old, new, spread):
    """Do two texts say the same? With a spread: the same words, and numbers that differ by no more than that."""
    old, new = old.strip(), new.strip()
    if old == new or spread == 0.0:
        return old == new
    if NUMBER.sub("#", old) != NUMBER.sub("#", new):
        return False
    pairs = zip(NUMBER.findall(old), NUMBER.findall(new))
    values = [(float(a.replace(" ", "")), float(b.replace(" ", ""))) for a, b in pairs]
    return all(abs(a - b) <= spread * abs(b) for a, b in values)


def rewrite(text, figures):
    """-> the page with what was measured, and what changed: [(name, old, new)]. Figures not measured stay as they are."""
    changes = []

    def replaced(found):
        figure = figures.get(found["name"])
        if figure is None or same(found["text"], figure.text, figure.spread):
            return found[0]
        changes.append((found["name"], found["text"].strip(), figure.text.strip()))
        body = f"\n{figure.text.strip()}\n" if found["text"].startswith("\n") else figure.text.strip()
        return f"<!-- figure: {found['name']} -->{body}<!-- end -->"

    return MARKED.sub(replaced, text), changes
