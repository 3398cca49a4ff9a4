# SPDX-License-Identifier: Apache-2.0
"""The commands and programs of documents work as they stand, in the order in which they stand, and print what is shown.

The documents keep these rules:
- Commands are in ```sh blocks. Those of a block that begins with "```sh not run: " and a reason are not run. Those of "```sh
  shortened" are load tests, which are run with less time and smaller scenes than they say (SHORTER).
- A command is one line, or several that end with a backslash. It runs in a shell of its own: `cd` and variables do not
  last until the next command, files do.
- A command that ends with & is a server, on the port of its --listen or else on segctl's default address. It takes the place of an
  earlier one on that port.
- Commands may use files that earlier commands have made, and the folder SCANS, which holds a few scenes.
- A ```python block is a program of its own, for the package of client/python, and a ```js block one for that of client/js, if npm
  was there to build it. They, too, may begin with "not run: " and a reason.
- A ```json block is a valid JSON object. It is part of what an earlier command has printed: keys may be
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

from documents import Block, blocks, commands, output_files
from harness import FAILED, SEGCTL, SEGSERVE, SUCCESS

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
JS_PACKAGE = os.environ.get("JS_PACKAGE")
SCANS = "scans"
PORT = 50051  # unless a command says --listen HOST:PORT

# Load tests are shortened by these replacements in their flags.
SHORTER = [(r"(?<=--duration )[\d.]+", "0.3"), (r"(?<=--warm-up )[\d.]+", "0"), (r"(?<=--drain )[\d.]+", "2"),
           (r"(?<=--soak )\w+", "1s"), (r"(?<=:)\d+s\b", "0.3s"), (r"(?<=--interval )[\d.]+", "0.2"),
           (r"(?<=--size )\d+x\d+", "80x60"), (r"\.\.32\b", "..2")]
# Load tests without these flags get them.
SHORT = {"--duration": "0.3", "--warm-up": "0", "--size": "80x60"}
GOES_WITHOUT = {"--duration": "--(duration|soak|steps|ramp)", "--warm-up": "--warm-up", "--size": "--(size|input)"}


class Shown(float):
    """A number with the digits that README.md shows."""

    def __new__(cls, text):
        number = super().__new__(cls, text)
        number.text = text
        return number

    def shows(self, number):
        decimals = len(self.text.partition(".")[2])
        return isinstance(number, (int, float)) and f"{number:.{decimals}f}" == self.text


def shortened(command):
    """A load test that takes a second or so instead of the time that it says."""
    if not re.match(r"segctl bench\b(?! (?:show|diff)\b)", command):
        return command
    load, mark, comment = command.partition(" #")
    for pattern, shorter in SHORTER:
        load = re.sub(pattern, shorter, load)
    for flag, value in SHORT.items():
        if not re.search(GOES_WITHOUT[flag], load):
            load = f"{load.rstrip()} {flag} {value}"
    return load + mark + comment


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


def port_of(command):
    """The port on which a server listens."""
    found = re.search(r"--listen \S+:(\d+)", command)
    return int(found[1]) if found else PORT


def is_free(port):
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def is_served(port):
    try:
        socket.create_connection(("127.0.0.1", port), timeout=1).close()
    except OSError:
        return False
    return True


class Document:
    """The tests of a document."""

    path = ""
    before = ()  # commands that the document takes for granted
    python_before = ""  # what its programs in Python take for granted

    def setUp(self):
        self.blocks = blocks((REPOSITORY / self.path).read_text())
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-readme-"))
        self.addCleanup(shutil.rmtree, self.folder)
        programs = self.folder / "bin"
        programs.mkdir()
        (programs / "segctl").symlink_to(SEGCTL)
        (programs / "segserve").symlink_to(SEGSERVE)
        self.environment = {name: value for name, value in os.environ.items() if not name.startswith("SEGCTL_")}
        self.environment["PATH"] = f"{programs}:{os.environ['PATH']}"
        self.work = self.folder / "work"
        (self.work / SCANS).mkdir(parents=True)
        if JS_PACKAGE is not None:
            (self.work / "node_modules").mkdir()
            (self.work / "node_modules" / "segserve").symlink_to(JS_PACKAGE)
        self.printed, self.servers = [], {}

    def run_in_shell(self, command):
        return subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=self.work, env=self.environment,
                              capture_output=True, text=True, timeout=120)

    def start(self, command):
        """Runs a command that ends with &, and waits until its server serves."""
        earlier = self.servers.pop(port_of(command), None)
        if earlier is not None:
            self.stop(earlier)
        # Not in the background of its shell, so that its process is ours to stop.
        server = subprocess.Popen(["bash", "-c", "exec " + command.rstrip("& ")], cwd=self.work, env=self.environment,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(self.stop, server)
        self.servers[port_of(command)] = server
        deadline = time.monotonic() + 60
        while not is_served(port_of(command)):
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
        elif command.startswith("segctl bench --rate") and done.returncode == FAILED:  # It may be too busy for this rate.
            self.assertRegex(done.stderr, r"\Asegctl: \d+ of \d+ frames failed \(\d+ times UNFINISHED\)")
        elif command.startswith("segctl bench diff") and done.returncode == FAILED:  # It may be busier than before.
            self.assertRegex(done.stderr, r"\Asegctl: worse: ")
        else:
            self.assertEqual(done.returncode, SUCCESS, f"{command}: {done.stderr}")
            # These tell how far they are, or where one can look at them.
            if not re.match(r"openssl|segctl bench --soak|segctl stream .*--html-live", command):
                self.assertEqual(done.stderr, "", command)
        for name in output_files(command):
            self.assertTrue((self.work / name).exists(), f"{command}: there is no {name}")
        self.printed.extend(json_documents(done.stdout))

    def check_json(self, shown):
        printed = [value for document in self.printed for value in all_values(document)]
        agreeing = [sum(is_part(shown[key], value.get(key)) for key in shown) if isinstance(value, dict) else 0
                    for value in printed]
        closest = printed[agreeing.index(max(agreeing))]
        self.assertEqual(max(agreeing), len(shown), f"no command before it has printed that, but {json.dumps(closest)}")

    def run_command(self, command):
        with self.subTest(command=command):
            self.start(command) if command.endswith("&") else self.check(command)

    def test_commands_do_what_they_say_and_print_what_is_shown(self):
        runs = [(block, self.lines_of(block)) for block in self.blocks if not block.not_run]
        lines = [*self.before, *(line for _, found in runs for line in found)]
        for port in {port_of(line) for line in lines if line.endswith("&")}:
            if not is_free(port):
                self.skipTest(f"port {port}, at which {self.path} starts a server, is taken")
        for seed in ("1", "2"):
            self.check(f"segctl synth --quiet --seed {seed} --width 160 --height 120 --output {SCANS}/scan{seed}.pcd")
        for command in self.before:
            self.run_command(command)
        for block, found in runs:
            if block.language == "json":
                with self.subTest(json=block.content):
                    self.check_json(json.loads(block.content, parse_float=Shown))
            if block.language == "python":
                with self.subTest(python=block.content):
                    self.check("/usr/bin/python3 -B -c " + shlex.quote(self.python_before + block.content))
            if block.language == "js" and JS_PACKAGE is not None:
                with self.subTest(js=block.content):
                    self.check("node --input-type=module -e " + shlex.quote(block.content))
            for command in found:
                self.run_command(command)

    @staticmethod
    def lines_of(block):
        """The commands of a block, as they are run."""
        if block.language != "sh":
            return []
        found = commands(block.content)
        return [shortened(command) for command in found] if block.shortened else found

    def test_notes_are_known_and_something_is_run(self):
        for block in self.blocks:
            self.assertTrue(not block.note or block.not_run or block.shortened, f"{block.language} {block.note}")
            self.assertTrue(not block.shortened or block.language == "sh", "only commands can be shortened")
        runs = [block for block in self.blocks if block.language in ("sh", "js", "python") and not block.not_run]
        self.assertTrue(runs, "no command would be run")


class Readme(Document, unittest.TestCase):
    path = "README.md"


class Tutorial(Document, unittest.TestCase):
    path = "docs/tutorial.md"


class HowItWorks(Document, unittest.TestCase):
    path = "docs/how_it_works.md"


class Sensors(Document, unittest.TestCase):
    path = "docs/sensors.md"


class Limits(Document, unittest.TestCase):
    path = "docs/limits.md"


class Tracking(Document, unittest.TestCase):
    path = "docs/tracking.md"


class Cameras(Document, unittest.TestCase):
    path = "docs/cameras.md"
    before = ("segserve &",)


class LoadTesting(Document, unittest.TestCase):
    path = "docs/load_testing.md"
    before = ("segserve --metrics-listen 127.0.0.1:9464 &",)


class Operations(Document, unittest.TestCase):
    path = "docs/operations.md"


class LoadTestReports(Document, unittest.TestCase):
    path = "docs/load_test_reports.md"
    before = ("segserve &",)


class PythonReadme(Document, unittest.TestCase):
    path = "client/python/README.md"
    before = ("segserve &",)
    python_before = """
import numpy as np
import segserve
client = segserve.Client("127.0.0.1:50051")
rows, columns = np.mgrid[-60:60, -80:80] / 131.25
z = np.where((abs(columns) < 0.15) & (abs(rows) < 0.15), 0.8, 1.0)
xyz = np.stack([columns * z, rows * z, z], axis=-1).astype(np.float32)
rgb = np.full(xyz.shape, 128, np.uint8)
frames = [xyz, xyz]
"""


@unittest.skipUnless(JS_PACKAGE, "npm is not installed: client/js was not built")
class JavaScriptReadme(Document, unittest.TestCase):
    path = "client/js/README.md"
    before = ("segserve &", "segctl synth --quiet --width 160 --height 120 --output scene.pcd")


class EveryDocument(unittest.TestCase):
    """The commands of every document are run, or it says why not; and what they name exists."""

    documents = [path for path in sorted(REPOSITORY.rglob("*.md"))
                 if not {"node_modules", "build", ".git"} & set(path.relative_to(REPOSITORY).parts)]

    def blocks(self):
        """Every block of commands, with the path of its document."""
        for path in self.documents:
            for block in blocks(path.read_text()):
                if block.language == "sh":
                    yield path.relative_to(REPOSITORY).as_posix(), block

    def test_commands_are_run_or_say_why_not(self):
        run = {document.path for document in Document.__subclasses__()}
        for path, block in self.blocks():
            with self.subTest(document=path, commands=block.content):
                self.assertNotIn("`", block.note, "Markdown does not allow backticks behind the language")
                self.assertTrue(block.not_run or path in run,
                                "add a class to test_readme.py for this document, or begin the block with \"```sh not run: WHY\"")

    def test_scripts_exist(self):
        checked = 0
        for path, block in self.blocks():
            for command in commands(block.content):
                for script in re.findall(r"^(?:sudo )?((?:\.ci|deploy|docker|docs|test)/[\w./-]+)", command):
                    with self.subTest(document=path, command=command):
                        self.assertTrue(os.access(REPOSITORY / script, os.X_OK), f"there is no program {script}")
                    checked += 1
        self.assertGreater(checked, 20)

    @staticmethod
    def commands_of(text):
        """The commands of both programs: ["segctl bench", "--rate 30 .."]."""
        for code in (*re.findall(r"`([^`\n]+)`", text), *(line for block in blocks(text) if block.language == "sh"
                                                         for line in commands(block.content))):
            for command in re.split(r"&&|[;|#]", code):
                found = re.match(r"\s*(segctl(?: bench (?:show|diff)| [a-z]+)|segserve)\b(.*)", command)
                if found:
                    yield found[1], found[2]

    def help_of(self, program):
        if program not in self.helps:
            words = [SEGSERVE, "--help"] if program == "segserve" else [SEGCTL, *program.split()[1:], "--help-all"]
            told = subprocess.run(words, capture_output=True, text=True, timeout=60)
            self.assertEqual(told.returncode, SUCCESS, f"{program}: there is no such command")
            self.helps[program] = set(re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", told.stdout))
        return self.helps[program]

    def test_flags_exist(self):
        """Also those within a sentence, and where nothing is run."""
        self.helps, checked = {}, 0
        for path in self.documents:
            for program, rest in self.commands_of(path.read_text()):
                for flag in re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", re.sub(r"'[^']*'|\"[^\"]*\"", "", rest)):
                    with self.subTest(document=path.name, command=program + rest):
                        self.assertIn(flag, {*self.help_of(program), "--help", "--help-all"})
                    checked += 1
        self.assertGreater(checked, 200)


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
        self.assertEqual(blocks(text)[1], Block("Two", "json", "", "{}\n"))
        self.assertEqual([(block.section, block.language) for block in blocks(text)], [("One", "sh"), ("Two", "json")])
        self.assertEqual(commands(blocks(text)[0].content), ["a    b # c", "server &"])
        self.assertEqual([port_of("segserve &"), port_of("segserve --listen 0.0.0.0:50052 --x &")], [PORT, 50052])
        self.assertEqual(output_files("segctl segment - -o x.pcd --json - # -o y.pcd"), ["x.pcd"])

    def test_notes_are_found(self):
        first, second = blocks("```sh not run: needs two machines\na\n```\n```sh shortened\nb\n```\n")
        self.assertTrue(first.not_run and not first.shortened)
        self.assertTrue(second.shortened and not second.not_run)

    def test_load_tests_are_shortened(self):
        self.assertEqual(shortened("segctl bench --duration 10 --rate 5 # 10 s"),
                         "segctl bench --duration 0.3 --rate 5 --warm-up 0 --size 80x60 # 10 s")
        self.assertEqual(shortened("segctl bench --steps 10,20:10s --warm-up 3"),
                         "segctl bench --steps 10,20:0.3s --warm-up 0 --size 80x60")
        self.assertEqual(shortened("segctl bench show run.json"), "segctl bench show run.json")


if __name__ == "__main__":
    unittest.main()
