# SPDX-License-Identifier: Apache-2.0
"""Finds the commands in documents, for the test that runs them and for docs/site, which makes figures by them.

The words behind the language of a fenced block, which GitHub does not show, say what the test does with it: "```sh not run: needs a
Docker engine", "```sh shortened".
"""
import re
import shlex
from typing import NamedTuple

NOT_RUN, SHORTENED = "not run: ", "shortened"
OUTPUT_FLAGS = ("-o", "--output", "--picture", "--plain-picture", "--json", "--result", "--out-dir", "--depth", "--rgb", "--html",
                "--csv", "--hdr-log")


class Block(NamedTuple):
    """A fenced block of a document."""

    section: str  # the ## heading above it
    language: str
    note: str  # the words behind the language
    content: str

    @property
    def not_run(self):
        return self.note.startswith(NOT_RUN)

    @property
    def shortened(self):
        return self.note == SHORTENED


def blocks(text):
    """The fenced blocks of a document."""
    found, section = [], ""
    for part in re.finditer(r"^## (?P<section>[^\n]+)$|^```(?P<language>\w*)(?P<note>[^\n]*)\n(?P<content>.*?)^```$", text,
                            re.M | re.S):
        if part["section"]:
            section = part["section"]
        else:
            found.append(Block(section, part["language"], part["note"].strip(), part["content"]))
    return found


def commands(block):
    """The commands of a ```sh block, without its comments and empty lines."""
    lines = [line.strip() for line in block.replace("\\\n", " ").splitlines()]
    return [line for line in lines if line and not line.startswith("#")]


def output_files(command):
    """The files and folders that a command is told to write."""
    words = shlex.split(command, comments=True)
    return [name for flag, name in zip(words, words[1:]) if flag in OUTPUT_FLAGS and name != "-"]
