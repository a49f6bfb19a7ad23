#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Deepest call path of an image, from GCC's call graph (-fcallgraph-info=su); promise R8.

Usage: stack_report.py IMAGE.elf BUILD_DIR BUDGET.txt [--paths N]     exit 1: recursion, unbounded frame, over budget
       stack_report.py --self-test

Functions without a .ci file (libgcc, newlib) are disassembled: pushes and subtractions from sp. An indirect call
(virtual function, function pointer) may reach every function whose address stands in the image's constants, except
where INDIRECT below narrows it. Deepest path = main's, plus one exception frame and the deepest interrupt handler; the
limit is half of stack_bytes.
"""
import collections
import pathlib
import re
import subprocess
import sys

EXCEPTION_FRAME = 8 * 4 + 18 * 4 + 8  # integer registers, FPU registers, alignment
OBJDUMP = "arm-none-eabi-objdump"
NM = "arm-none-eabi-nm"
READELF = "arm-none-eabi-readelf"
# caller -> the only callees its indirect calls can reach, both as regular expressions over mangled names.
INDIRECT = [
    (r"16assertion_failed", r"(emergency|on_assertion)"),  # the assertion handler, installed by main
    (r"^Reset_Handler$", r"^_GLOBAL__sub_I_"),  # static constructors
    (r"13HorizontalMpcIfE", r"13solve_previewIfE"),  # the copy of the law for this machine, in its own scalar
    (r"13HorizontalMpcIdE", r"13solve_previewIdE"),
    (r"^_ZN4m1008protocol", r"^_ZNK4m1008protocol6Aes256"),  # the one interface of the protocol: its cipher
]


class Graph:
    def __init__(self):
        self.stack = {}
        self.edges = collections.defaultdict(set)
        self.unbounded = []

    def read_ci(self, path):
        for line in path.read_text().splitlines():
            node = re.match(r'node: \{ title: "([^"]+)" label: "([^"]*)"', line)
            if node:
                size = re.search(r"(\d+) bytes \(([\w,]+)\)", node.group(2))
                if size:
                    name = short(node.group(1))
                    self.stack[name] = max(self.stack.get(name, 0), int(size.group(1)))
                    if size.group(2) not in ("static", "dynamic,bounded"):
                        self.unbounded.append(name)
                continue
            edge = re.match(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', line)
            if edge:
                self.edges[short(edge.group(1))].add(short(edge.group(2)))


def short(title):
    return title.rsplit(":", 1)[-1].lstrip("*")


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def image_functions(image):
    """-> {address: name}, the functions that the image really contains."""
    found = {}
    for line in run(NM, image).splitlines():
        words = line.split()
        if len(words) == 3 and words[1] in "TtWw":
            found[int(words[0], 16) & ~1] = words[2]
    return found


def aliases(image):
    """Symbols at the same address (complete and base constructors, weak handlers)."""
    by_address = collections.defaultdict(set)
    for line in run(NM, image).splitlines():
        words = line.split()
        if len(words) == 3 and words[1] in "TtWw":
            by_address[int(words[0], 16) & ~1].add(words[2])
    return by_address


SECTIONS = (".text", ".rodata", ".data", ".init_array")


def relocated(image):
    """Addresses of the words in which the linker wrote an address; other words that look like one are numbers."""
    out, inside = set(), False
    for line in run(READELF, "--relocs", "--wide", image).splitlines():
        section = re.match(r"Relocation section '\.rel(\.\w+)'", line)
        inside = section.group(1) in SECTIONS if section else inside
        words = line.split()
        if inside and len(words) > 2 and words[2] in ("R_ARM_ABS32", "R_ARM_TARGET1"):
            out.add(int(words[0], 16))
    return out


def address_taken(image, by_address):
    """Functions whose address, with the Thumb bit, occurs in a constant: vtables, tables of pointers, literals."""
    taken, addresses = set(), relocated(image)
    for section in SECTIONS:
        dump = subprocess.run([OBJDUMP, "-s", "-j", section, image], capture_output=True, text=True).stdout
        for line in dump.splitlines():
            row = re.match(r"^ ([0-9a-f]+) ((?:[0-9a-f]{8} ?){1,4})", line)
            for number, word in enumerate(row.group(2).split() if row else []):
                value = int.from_bytes(bytes.fromhex(word), "little")
                if value & 1 and (value & ~1) in by_address and int(row.group(1), 16) + 4 * number in addresses:
                    taken |= by_address[value & ~1]
    if not taken:
        sys.exit(f"error: {image}: no function's address is taken; was it linked with --emit-relocs?")
    return taken


def disassembled(image, name):
    """-> stack of one function and its callees, from its instructions."""
    text = run(OBJDUMP, "-d", f"--disassemble={name}", image)
    stack = 0
    callees = set()
    for line in text.splitlines():
        push = re.search(r"\t(?:push|stmdb)\s+.*?\{([^}]*)\}", line)
        if push and ("push" in line or "sp!" in line):
            for part in push.group(1).split(","):
                ends = part.strip().split("-")
                stack += 4 if len(ends) == 1 else 4 * (register(ends[1]) - register(ends[0]) + 1)
        vpush = re.search(r"\tvpush\s+\{([^}]*)\}", line)
        if vpush:
            ends = vpush.group(1).split("-")
            stack += 8 * (1 if len(ends) == 1 else int(ends[1][1:]) - int(ends[0][1:]) + 1)
        sub = re.search(r"\tsubw?(?:\.w)?\s+sp,(?: sp,)? #(\d+)", line)
        stack += int(sub.group(1)) if sub else 0
        call = re.search(r"\t(?:bl|b|b\.w|b\.n)\s+[0-9a-f]+ <([^+>]+)>", line)
        if call and call.group(1) != name:
            callees.add(call.group(1))
    return stack, callees


def register(name):
    return {"sp": 13, "lr": 14, "pc": 15, "ip": 12, "fp": 11, "sl": 10}.get(name.strip()) or int(name.strip()[1:])


def deepest(graph, root, resolve):
    """-> bytes and path of the deepest calls from root. Raises RecursionError, naming the cycle."""
    best = {}
    active = []

    def visit(name):
        if name in best:
            return best[name]
        if name in active:
            raise RecursionError(" -> ".join(active[active.index(name):] + [name]))
        active.append(name)
        depth, path = 0, []
        for callee in sorted(resolve(name)):
            below, below_path = visit(callee)
            if below > depth:
                depth, path = below, below_path
        active.pop()
        best[name] = (graph.stack.get(name, 0) + depth, [name] + path)
        return best[name]

    return visit(root)


def demangled(names):
    done = subprocess.run(["c++filt"], input="\n".join(names), capture_output=True, text=True).stdout.splitlines()
    return done if len(done) == len(names) else names


def analyse(image, build):
    graph = Graph()
    own = re.sub(r"\.elf$", "", pathlib.Path(image).name)
    programs = {re.sub(r"\.elf$", "", p.name) for p in pathlib.Path(build).rglob("*.elf")}
    for path in sorted(pathlib.Path(build).rglob("*.ci")):
        target = next((part[:-4] for part in path.parts if part.endswith(".dir")), "")
        if target == own or (target not in programs and not target.startswith("forbidden_")):
            graph.read_ci(path)
    by_address = aliases(image)
    present = set().union(*by_address.values())
    taken = address_taken(image, by_address)
    same = {name: sorted(group)[0] for group in by_address.values() for name in group}

    def known(name):
        if name not in graph.stack and name in present:
            # a copy under another symbol, for instance a constructor's second name
            for other in by_address[next(a for a, g in by_address.items() if name in g)]:
                if other in graph.stack:
                    return other
            graph.stack[name], callees = disassembled(image, name)
            graph.edges[name] |= callees
        return name

    def is_common(name):
        """Whether any indirect call may reach it: not interrupt handlers, nor callees that INDIRECT reserves."""
        return not (name.endswith("_Handler") or name == "main" or any(re.search(c, name) for _, c in INDIRECT))

    def resolve(name):
        callees = set()
        for callee in graph.edges[name]:
            if callee == "__indirect_call":
                allowed = next((c for f, c in INDIRECT if re.search(f, name)), None)
                callees |= {known(n) for n in taken if (re.search(allowed, n) if allowed else is_common(n))}
            elif callee in present:
                callees.add(known(callee))
        return callees - ({name} if name not in graph.edges[name] else set())

    return graph, resolve, present, known, same


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    image, build, budget_file = sys.argv[1:4]
    reserved = next(int(line.split()[1]) for line in open(budget_file, encoding="utf-8") if line.startswith("stack_bytes"))
    sys.setrecursionlimit(10000)
    graph, resolve, present, known, _ = analyse(image, build)
    failed = False
    for name in sorted(set(graph.unbounded) & present):
        print(f"error: the frame of {demangled([name])[0]} has no bound", file=sys.stderr)
        failed = True
    try:
        program, path = deepest(graph, known("Reset_Handler"), resolve)
        handlers = [n for n in present if n.endswith("_Handler") and n != "Reset_Handler"]
        interrupt, interrupt_path = max(deepest(graph, known(h), resolve) for h in handlers)
    except RecursionError as cycle:
        print(f"error: recursion: {cycle}", file=sys.stderr)
        return 1
    for title, names in (("deepest path", path), ("deepest interrupt", interrupt_path)):
        print(f"{title}:")
        for name, text in zip(names, demangled(names)):
            print(f"  {graph.stack.get(name, 0):>6}  {text[:120]}")
    total = program + EXCEPTION_FRAME + interrupt
    print(f"stack: {program} + {EXCEPTION_FRAME} (exception frame) + {interrupt} (interrupt) = {total} of {reserved} bytes;"
          f" at most {reserved // 2} allowed")
    if total > reserved // 2:
        print(f"error: budget.txt: stack_bytes: the deepest path needs {total}, half of it is {reserved // 2}", file=sys.stderr)
        failed = True
    return 1 if failed else 0


def self_test():
    """Tests that recursion is found, and that the deeper of two paths is taken."""
    graph = Graph()
    graph.stack = {"a": 8, "b": 16, "c": 100, "d": 4}
    graph.edges.update({"a": {"b", "c"}, "b": {"d"}, "c": {"d"}})
    depth, path = deepest(graph, "a", lambda n: graph.edges[n])
    graph.edges["d"] = {"b"}
    try:
        deepest(graph, "a", lambda n: graph.edges[n])
        return 1
    except RecursionError:
        return 0 if (depth, path) == (112, ["a", "c", "d"]) else 1


if __name__ == "__main__":
    sys.exit(main())
