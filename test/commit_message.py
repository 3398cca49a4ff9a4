#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the form of a commit message, given on standard input; the argument names the commit in complaints."""

import re
import sys

MOST_COLUMNS = 72
# Words that begin a subject in another mood than the imperative.
NOT_IMPERATIVE = re.compile(r"^(\w+(ed|ing)|\w+[^s\W]s)$", re.IGNORECASE)
IMPERATIVE_ALL_THE_SAME = {"bring", "embed", "feed", "need", "ping", "proceed", "seed", "shed", "speed", "spring", "string", "exceed"}


def faults(message):
    """Yields a sentence for each fault."""
    lines = message.rstrip().split("\n")
    subject = lines[0]
    if not subject.strip():
        yield "the subject is empty"
        return
    if len(subject) > MOST_COLUMNS:
        yield f"the subject has {len(subject)} columns; at most {MOST_COLUMNS} are allowed"
    if subject.endswith("."):
        yield "the subject ends with a period"
    first = re.split(r"[\s:,]", subject, maxsplit=1)[0]
    if not first[:1].isupper():
        yield "the subject does not begin with a capital letter"
    if NOT_IMPERATIVE.match(first) and first.lower() not in IMPERATIVE_ALL_THE_SAME:
        yield f"the subject begins with '{first}', which is not imperative"
    if len(lines) > 1 and lines[1].strip():
        yield "the second line is not blank"


def main():
    name = sys.argv[1] if len(sys.argv) > 1 else "the message"
    message = sys.stdin.read()
    found = list(faults(message))
    for fault in found:
        print(f"{name}, '{message.splitlines()[0] if message.strip() else ''}': {fault}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
