# SPDX-License-Identifier: BSD-3-Clause
"""Makes mutants: changes of one place of a C++ source (operator, constant, return value, statement) for a test to notice."""
import dataclasses
import re


@dataclasses.dataclass(frozen=True)
class Mutant:
    file: str  # from the project's root
    line: int  # counted from 1
    operator: str
    before: str  # the line without its indent
    after: str

    def name(self):
        return f"{self.file}:{self.line} [{self.operator}] {self.before}  ->  {self.after}"


SWAPS = {
    "relational": {" < ": " <= ", " <= ": " < ", " > ": " >= ", " >= ": " > ", " == ": " != ", " != ": " == "},
    "arithmetic": {" + ": " - ", " - ": " + ", " * ": " / ", " / ": " * ", " += ": " -= ", " -= ": " += ",
                   " << ": " >> ", "++": "--"},
    "boolean": {" && ": " || ", " || ": " && ", "true": "false", "false": "true", "(!": "("},
}
NUMBER = re.compile(r"(?<![\w.'])(\d+\.\d*(?:e-?\d+)?F?|\d+U?)(?![\w.'])")
STATEMENT = re.compile(r"^(?:\+\+|--)?[a-z_][\w.\->\[\]]*(?:\(.*\)| [+\-*/|&]?= .*|\+\+|--)?;$")
RETURN = re.compile(r"^return (.+);$")
# Lines without mutants: they are not code, or the compiler checks them.
SKIPPED = re.compile(r"^\s*(?:#|//|\*|/\*|using |namespace |template|static_assert|friend|public|private|protected|extern|"
                     r"class |struct |enum |M100_|\"|case |default:|typename)|operator[^ ]* |static_assert|M100_ASSERT")


def without_comment(line):
    return re.sub(r"\s*//.*$", "", line)


def changed_number(text):
    if "." in text:
        value = float(text.rstrip("F"))
        return f"{1.0 if value == 0.0 else value * 2.0!r}" + ("F" if text.endswith("F") else "")
    digits = text.rstrip("U")
    return f"{int(digits) + 1}" + ("U" if text.endswith("U") else "")


def of_line(file, number, line):
    """-> [Mutant] of one line of code."""
    code = without_comment(line)
    if SKIPPED.search(code) or not code.strip():
        return []
    bare = re.sub(r'"(?:[^"\\]|\\.)*"', lambda text: "\x00" * len(text[0]), code)  # no mutants inside string literals

    def mutant(operator, start, end, text):
        return Mutant(file, number, operator, code.strip(), (code[:start] + text + code[end:]).strip())

    out = []
    for operator, swaps in SWAPS.items():
        for find, replace in swaps.items():
            whole = rf"\b{find}\b" if find.isalpha() else re.escape(find)
            out += [mutant(operator, found.start(), found.end(), replace) for found in re.finditer(whole, bare)]
    out += [mutant("constant", found.start(), found.end(), changed_number(found[0])) for found in NUMBER.finditer(bare)]
    statement = code.strip()
    if STATEMENT.match(statement) and not statement.startswith(("return", "break", "continue", "using", "delete")):
        if statement.count("(") == statement.count(")"):  # not the end of a longer statement
            out.append(Mutant(file, number, "statement", statement, ";"))
    returned = RETURN.match(statement)
    if returned:
        for text in ("{}", f"!({returned[1]})"):
            if not returned[1].startswith("{") and returned[1] not in ("true", "false"):
                out.append(Mutant(file, number, "return", statement, f"return {text};"))
    return out


def of_file(root, file):
    """-> [Mutant] of a file; block comments are skipped."""
    out, inside = [], False
    for number, line in enumerate((root / file).read_text().splitlines(), 1):
        starts = "/*" in line
        if not inside and not starts:
            out += of_line(file, number, line)
        inside = (inside or starts) and "*/" not in line
    return out


def planted(text, mutant):
    """-> the file's text with the mutant in it. ValueError if its line has changed."""
    lines = text.split("\n")
    line = lines[mutant.line - 1]
    if without_comment(line).strip() != mutant.before:
        raise ValueError(f"{mutant.file}:{mutant.line} is no longer '{mutant.before}'")
    lines[mutant.line - 1] = line[:len(line) - len(line.lstrip())] + mutant.after
    return "\n".join(lines)
