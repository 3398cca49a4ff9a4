#!/usr/bin/env python3
"""Runs clang-tidy over our sources in a build folder (not the tests); what passed before is not looked at again.

A source is looked at when it, a file it includes (ours or generated), its compiler command or a .clang-tidy has
changed since it last passed. What passed is remembered in $XDG_CACHE_HOME/segserve/tidy, so it holds across build folders.
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
    files = included_files(build)
    version = subprocess.run([TIDY, "--version"], capture_output=True, check=True).stdout
    todo = {}
    passed_before = 0
    for entry in commands:
        source = pathlib.Path(entry["file"]).resolve()
        if source.is_relative_to(build) or not source.is_relative_to(ROOT) or source.is_relative_to(ROOT / "test"):
            continue
        if arguments.pattern not in str(source.relative_to(ROOT)):
            continue
        key = fingerprint(entry, files.get(entry.get("output")), version)
        if key and (CACHE / key).exists():
            passed_before += 1
        else:
            todo[source] = key

    CACHE.mkdir(parents=True, exist_ok=True)
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for (source, key), complaints in zip(todo.items(), pool.map(lambda s: check(s, database), todo)):
            if complaints:
                failed += 1
                print(f"{source.relative_to(ROOT)}:\n{complaints}\n", flush=True)
            elif key:
                (CACHE / key).touch()
    print(f"clang-tidy: {len(todo)} sources looked at, {failed} with faults, {passed_before} unchanged since they passed "
          f"({time.monotonic() - started:.0f} s)")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
