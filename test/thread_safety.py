#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lets clang check (-Wthread-safety) that members marked ABSL_GUARDED_BY are touched under their mutex only.

    test/thread_safety.py BUILD     BUILD: a build folder with compile_commands.json

Every source is checked that has such a mark, or includes a header of ours that does.
"""

import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
CLANG = "clang++-16"
MARK = re.compile(r"\bABSL_(GUARDED_BY|PT_GUARDED_BY|EXCLUSIVE_LOCKS_REQUIRED|LOCKS_EXCLUDED)\b")
# What g++ alone understands, and what the check does not need.
DROPPED = re.compile(r"^(-Winvalid-pch|-fpch-preprocess|-W.*|-O\d|-o|-c|-M.*)$")


def marked_sources(commands):
    """The compiler commands of the sources that have marks, or include a header that has."""
    headers = subprocess.run(["git", "grep", "-lE", MARK.pattern.replace(r"\b", ""), "--", "*.hpp"], cwd=ROOT, capture_output=True,
                             text=True, check=False).stdout.split()
    names = {pathlib.Path(header).name for header in headers}
    for entry in commands:
        source = pathlib.Path(entry["file"])
        if not source.is_relative_to(ROOT) or source.is_relative_to(ROOT / "build"):
            continue
        text = source.read_text()
        if MARK.search(text) or any(f'/{name}"' in text for name in names):
            yield entry


def check(entry):
    """Clang's complaints about one source."""
    words = shlex.split(entry["command"])
    start = next(i for i, word in enumerate(words) if word.endswith(("c++", "g++"))) + 1
    arguments, skip = [], False
    for word in words[start:]:
        if skip:
            skip = False
        elif word in ("-o", "-MT", "-MF", "-include", "-c"):
            skip = word != "-c"
        elif not DROPPED.match(word):
            arguments.append(word)
    command = [CLANG, *arguments, "-fsyntax-only", "-w", "-Wthread-safety", "-Werror=thread-safety"]
    result = subprocess.run(command, cwd=entry["directory"], capture_output=True, text=True, check=False)
    return result.stderr if result.returncode else ""


def main():
    build = pathlib.Path(sys.argv[1])
    entries = list(marked_sources(json.loads((build / "compile_commands.json").read_text())))
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        for complaints in pool.map(check, entries):
            if complaints:
                failed += 1
                print(complaints, flush=True)
    print(f"thread safety: {len(entries)} sources, {failed} with faults")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
