# SPDX-License-Identifier: BSD-3-Clause
"""Which tracked files a change touches: what tidy and headers look at when they are not asked for everything."""
import os
import subprocess


def git(root, *words):
    return subprocess.run(["git", *words], cwd=root, capture_output=True, text=True)


def base_of(root, wanted=None):
    """The commit that a change is compared with: the one that is wanted (or $M100_BASE), else where this branch left
    origin/main, else the last commit before this one. None: there is no such commit."""
    for name in (wanted, os.environ.get("M100_BASE")):
        if name:
            return git(root, "rev-parse", "--verify", name + "^{commit}").stdout.strip() or None
    head = git(root, "rev-parse", "HEAD").stdout.strip()
    left = git(root, "merge-base", "HEAD", "origin/main").stdout.strip()
    if left and left != head:
        return left
    return git(root, "rev-parse", "--verify", "--quiet", "HEAD~1").stdout.strip() or None


MOST = 60  # files; a larger change is looked at file by file as it grows, commit by commit, and whole at night


def touched(root, base):
    """Names of the files that differ from the base in the working tree."""
    return git(root, "diff", "--name-only", "--diff-filter=d", base).stdout.split()


def files(root, endings, everything=False, base=None):
    """Tracked, hand-written files with one of the endings: all of them, or those that differ from the base in the
    working tree. Where those are more than MOST and nobody asked for that base, those of the last commit."""
    since = None if everything else base_of(root, base)
    names = touched(root, since) if since else git(root, "ls-files").stdout.split()
    wanted = [name for name in names if name.endswith(endings) and "/generated/" not in name]
    if since and not base and not os.environ.get("M100_BASE") and len(wanted) > MOST:
        print(f"{len(wanted)} files differ from {since[:8]}: here those of the last commit, all of them at night")
        wanted = [name for name in touched(root, "HEAD~1") if name.endswith(endings) and "/generated/" not in name]
    return sorted(wanted)
