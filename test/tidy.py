#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy over our sources in a build folder (not the tests).

Without --all it looks at the sources that changed since a base, and at one source that includes each changed header. A source
that passed before is not looked at again until it, a file that it includes, its compiler command or a .clang-tidy changes; this
is remembered in $XDG_CACHE_HOME/segserve/tidy and holds across build folders.
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
CACHE = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "segserve" / "tidy"
TIDY = "clang-tidy-16"  # 14, the default of bookworm, does not understand the ranges of its libstdc++
PROTO_FILES = sorted((ROOT / "proto").rglob("*.proto"))
CONFIGURATIONS = [ROOT / ".clang-tidy", *sorted((ROOT / "core").rglob(".clang-tidy"))]
SECONDS_A_SOURCE = 12  # of one processor, about
NOISE = re.compile(r"^\d+ warnings? .*generated\.$|^Suppressed |^Use -header-filter|^\d+ warnings? treated as errors?$")


def included_files(build):
    """Object file -> the files of the project (not the system's) that its source includes."""
    lines = subprocess.run(["ninja", "-C", build, "-t", "deps"], capture_output=True, text=True, check=True).stdout
    files, current = {}, []
    for line in lines.splitlines():
        if line.startswith("    "):
            path = (build / line.strip()).resolve()
            if not path.is_relative_to("/usr"):
                current.append(path)
        elif ": #deps" in line:
            current = files.setdefault(line.split(":", 1)[0], [])
    return files


def without_precompiled_header(command):
    """A compiler command as it would be without: each source must include what it uses."""
    return re.sub(r" -Winvalid-pch| -fpch-preprocess| -include \S*/cmake_pch\.hxx", "", command)


def fingerprint(entry, files, tidy_version):
    """A hash of all that the verdict on a source depends on; None where that is not known (it was never compiled)."""
    if not files:
        return None
    # What a precompiled header holds is not among a source's dependencies: of the project, that is only proto/.
    if any(path.name.startswith("cmake_pch") for path in files):
        files = [path for path in files if not path.name.startswith("cmake_pch")] + PROTO_FILES
    digest = hashlib.sha256(tidy_version)
    for configuration in CONFIGURATIONS:
        digest.update(configuration.read_bytes())
    digest.update(entry["command"].replace(str(ROOT), "").encode())
    for path in sorted(files):
        if not path.exists():
            return None
        digest.update(path.read_bytes())
    return digest.hexdigest()


def git(*arguments):
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()


def base_commit():
    """The commit since which sources count as changed: $LINT_BASE, the fork from origin/main, or the last of the day before."""
    wanted = os.environ.get("LINT_BASE") or git("merge-base", "HEAD", "origin/main")
    if wanted and git("rev-parse", wanted) != git("rev-parse", "HEAD"):
        return wanted
    return git("rev-list", "-1", "--before=24 hours ago", "HEAD") or git("hash-object", "-t", "tree", "/dev/null")


def changed_since(base):
    """The files of ours that differ from the base, new ones too."""
    names = git("diff", "--name-only", base).splitlines() + git("ls-files", "-o", "--exclude-standard").splitlines()
    return {(ROOT / name).resolve() for name in names}


def select_changed(sources, files, changed):
    """The changed ones of the sources, and for each changed header without a changed source that includes it one that does.

    `files`: source -> the files that it includes.
    """
    selected = {source for source in sources if source in changed}
    covered = {path for source in selected for path in files.get(source, [])}
    for header in sorted(path for path in changed if path.suffix in (".hpp", ".h") and path not in covered):
        includer = next((source for source in sorted(sources) if header in files.get(source, [])), None)
        if includer:
            selected.add(includer)
            covered.update(files[includer])
    return selected


def check(source, database):
    """The complaints about one source, "" if there are none."""
    result = subprocess.run(
        [TIDY, "--quiet", "-p", database, "--extra-arg=-Wno-error", source],
        capture_output=True, text=True, check=False)
    complaints = [line for line in (result.stdout + result.stderr).splitlines() if line and not NOISE.match(line)]
    return "\n".join(complaints) if result.returncode else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build", type=pathlib.Path, help="a build folder in which everything is built, with ninja")
    parser.add_argument("pattern", nargs="?", default="", help="only sources whose path contains this")
    parser.add_argument("--all", action="store_true", help="all sources, not only those that changed")
    parser.add_argument("--minutes", type=float, help="stop after this time and leave the rest to a later run")
    parser.add_argument("-j", "--jobs", type=int, default=len(os.sched_getaffinity(0)))
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    started = time.monotonic()

    commands = json.loads((build / "compile_commands.json").read_text())
    for entry in commands:
        entry["command"] = without_precompiled_header(entry["command"])
    database = build / "tidy"
    database.mkdir(exist_ok=True)
    (database / "compile_commands.json").write_text(json.dumps(commands))
    dependencies = included_files(build)
    version = subprocess.run([TIDY, "--version"], capture_output=True, check=True).stdout
    entries = {}
    for entry in commands:
        source = pathlib.Path(entry["file"]).resolve()
        if not source.is_relative_to(build) and source.is_relative_to(ROOT) and not source.is_relative_to(ROOT / "test"):
            entries[source] = entry
    files = {source: dependencies.get(entry.get("output")) or [] for source, entry in entries.items()}
    wanted = {source for source in entries if arguments.pattern in str(source.relative_to(ROOT))}
    if not arguments.all and not arguments.pattern:
        base = base_commit()
        wanted = select_changed(entries, files, changed_since(base))
        print(f"clang-tidy: sources that changed since {base[:12]}")
    keys = {source: fingerprint(entries[source], files[source], version) for source in sorted(wanted)}
    todo = {source: key for source, key in keys.items() if not key or not (CACHE / key).exists()}

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
        verdicts = pool.map(lambda source: check(source, database) if time.monotonic() < deadline else None, todo)
        for (source, key), complaints in zip(todo.items(), verdicts):
            if complaints is None:
                left += 1
            elif complaints:
                failed += 1
                print(f"{source.relative_to(ROOT)}:\n{complaints}\n", flush=True)
            elif key:
                (CACHE / key).touch()
    print(f"clang-tidy: {len(todo) - left} sources looked at, {failed} with faults, {len(keys) - len(todo)} unchanged since they "
          f"passed, {left} left for a run with more time ({time.monotonic() - started:.0f} s)")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
