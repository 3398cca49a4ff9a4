# SPDX-License-Identifier: Apache-2.0
"""Every flag of segserve works from the command line, the environment and a file alike."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from harness import BAD_INPUT, SEGSERVE, SUCCESS, Server

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent

# A value that is not the default, for settings where one more than the default is no valid value, or there is no default. A
# setting that needs others has these in COMPANIONS.
VALUES = {"listen": "127.0.0.1:7", "http": "127.0.0.1:8", "http-allow-origin": "https://app.example", "http-host": "robot.example", "log-level": "warn", "log-format": "json", "otlp-endpoint": "http://127.0.0.1:7",
          "otlp-sample-ratio": "0.5", "queue-bytes": "2GiB", "memory": "3GiB"}
COMPANIONS = {"http-allow-origin": ["--http", "127.0.0.1:8"], "http-host": ["--http", "127.0.0.1:8"], "max-decoded-bytes": ["--queue-bytes", "3GiB"], "tls-cert": ["--tls-key", "a.key"], "tls-key": ["--tls-cert", "a.crt"],
              "tls-client-ca": ["--tls-cert", "a.crt", "--tls-key", "a.key"],
              "jwt-keys": ["--jwt-issuer", "a", "--jwt-audience", "b"], "jwt-issuer": ["--jwt-keys", SEGSERVE, "--jwt-audience", "b"],
              "jwt-audience": ["--jwt-keys", SEGSERVE, "--jwt-issuer", "a"]}


def segserve(*arguments, environment=None):
    clean = {name: value for name, value in os.environ.items() if not name.startswith("SEGSERVE_")}
    return subprocess.run([SEGSERVE, *map(str, arguments)], capture_output=True, timeout=60, text=True,
                          env=clean | (environment or {}))


def variable(name):
    return "SEGSERVE_" + name.upper().replace("-", "_")


def settings(text):
    """What --print-config wrote: name -> (comment, value); None for a value that is not set."""
    found = {}
    for comment, unset, name, value in re.findall(r"^# ([^\n]*)\n(# )?([a-z0-9-]+) = (.*)$", text, re.MULTILINE):
        found[name] = (comment, None if unset else value)
    return found


class Configuration(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-config-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def write(self, text, name="segserve.toml"):
        path = self.folder / name
        path.write_text(text)
        return path

    def printed(self, *arguments, environment=None):
        done = segserve("--print-config", *arguments, environment=environment)
        self.assertEqual((done.returncode, done.stderr), (SUCCESS, ""), f"segserve {arguments} {environment}")
        return settings(done.stdout)

    def refuse(self, *arguments, environment=None):
        """Returns the lines that say what is wrong."""
        done = segserve(*arguments, environment=environment)
        self.assertEqual((done.returncode, done.stdout), (BAD_INPUT, ""), f"segserve {arguments}")
        lines = done.stderr.splitlines()
        self.assertTrue(all(line.startswith("segserve: ") for line in lines), lines)
        return [line.removeprefix("segserve: ") for line in lines]

    def other_value(self, name, comment, default):
        if name in VALUES:
            return VALUES[name]
        if comment.startswith(("FILE;", "PATH;")):
            return str(self.write("", name=f"{name}.file"))
        if default in ("true", "false"):
            return "true"
        if default is not None and re.fullmatch(r"[0-9]+", default):
            return str(int(default) + 1)
        if default is not None and re.fullmatch(r"[0-9.]+", default):
            return str(float(default) + 0.25)
        return "127.0.0.1:7" if "listen" in name else "other"

    def test_every_flag_works_from_flag_environment_and_file(self):
        defaults = self.printed()
        help_text = segserve("--help").stdout
        own = {"help", "version", "config", "check-config", "print-config"}
        self.assertEqual(set(re.findall(r"^  (?:-h,)?--([a-z0-9-]+)", help_text, re.MULTILINE)) - own, set(defaults))
        for name, (comment, default) in defaults.items():
            with self.subTest(setting=name):
                value = self.other_value(name, comment, default)
                is_switch = default in ("true", "false")
                with_others = COMPANIONS.get(name, [])
                by_flag = self.printed(*([f"--{name}"] if is_switch else [f"--{name}", value]), *with_others)
                by_variable = self.printed(*with_others, environment={variable(name): value})
                is_bare = is_switch or re.fullmatch(r"[0-9]+(\.[0-9]+)?", value)
                file = self.write(f"{name} = {value}\n" if is_bare else f'{name} = "{value}"\n')
                by_file = self.printed("--config", file, *with_others)
                self.assertNotEqual(by_flag[name][1], default, "VALUES needs a value that is not the default")
                self.assertEqual(by_variable[name][1], by_flag[name][1])
                self.assertEqual(by_file[name][1], by_flag[name][1])
                self.assertIn(f"from the command line, --{name}", by_flag[name][0])
                self.assertIn(f"from the environment, {variable(name)}", by_variable[name][0])
                self.assertIn(f"from the file, {file}:1: {name}", by_file[name][0])

    def test_what_is_printed_reads_back_as_the_same(self):
        first = segserve("--print-config", "--queue", "9", "--grace-period", "0.25", "--reflection",
                         environment={"SEGSERVE_MEMORY": "2GiB", "SEGSERVE_LOG_LEVEL": "debug"})
        file = self.write(first.stdout)
        before, after = settings(first.stdout), self.printed("--config", file)
        self.assertEqual({name: value for name, (_, value) in before.items()},
                         {name: value for name, (_, value) in after.items()})
        self.assertEqual((after["queue"][1], after["memory"][1], after["reflection"][1]), ("9", '"2GiB"', "true"))

    def test_precedence(self):
        file = self.write("queue = 2\nthreads = 2\nworkers = 2\nreflection = true\n")
        found = self.printed("--queue", "4", environment={"SEGSERVE_CONFIG": str(file), "SEGSERVE_QUEUE": "3",
                                                          "SEGSERVE_THREADS": "3", "SEGSERVE_REFLECTION": "false"})
        self.assertEqual([found[name][1] for name in ("queue", "threads", "workers", "reflection")], ["4", "3", "2", "false"])

    def test_every_fault_is_told_at_once_with_its_place(self):
        file = self.write('queu = 3\nworkers = "many"\nreflection = "yes"\n[server]\nmemory = 1\n', name="bad.toml")
        lines = self.refuse("--config", file, "--threads", "few", environment={"SEGSERVE_MAX_POINTS": "-1", "SEGSERVE_QUEUE": "0"})
        self.assertEqual(len(lines), 7, lines)
        for place in ("SEGSERVE_MAX_POINTS: -1", "SEGSERVE_QUEUE: 0 is not in", f"{file}:1: there is no setting 'queu' (did you mean queue?)",
                      f"{file}:2: workers: 'many' is no whole number", f"{file}:3: reflection: the value must be true",
                      f"{file}:4: 'server' is a table", "--threads: 'few' is no whole number"):
            self.assertTrue(any(line.startswith(place) for line in lines), f"{place} is missing in {lines}")

    def test_every_line_that_is_no_toml_is_told(self):
        file = self.write("queue 3\nthreads = 2\nworkers = = 4\nthreads = 3\nlisten = 'a\n")
        lines = self.refuse("--config", file, "--check-config")
        self.assertEqual([line.split(":")[1] for line in lines], ["1", "3", "4", "5"], lines)

    def test_ranges_are_checked_wherever_a_value_is_from(self):
        file = self.write("\n\nqueue = 0\n")
        lines = self.refuse("--config", file, environment={"SEGSERVE_THREADS": "100", "SEGSERVE_LISTEN": "nowhere"})
        self.assertEqual([line.split(" ")[0] for line in lines], ["SEGSERVE_LISTEN:", "SEGSERVE_THREADS:", f"{file}:3:"])

    def test_numbers_that_are_none(self):
        lines = self.refuse("--grace-period", "5s", "--drain-delay", "nan", "--otlp-sample-ratio", "nan", "--metrics-listen",
                            "127.0.0.1:7", "--health-listen", "127.0.0.1:7", "--listen", "unix:/" + "x" * 200)
        for fault in ("--grace-period: '5s' is no number of seconds, which has no unit", "--drain-delay: nan is not in",
                      "--otlp-sample-ratio: nan is not in", "--metrics-listen: 127.0.0.1:7 is the address of --health-listen",
                      "--listen: the path of a unix socket has at most 107 bytes"):
            self.assertIn(fault, "\n".join(lines))

    def test_a_pipe_without_a_writer_does_not_hold_the_server(self):
        pipe = self.folder / "pipe"
        os.mkfifo(pipe)
        self.assertIn("is no regular file", self.refuse("--check-config", "--tokens", pipe)[0])

    def test_a_file_that_is_none(self):
        self.assertIn("No such file", self.refuse("--config", self.folder / "none.toml")[0])
        self.assertIn("cannot be read", self.refuse("--config", self.folder)[0])
        self.assertEqual(len(self.refuse("--config", SEGSERVE)), 1)  # of more than 1 MiB

    def test_check_config_looks_for_folders_and_does_not_serve(self):
        done = segserve("--check-config", "--listen", "127.0.0.1:1")  # a port that this user or another may not have
        self.assertEqual((done.returncode, done.stdout, done.stderr), (SUCCESS, "OK\n", ""))
        lines = self.refuse("--check-config", "--port-file", self.folder / "none" / "port")
        self.assertEqual(lines, [f"--port-file: there is no folder {self.folder / 'none'}"])

    def test_check_config_reads_the_files_of_tls_whatever_else_is_wrong(self):
        file = self.write("no certificate", name="cert.pem")
        lines = self.refuse("--check-config", "--tls-cert", file, "--tls-key", file, "--queue", "0")
        self.assertEqual([line.split(":")[0] for line in lines], ["--queue", "--tls-cert"], lines)
        lines = self.refuse("--check-config", "--tls-cert", file, "--tls-key", self.folder / "none")
        self.assertEqual(lines, [f"--tls-key: there is no file {self.folder / 'none'}"])

    def test_a_variable_that_sets_nothing_is_told(self):
        done = segserve("--check-config", environment={"SEGSERVE_MEMROY": "1", "SEGSERVE_PORT": "tcp://10.0.0.1:50051"})
        self.assertEqual((done.returncode, done.stdout), (SUCCESS, "OK\n"))
        self.assertEqual(done.stderr, "segserve: warning: the variable SEGSERVE_MEMROY sets nothing "
                                      "(did you mean SEGSERVE_MEMORY?)\n")

    def test_the_sample_is_valid(self):
        done = segserve("--config", ROOT / "deploy" / "segserve.toml", "--check-config")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (SUCCESS, "OK\n", ""))

    def test_a_server_serves_with_settings_of_a_file(self):
        file = self.write('drain-delay = 0\nqueue = 3\n')
        server = Server(self.folder, "--config", str(file))
        self.addCleanup(server.close)
        self.assertEqual(server.terminate(), SUCCESS)


if __name__ == "__main__":
    unittest.main()
