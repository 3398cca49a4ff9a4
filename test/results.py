#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reads what ctest wrote of its tests.

    test/results.py failed FOLDER                     the names of the tests that failed, a line each
    test/results.py summary PASSED FAILED FOLDER ..   the tests that failed, with the end of their output, and a line that counts all
                                                      tests, and so many that passed and failed elsewhere

A FOLDER is one of a build. It has ctest.xml, of all tests, and may have alone.xml, of tests that failed and ran once more.
"""
import pathlib
import sys
import xml.etree.ElementTree as xml

ALL, ALONE = "ctest.xml", "alone.xml"
LINES = 30  # of the output of a test that failed


def read(path):
    """The tests of a report by their names, or {} if there is no report."""
    return {test.get("name"): test for test in xml.parse(path).getroot().iter("testcase")} if path.exists() else {}


def state(test):
    """"passed", "failed" or "skipped", which stands for tests that were disabled, too."""
    return {"run": "passed", "fail": "failed"}.get(test.get("status"), "skipped")


def failed(folder):
    """The tests of a build that failed, also alone if they ran once more."""
    tests = read(folder / ALL) | read(folder / ALONE)
    return {name: test for name, test in tests.items() if state(test) == "failed"}


def summary(passed_elsewhere, failed_elsewhere, folders):
    """The lines of the summary."""
    counts = {"passed": passed_elsewhere, "failed": failed_elsewhere, "skipped": 0}
    lines = []
    for folder in folders:
        alone = read(folder / ALONE)
        for name, test in (read(folder / ALL) | alone).items():
            counts[state(test)] += 1
            if state(test) == "failed":
                lines.append(f"{folder}: {name} failed. Its output ends with:")
                lines += [f"  {line}" for line in (test.findtext("system-out") or "").splitlines()[-LINES:]]
            elif name in alone:
                lines.append(f"{folder}: {name} failed beside other tests, and passed alone.")
    return [*lines, ", ".join(f"{count} {name}" for name, count in counts.items())]


def main(arguments):
    match arguments:
        case ["failed", folder]:
            print("".join(f"{name}\n" for name in failed(pathlib.Path(folder))), end="")
        case ["summary", passed, failures, *folders]:
            print("\n".join(summary(int(passed), int(failures), map(pathlib.Path, folders))))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
