#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy over our sources, not the tests.

Without --all it looks at the sources that changed since a base, and at one source that includes each changed header. A source
that passed before is not looked at again until it, a file that it includes, its compiler command or a .clang-tidy changes; this
is remembered in $XDG_CACHE_HOME/segserve/tidy and holds across clones.
"""

import argparse
import concurrent.futures
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import time

import compile_commands
import include_graph

ROOT = pathlib.Path(__file__).resolve().parent.parent
CACHE = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "segserve" / "tidy"
TIDY = "clang-tidy-16"  # 14, the default of bookworm, does not understand the ranges of its libstdc++
SECONDS_A_SOURCE = 12  # of one processor, about
NOISE = re.compile(r"^\d+ warnings? .*generated\.$|^Suppressed |^Use -header-filter|^\d+ warnings? treated as errors?$")


def git(*arguments):
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()


def base_commit():
    """The commit since which sources count as changed: $LINT_BASE, the fork from origin/main, or the last of the day before."""
    wanted = os.environ.get("LINT_BASE") or git("merge-base", "HEAD", "origin/main")
    if wanted and git("rev-parse", wanted) != git("rev-parse", "HEAD"):
        return wanted
    return git("rev-list", "-1", "--before=24 hours ago", "HEAD") or git("hash-object", "-t", "tree", "/dev/null")


def changed_since(base):
    """The files that differ from the base, new ones too."""
    return set(git("diff", "--name-only", base).splitlines() + git("ls-files", "-o", "--exclude-standard").splitlines())


def select_changed(sources, graph, changed):
    """The changed ones of the sources, and for each changed header that none of them includes one source that does.

    `graph`: path -> the files of ours that it includes.
    """
    reachable = {source: include_graph.reachable(source, graph) for source in sources}
    selected = {source for source in sources if source in changed}
    covered = set().union(*(reachable[source] for source in selected))
    for header in sorted(path for path in changed if path.endswith(".hpp")):
        includers = [source for source in sources if header in reachable[source]]
        if includers and header not in covered:
            own = header.removesuffix(".hpp") + ".cpp"
            direct = [source for source in includers if header in graph[source]]
            includer = own if own in includers else min(direct or includers)
            selected.add(includer)
            covered |= reachable[includer]
    return selected


def common_fingerprint():
    """A hash of what every verdict depends on: clang-tidy, its configuration, and the API from which headers are generated."""
    digest = hashlib.sha256(subprocess.run([TIDY, "--version"], capture_output=True, check=True).stdout)
    for path in [*sorted(ROOT.glob(".clang-tidy")), *sorted(ROOT.glob("core/**/.clang-tidy")), *sorted(ROOT.glob("proto/**/*.proto"))]:
        digest.update(path.read_bytes())
    return digest.digest()


def fingerprint(source, entry, graph, common):
    """A hash of all that the verdict on a source depends on."""
    digest = hashlib.sha256(common)
    digest.update(entry["command"].replace(str(ROOT), "").encode())
    for path in sorted(include_graph.reachable(source, graph)):
        digest.update(path.encode() + b"\0" + (ROOT / path).read_bytes())
    return digest.hexdigest()


def check(source):
    """The complaints about one source, "" if there are none."""
    command = [TIDY, "--quiet", "-p", str(compile_commands.BUILD), "--extra-arg=-Wno-error", str(ROOT / source)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    complaints = [line for line in (result.stdout + result.stderr).splitlines() if line and not NOISE.match(line)]
    return "\n".join(complaints) if result.returncode else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pattern", nargs="?", default="", help="only sources whose path contains this")
    parser.add_argument("--all", action="store_true", help="all sources, not only those that changed")
    parser.add_argument("--minutes", type=float, help="stop after this time and leave the rest to a later run")
    parser.add_argument("-j", "--jobs", type=int, default=len(os.sched_getaffinity(0)))
    arguments = parser.parse_args()
    started = time.monotonic()

    graph = include_graph.graph_of(include_graph.own_sources())
    entries = {source: entry for source, entry in compile_commands.load().items() if not source.startswith("test/")}
    wanted = {source for source in entries if arguments.pattern in source}
    if not arguments.all and not arguments.pattern:
        base = base_commit()
        wanted = select_changed(sorted(entries), graph, changed_since(base))
        print(f"clang-tidy: sources that changed since {base[:12]}")
    common = common_fingerprint()
    keys = {source: fingerprint(source, entries[source], graph, common) for source in sorted(wanted)}
    todo = {source: key for source, key in keys.items() if not (CACHE / key).exists()}

    # A change of nearly everything does not fit into the time of a run for each change, and a verdict on some of it would
    # depend on the order of files.
    if arguments.minutes and len(todo) * SECONDS_A_SOURCE > 60 * arguments.minutes * arguments.jobs:
        print(f"clang-tidy: {len(todo)} sources changed, more than {arguments.minutes:g} minutes are enough for. "
              "NOT CHECKED: run test/lint tidy --all, as every night does")
        return 0

    CACHE.mkdir(parents=True, exist_ok=True)
    deadline = started + 60 * arguments.minutes if arguments.minutes else float("inf")
    failed, left = 0, 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        verdicts = pool.map(lambda source: check(source) if time.monotonic() < deadline else None, todo)
        for (source, key), complaints in zip(todo.items(), verdicts):
            if complaints is None:
                left += 1
            elif complaints:
                failed += 1
                print(f"{source}:\n{complaints}\n", flush=True)
            else:
                (CACHE / key).touch()
    print(f"clang-tidy: {len(todo) - left} sources looked at, {failed} with faults, {len(keys) - len(todo)} unchanged since they "
          f"passed, {left} left for a run with more time ({time.monotonic() - started:.0f} s)")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
