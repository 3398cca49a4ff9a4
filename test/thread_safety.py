#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lets clang check (-Wthread-safety) that members marked ABSL_GUARDED_BY are touched under their lock only.

Every source is checked that has such a mark, or includes a header of ours that does.
"""

import concurrent.futures
import os
import re
import shlex
import subprocess
import sys

import compile_commands
import include_graph

CLANG = "clang++-16"
MARK = re.compile(r"\bABSL_(PT_)?(GUARDED_BY|(EXCLUSIVE|SHARED)_LOCK(S_REQUIRED|_FUNCTION)|LOCKS_EXCLUDED|SCOPED_LOCKABLE)\b")


def marked_sources(texts, sources):
    """Those of the sources that have marks or include a header that has. `texts`: path -> text of all files of ours."""
    marked = {path for path, text in texts.items() if MARK.search(text)}
    graph = include_graph.graph_of(texts)
    return [source for source in sources if marked & {source, *graph[source]}]


def check(entry):
    """Clang's complaints about one source."""
    words = shlex.split(entry["command"])[1:]
    output = words.index("-o")
    arguments = [word for word in words[:output] + words[output + 2:] if not word.startswith("-W")]
    command = [CLANG, *arguments, "-fsyntax-only", "-Wno-everything", "-Wthread-safety", "-Werror=thread-safety"]
    result = subprocess.run(command, cwd=entry["directory"], capture_output=True, text=True, check=False)
    return result.stderr if result.returncode else ""


def main():
    entries = compile_commands.load()
    sources = marked_sources(include_graph.own_sources(), sorted(entries))
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        for complaints in pool.map(lambda source: check(entries[source]), sources):
            if complaints:
                failed += 1
                print(complaints, flush=True)
    print(f"thread safety: {len(sources)} sources, {failed} with faults")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
