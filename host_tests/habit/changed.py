# SPDX-License-Identifier: BSD-3-Clause
"""Which tracked files a change touches: tidy.py and headers.py check only these unless they are called with --all."""
import os
import subprocess


def git(root, *words):
    return subprocess.run(["git", *words], cwd=root, capture_output=True, text=True)


def base_of(root, wanted=None):
    """-> the commit to compare with: `wanted` (or $M100_BASE), otherwise the commit where this branch left origin/main,
    otherwise the parent of HEAD. None: there is no such commit."""
    for name in (wanted, os.environ.get("M100_BASE")):
        if name:
            return git(root, "rev-parse", "--verify", name + "^{commit}").stdout.strip() or None
    head = git(root, "rev-parse", "HEAD").stdout.strip()
    left = git(root, "merge-base", "HEAD", "origin/main").stdout.strip()
    if left and left != head:
        return left
    return git(root, "rev-parse", "--verify", "--quiet", "HEAD~1").stdout.strip() or None


MAX_FILES = 60  # files; of a larger change, only the last commit is checked by day, and all files at night


def touched(root, base):
    """Names of the files that differ from the base in the working tree."""
    return git(root, "diff", "--name-only", "--diff-filter=d", base).stdout.split()


def files(root, endings, everything=False, base=None):
    """Tracked, hand-written files with one of the endings: all of them, or those that differ from the base in the
    working tree. If these are more than MAX_FILES and no base was given, those of the last commit."""
    since = None if everything else base_of(root, base)
    names = touched(root, since) if since else git(root, "ls-files").stdout.split()
    wanted = [name for name in names if name.endswith(endings) and "/generated/" not in name]
    if since and not base and not os.environ.get("M100_BASE") and len(wanted) > MAX_FILES:
        print(f"{len(wanted)} files differ from {since[:8]}: checking only those of the last commit (the nightly run checks all)")
        wanted = [name for name in touched(root, "HEAD~1") if name.endswith(endings) and "/generated/" not in name]
    return sorted(wanted)
