# SPDX-License-Identifier: Apache-2.0
"""segctl behaves as a command line should: help, exit codes, standard streams, no partial files."""
import json
import re
import subprocess
import unittest

from harness import BAD_INPUT, FAILED, SEGCTL, EndToEnd, segctl

COMMANDS = ("segment", "cut", "synth", "eval", "bench", "info", "health")
NOBODY = "127.0.0.1:1"


class Help(EndToEnd):
    def help(self, command, flag="--help"):
        return self.run_well(command, flag).stdout.decode()

    @staticmethod
    def options(text):
        return set(re.findall(r"--[a-z][a-z-]+", text.split("Examples:")[0]))

    def test_every_command_has_help_with_examples_and_exit_codes(self):
        for command in COMMANDS:
            for flag in ("--help", "-h", "--help-all"):
                text = self.help(command, flag)
                for part in ("Usage: segctl " + command, "Examples:", "Exit codes:"):
                    self.assertIn(part, text)
            self.assertIn(command, self.run_well("--help").stdout.decode())

    def test_help_is_short_and_says_where_the_rest_is(self):
        for command in COMMANDS:
            with self.subTest(command=command):
                text, everything = self.help(command), self.help(command, "--help-all")
                self.assertLessEqual(len(text.splitlines()), 60)
                self.assertIn(f"segctl {command} --help-all", text)
                self.assertLessEqual(self.options(text), self.options(everything))
                for line in (text + everything).splitlines():
                    self.assertLessEqual(len(line), 120)
        self.assertLess(len(self.options(self.help("segment"))), len(self.options(self.help("segment", "--help-all"))) / 2)

    def test_help_all_lists_every_option_of_every_command(self):
        text = self.run_well("--help-all").stdout.decode()
        for command in COMMANDS:
            self.assertLessEqual(self.options(self.help(command)), set(re.findall(r"--[a-z][a-z-]+", text)))

    def test_examples_are_commands_that_are_understood(self):
        known = set().union(*(self.options(self.help(command, "--help-all")) for command in COMMANDS))
        for command in COMMANDS:
            examples = self.help(command).split("Examples:\n")[1].split("\n\n")[0]
            for line in examples.splitlines():
                self.assertTrue(line.startswith("  segctl "), line)
                self.assertLessEqual(self.options(line), known, line)

    def test_version(self):
        self.assertRegex(self.run_well("--version").stdout.decode(), r"\Asegctl \d+\.\d+\.\d+\n\Z")

    def test_every_option_of_the_server_is_a_flag(self):
        options = json.loads(self.run_well("info", "--server", self.server.address, "--json", "-").stdout)["options"]
        self.assertGreater(len(options), 5)
        text = self.help("segment", "--help-all")
        for option in options:
            self.assertIn("--" + option["name"].replace("_", "-"), text)


class Usage(EndToEnd):
    def test_wrong_usage(self):
        for arguments in ((), ("dance",), ("segment",), ("segment", "a", "b"), ("segment", "a", "--no-such-flag"),
                          ("segment", "-", "--threshold", "much"), ("segment", "-", "--local", "--server", NOBODY),
                          ("segment", "-", "--local", "--request-id", "x"), ("segment", "-", "--codec", "pcd", "--zstd"),
                          ("segment", "-", "--codec", "gzip"), ("segment", "-", "--error-bound", "1"),
                          ("segment", "-", "--codec", "quantised", "--error-bound", "11"),
                          ("segment", "--depth", "x.png"), ("segment", "-", "--depth", "x.png", "--intrinsics", "1,1,1,1"),
                          ("segment", "--depth", "x.png", "--intrinsics", "1,1,1"),
                          ("segment", "--depth", "x.png", "--intrinsics", "0,1,1,1"),
                          ("segment", "--depth", "x.png", "--intrinsics", "1,1,1,1", "--depth-scale", "0"),
                          ("segment", "--depth", "x.png", "--intrinsics", "1,1,1,1", "--view", "world"),
                          ("segment", "-", "--timeout", "0"), ("segment", "-", "--timeout", "nan"),
                          ("segment", "-", "-o", "x.stl"), ("segment", "-", "-o", "x.ply", "--encoding", "binary_compressed"),
                          ("segment", "-", "-o", "-", "--json", "-"), ("segment", "-", "-o", "/no/such/folder/x.pcd"),
                          ("segment", "-", "--result", str(self.folder)), ("synth",), ("synth", "-o", "x.pcd", "--size", "2"),
                          ("synth", "-o", "x.pcd", "--fused", "--width", "100"), ("synth", "-o", "x.pcd", "--width", "1"),
                          ("health", "--server", ""), ("health", "--timeout", "-1")):
            with self.subTest(arguments=arguments):
                self.run_badly(BAD_INPUT, *arguments)

    def test_a_hostile_name_stays_one_line(self):
        line = self.run_badly(BAD_INPUT, "segment", "no\nsuch\x1b[2Jfile", "--local")
        self.assertNotIn("\x1b", line)


class Outputs(EndToEnd):
    def test_nothing_is_left_behind_when_one_output_fails(self):
        scene = self.synth("--width", "64", "--height", "48")
        before = set(self.folder.iterdir())
        cloud = self.path("out.pcd")
        self.run_badly(FAILED, "segment", scene, "--local", "-o", cloud, "--result", "/dev/full")
        self.assertEqual(set(self.folder.iterdir()), before)

    def test_an_old_file_survives_a_failure(self):
        old = self.path("old.pcd")
        old.write_text("precious")
        self.run_badly(BAD_INPUT, "segment", "-", "--local", "-o", old, stdin=b"no cloud")
        self.assertEqual(old.read_text(), "precious")

    def test_a_full_standard_output_is_reported(self):
        scene = self.synth("--width", "64", "--height", "48")
        with open("/dev/full", "wb") as full:
            done = subprocess.run([SEGCTL, "segment", scene, "--local", "-o", "-"], stdout=full, stderr=subprocess.PIPE,
                                  timeout=120)
        self.assertEqual(done.returncode, FAILED)
        self.assertRegex(done.stderr.decode(), r"\Asegctl: [^\n]*standard output[^\n]*\n\Z")

    def test_a_symbolic_link_stays_one(self):
        target, link = self.path("target.pcd"), self.path("link.pcd")
        target.write_text("old")
        link.symlink_to(target)
        self.run_well("synth", "-q", "-o", link, "--width", "64", "--height", "48")
        self.assertTrue(link.is_symlink())
        self.assertIn(b"FIELDS", target.read_bytes()[:200])

    def test_quiet_prints_nothing(self):
        scene = self.synth("--width", "64", "--height", "48")
        self.assertEqual(self.run_well("segment", scene, "--local", "--quiet").stdout, b"")


class Servers(EndToEnd):
    def test_an_unreachable_server_is_a_failure_that_names_it(self):
        scene = self.synth("--width", "64", "--height", "48")
        output = self.path("out.pcd")
        for command in (("segment", scene, "-o", output), ("info",), ("health",)):
            self.assertIn(NOBODY, self.run_badly(FAILED, *command, "--server", NOBODY))
        self.assertFalse(output.exists())

    def test_the_address_comes_from_the_environment_unless_given(self):
        here, nobody = {"SEGCTL_SERVER": self.server.address}, {"SEGCTL_SERVER": NOBODY}
        self.assertIn(b"SERVING", self.run_well("health", environment=here).stdout)
        self.run_badly(FAILED, "health", environment=nobody)
        self.run_well("health", "--server", self.server.address, environment=nobody)
        scene = self.synth("--width", "64", "--height", "48")
        self.run_well("segment", scene, "--local", environment=nobody)

    def test_a_proxy_of_the_environment_is_not_used_for_this_machine(self):
        proxies = {name: "http://127.0.0.1:9" for name in ("http_proxy", "https_proxy", "grpc_proxy")}
        for flags in ((), ("--use-proxy",)):
            self.run_well("health", "--server", self.server.address, *flags, environment=proxies)

    def test_a_url_is_no_address(self):
        line = self.run_badly(BAD_INPUT, "health", "--server", "http://127.0.0.1:50051")
        self.assertIn("'http://127.0.0.1:50051' is a URL; the address of a server is HOST:PORT", line)

    def test_health_as_text_and_json(self):
        flags = ("health", "--server", self.server.address)
        self.assertEqual(self.run_well(*flags).stdout.decode(), f"{self.server.address} is SERVING\n")
        self.assertEqual(self.run_well(*flags, "--quiet").stdout, b"")
        told = json.loads(self.run_well(*flags, "--json", "-").stdout)
        self.assertEqual(told, {"server": self.server.address, "serving": True, "error": None})
        done = segctl("health", "--server", NOBODY, "--json", "-")
        self.assertEqual(done.returncode, FAILED)
        told = json.loads(done.stdout)
        self.assertEqual((told["server"], told["serving"]), (NOBODY, False))
        self.assertIn(told["error"], done.stderr.decode())

    def test_info_as_text_and_json(self):
        text = self.run_well("info", "--server", self.server.address).stdout.decode()
        told = json.loads(self.run_well("info", "--server", self.server.address, "--json", "-").stdout)
        self.assertEqual(told["limits"]["max_message_bytes"], 8 << 20)
        thresholds = {method["name"]: method["default_threshold"] for method in told["methods"]}
        self.assertEqual(thresholds["lambda-convex"], 0.15)
        self.assertIn(told["version"], text)

    def test_time_over_is_a_failure(self):
        scene = self.synth()
        done = segctl("segment", scene, "--server", self.server.address, "--timeout", "0.001")
        self.assertEqual((done.returncode, done.stdout), (FAILED, b""))
        self.run_badly(FAILED, "segment", scene, "--local", "--timeout", "0.001")


if __name__ == "__main__":
    unittest.main()
