# SPDX-License-Identifier: Apache-2.0
"""What newcomers get wrong is told in one line that says what to do."""
import subprocess
import unittest

from harness import BAD_INPUT, SEGSERVE, EndToEnd

SMALL = ("--width", "160", "--height", "120")


class CommandLine(EndToEnd):
    def refuse(self, said, *arguments):
        self.assertEqual(self.run_badly(BAD_INPUT, *arguments), f"segctl: {said}\n")

    def test_the_name_that_was_meant_is_told(self):
        self.refuse("there is no command 'segmnt' (did you mean segctl segment?) (see segctl --help)", "segmnt", "x.pcd")
        self.refuse("unknown option --treshold (did you mean --threshold?) (see segctl segment --help)",
                    "segment", "x.pcd", "--treshold", "0.2")
        self.refuse("unknown option --serve (did you mean --server?) (see segctl health --help)",
                    "health", "--serve=localhost")
        self.refuse("unknown option -local (did you mean --local?) (see segctl segment --help)", "segment", "x.pcd", "-local")
        self.refuse("unknown option --drop-unlabeled (did you mean --drop-unlabelled?) (see segctl cut --help)",
                    "cut", "x", "--regions", "3", "--drop-unlabeled")
        scene = self.synth(*SMALL)
        self.refuse(f"there is no command '{scene}' (did you mean segctl segment {scene}?) (see segctl --help)", scene)

    def test_everything_wrong_is_told_at_once(self):
        self.refuse("unknown option --bogus-flag; --threshold: 'high' is no number; --regions: 'few' is no whole number; "
                    "--parallel needs --out-dir (see segctl segment --help)",
                    "segment", "x.pcd", "--threshold", "high", "--bogus-flag", "--regions", "few", "--parallel", "2")
        self.refuse("--objects: -1 is negative, but must be a whole number of at least 0; "
                    "--width: '1.5' is no whole number (see segctl synth --help)",
                    "synth", "-o", "x.pcd", "--objects", "-1", "--width", "1.5")

    def test_a_value_that_is_missing_is_asked_for(self):
        self.refuse("--json needs FILE after it (see segctl info --help)", "info", "--json")
        self.refuse("RESULT is required (see segctl cut --help)", "cut", "--regions", "3")

    def test_no_count_may_be_negative(self):
        for flags in (("synth", "-o", "x.pcd", "--seed"), ("synth", "-o", "x.pcd", "--objects"),
                      ("synth", "-o", "x.pcd", "--height"), ("synth", "-o", "x.pcd", "--fused", "--points"),
                      ("bench", "--seed"), ("bench", "--clients"), ("bench", "--scenes"), ("bench", "--in-flight"),
                      ("eval", "--data", ".", "--seed"), ("segment", ".", "--out-dir", "x", "--parallel")):
            with self.subTest(flags=flags):
                self.assertIn(f"{flags[-1]}: -1 ", self.run_badly(BAD_INPUT, *flags, "-1"))

    def test_the_server_tells_all_faults_too(self):
        done = subprocess.run([SEGSERVE, "--treads", "3", "--workers", "many", "--queue", "-1"], capture_output=True,
                              timeout=60)
        self.assertEqual((done.returncode, done.stdout), (BAD_INPUT, b""))
        self.assertEqual(done.stderr.decode(),
                         "segserve: unknown option --treads (did you mean --threads?); --workers: 'many' is no whole number; "
                         "--queue: -1 is negative, but must be a whole number of at least 0 (see segserve --help)\n")


if __name__ == "__main__":
    unittest.main()
