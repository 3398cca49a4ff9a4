#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What bash completes. docker/packages tries the same script with the package bash-completion."""
import os
import pathlib
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "deploy/debian/completion"
# The functions of bash-completion that the script calls.
STUBS = """
_init_completion() { words=("${COMP_WORDS[@]}") cword=$COMP_CWORD cur=${COMP_WORDS[COMP_CWORD]}; }
_filedir() { COMPREPLY=(A_FILE); }
"""


class Completion(unittest.TestCase):
    def completed(self, *words):
        """What the last word may become."""
        with tempfile.TemporaryDirectory() as folder:
            for program in ("SEGCTL", "SEGSERVE"):
                os.symlink(os.environ[program], pathlib.Path(folder) / program.lower())
            quoted = " ".join(f"'{word}'" for word in words)
            script = f"{STUBS}\nsource {SCRIPT}\nCOMP_WORDS=({quoted}) COMP_CWORD={len(words) - 1}\n" \
                     "_segserve_tools\nprintf '%s\\n' \"${COMPREPLY[@]}\""
            done = subprocess.run(["bash", "-euc", script], capture_output=True, check=True, timeout=60, text=True,
                                  env=os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"})
            self.assertEqual(done.stderr, "")
            return done.stdout.split()

    def test_commands(self):
        self.assertEqual(self.completed("segctl", "se"), ["segment"])
        self.assertIn("bench", self.completed("segctl", ""))
        self.assertNotIn("show", self.completed("segctl", ""))

    def test_commands_of_commands(self):
        self.assertEqual(self.completed("segctl", "bench", ""), ["show", "diff"])
        self.assertEqual(self.completed("segctl", "bench", "di"), ["diff"])

    def test_flags_are_those_of_the_command(self):
        self.assertEqual(self.completed("segctl", "segment", "--pict"), ["--picture"])
        self.assertEqual(self.completed("segctl", "bench", "diff", "--"),
                         ["--allow", "--confidence", "--json", "--seed"])
        self.assertEqual(self.completed("segctl", "bench", "show", "run.json", "--ht"), ["--html"])
        self.assertIn("--clients", self.completed("segctl", "bench", "--c"))
        self.assertNotIn("--clients", self.completed("segctl", "bench", "diff", "--c"))
        self.assertIn("--http-host", self.completed("segserve", "--http"))
        self.assertEqual(self.completed("segctl", "cut", "--drop"), ["--drop-unlabeled"])

    def test_anything_else_is_a_file(self):
        self.assertEqual(self.completed("segctl", "segment", "sc"), ["A_FILE"])
        self.assertEqual(self.completed("segctl", "bench", "diff", "run"), ["A_FILE"])
        self.assertEqual(self.completed("segserve", ""), ["A_FILE"])


if __name__ == "__main__":
    unittest.main()
