#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the instructions of one segmentation, which do not depend on other load of the machine, with a budget.

    test/bench/instructions.py [--build build/release] [--record]

Fails if a method takes more than 10 % above its budget in test/bench/instructions.json. --record writes the counts of
this build as the new budget: do so when a change makes it faster, or when a change is worth its cost (and say why in the
commit). Counts are those of the AVX2 code. On a CPU without AVX2 they are not compared (exit code 77).
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

BUDGET = pathlib.Path(__file__).with_suffix(".json")
METHODS = ("border", "lambda-convex")
TOLERANCE = 0.10
SKIPPED = 77


def count(program, method):
    """The instructions that valgrind saw from START to DUMP in count_instructions."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "callgrind.out"
        done = subprocess.run(
            ["valgrind", "--tool=callgrind", "--instr-atstart=no", f"--callgrind-out-file={out}", program, method],
            capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"count_instructions {method}: {done.stderr}")
        return int(re.search(r"^(?:summary|totals): (\d+)", out.with_name("callgrind.out.1").read_text(), re.MULTILINE).group(1))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("--record", action="store_true")
    arguments = parser.parse_args()
    if " avx2 " not in pathlib.Path("/proc/cpuinfo").read_text():
        print("skipped: the budget is that of the AVX2 code, and this CPU has no AVX2")
        return SKIPPED
    counts = {method: count(arguments.build / "test/bench/count_instructions", method) for method in METHODS}
    if arguments.record:
        BUDGET.write_text(json.dumps(counts, indent=2) + "\n")
    budget = json.loads(BUDGET.read_text())
    exceeded = False
    for method, instructions in counts.items():
        change = instructions / budget[method] - 1
        exceeded |= change > TOLERANCE
        print(f"{method}: {instructions / 1e6:.1f} million instructions, {change:+.1%} of the budget"
              f"{': TOO MANY' if change > TOLERANCE else ''}")
        if change < -TOLERANCE:
            print(f"{method}: --record it, so that it stays so")
    return 1 if exceeded else 0


if __name__ == "__main__":
    sys.exit(main())
