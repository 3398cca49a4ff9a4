# SPDX-License-Identifier: Apache-2.0
"""The shell commands of README.md work as they stand, in the order in which they stand, and print what it shows.

README.md keeps these rules:
- Commands are in ```sh blocks. The commands of a section (## heading) are run unless the section is in NOT_RUN.
- A command is one line, or several that end with a backslash. It runs in a shell of its own: `cd` and variables do not
  last until the next command, files do.
- A command that ends with & is a server on segctl's default address.
- Commands may use files that earlier commands have made, and the folder SCANS, which holds a few scenes.
- A ```json block in a section that is run is a valid JSON object. It is part of what an earlier command has printed: keys may be
  missing, and numbers are rounded to the digits that are shown.
"""
import contextlib
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import unittest

from harness import FAILED, SEGCTL, SEGSERVE, SUCCESS

README = pathlib.Path(__file__).resolve().parents[2] / "README.md"
SCANS = "scans"
PORT = 50051

NOT_RUN = {
    "Try it": "builds everything: docker/fresh-machine runs deploy/demo, and test/run is what runs this test",
    "Install": "builds everything: test/package installs segserve and builds a program with it",
    "Run it as a container": "needs a Docker engine: docker/test builds the image and uses it",
}

OUTPUT_FLAGS = ("-o", "--output", "--picture", "--plain-picture", "--json", "--result", "--out-dir", "--depth", "--rgb")


class Shown(float):
    """A number with the digits that README.md shows."""

    def __new__(cls, text):
        number = super().__new__(cls, text)
        number.text = text
        return number

    def shows(self, number):
        decimals = len(self.text.partition(".")[2])
        return isinstance(number, (int, float)) and f"{number:.{decimals}f}" == self.text


def blocks(text):
    """The fenced blocks: (section, language, content)."""
    found, section = [], ""
    for part in re.finditer(r"^## (?P<section>[^\n]+)$|^```(?P<language>\w*)\n(?P<content>.*?)^```$", text, re.M | re.S):
        if part["section"]:
            section = part["section"]
        else:
            found.append((section, part["language"], part["content"]))
    return found


def commands(block):
    """The commands of a ```sh block, without its comments and empty lines."""
    lines = [line.strip() for line in block.replace("\\\n", " ").splitlines()]
    return [line for line in lines if line and not line.startswith("#")]


def is_part(shown, told):
    """Whether a shown JSON value agrees with the one that a command has printed."""
    if isinstance(shown, dict):
        return isinstance(told, dict) and all(key in told and is_part(shown[key], told[key]) for key in shown)
    if isinstance(shown, list):
        return isinstance(told, list) and len(shown) == len(told) and all(map(is_part, shown, told))
    return shown.shows(told) if isinstance(shown, Shown) else shown == told


def all_values(value):
    """A JSON value and all values within it."""
    yield value
    if isinstance(value, (dict, list)):
        for inner in value.values() if isinstance(value, dict) else value:
            yield from all_values(inner)


def json_documents(text):
    """The JSON documents in the output of a command: one that is all of it, or one a line."""
    for candidate in (text, *text.splitlines()):
        with contextlib.suppress(ValueError):
            yield json.loads(candidate)


def output_files(command):
    """The files and folders that a command is told to write."""
    words = shlex.split(command, comments=True)
    return [name for flag, name in zip(words, words[1:]) if flag in OUTPUT_FLAGS and name != "-"]


def port_is_free():
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", PORT))
        except OSError:
            return False
    return True


class Readme(unittest.TestCase):
    def setUp(self):
        self.blocks = blocks(README.read_text())
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-readme-"))
        self.addCleanup(shutil.rmtree, self.folder)
        programs = self.folder / "bin"
        programs.mkdir()
        (programs / "segctl").symlink_to(SEGCTL)
        (programs / "segserve").symlink_to(SEGSERVE)
        self.environment = {name: value for name, value in os.environ.items() if name != "SEGCTL_SERVER"}
        self.environment["PATH"] = f"{programs}:{os.environ['PATH']}"
        self.work = self.folder / "work"
        (self.work / SCANS).mkdir(parents=True)
        self.printed = []

    def run_in_shell(self, command):
        return subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=self.work, env=self.environment,
                              capture_output=True, text=True, timeout=120)

    def start(self, command):
        """Runs a command that ends with &, and waits until its server serves."""
        # Not in the background of its shell, so that its process is ours to stop.
        server = subprocess.Popen(["bash", "-c", "exec " + command.rstrip("& ")], cwd=self.work, env=self.environment,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(self.stop, server)
        deadline = time.monotonic() + 60
        while self.run_in_shell("segctl health").returncode != SUCCESS:
            self.assertIsNone(server.poll(), f"{command}: it ended")
            self.assertLess(time.monotonic(), deadline, f"{command}: it does not serve")

    @staticmethod
    def stop(server):
        if server.poll() is None:
            server.send_signal(signal.SIGTERM)
        server.wait(timeout=60)

    def check(self, command):
        done = self.run_in_shell(command)
        if "--objective" in command and done.returncode == FAILED:  # A busy machine may miss it.
            self.assertRegex(done.stderr, r"\Asegctl: missed: ")
        else:
            self.assertEqual((done.returncode, done.stderr), (SUCCESS, ""), command)
        for name in output_files(command):
            self.assertTrue((self.work / name).exists(), f"{command}: there is no {name}")
        self.printed.extend(json_documents(done.stdout))

    def check_json(self, shown):
        printed = [value for document in self.printed for value in all_values(document)]
        agreeing = [sum(is_part(shown[key], value.get(key)) for key in shown) if isinstance(value, dict) else 0
                    for value in printed]
        closest = printed[agreeing.index(max(agreeing))]
        self.assertEqual(max(agreeing), len(shown), f"no command before it has printed that, but {json.dumps(closest)}")

    def test_commands_do_what_they_say_and_print_what_is_shown(self):
        if not port_is_free():
            self.skipTest(f"port {PORT}, at which README.md starts a server, is taken")
        for seed in ("1", "2"):
            self.check(f"segctl synth --quiet --seed {seed} --width 160 --height 120 --output {SCANS}/scan{seed}.pcd")
        for section, language, content in self.blocks:
            if section in NOT_RUN:
                continue
            if language == "json":
                with self.subTest(json=content):
                    self.check_json(json.loads(content, parse_float=Shown))
            for command in commands(content) if language == "sh" else ():
                with self.subTest(command=command):
                    self.start(command) if command.endswith("&") else self.check(command)

    def test_sections_that_are_not_run_have_commands(self):
        with_commands = {section for section, language, _ in self.blocks if language == "sh"}
        self.assertLessEqual(NOT_RUN.keys(), with_commands, "NOT_RUN names a section that is not there")
        self.assertGreater(len(with_commands), len(NOT_RUN), "no command would be run")


class Rules(unittest.TestCase):
    """The test would notice a README that is wrong."""

    def test_a_number_agrees_in_the_digits_that_are_shown(self):
        shown = json.loads('{"a": [0.50, -0.0241], "n": 3}', parse_float=Shown)
        self.assertTrue(is_part(shown, {"a": [0.4951, -0.02409], "n": 3, "more": 1}))
        self.assertFalse(is_part(shown, {"a": [0.4949, -0.02409], "n": 3}))
        self.assertFalse(is_part(shown, {"a": [0.4951, -0.02404], "n": 3}))
        self.assertFalse(is_part(shown, {"a": [0.4951], "n": 3}))
        self.assertFalse(is_part(shown, {"a": [0.4951, -0.02409]}))

    def test_commands_are_found(self):
        text = "## One\n```sh\n# why\na \\\n  b # c\n\nserver &\n```\n## Two\n```json\n{}\n```\n"
        self.assertEqual([(section, language) for section, language, _ in blocks(text)], [("One", "sh"), ("Two", "json")])
        self.assertEqual(commands(blocks(text)[0][2]), ["a    b # c", "server &"])
        self.assertEqual(output_files("segctl segment - -o x.pcd --json - # -o y.pcd"), ["x.pcd"])


if __name__ == "__main__":
    unittest.main()
