# SPDX-License-Identifier: Apache-2.0
"""Runs the real `segserve` and `segctl`, as a user would, and reads what they write."""
import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import pcd

SEGCTL = os.environ["SEGCTL"]
SEGSERVE = os.environ["SEGSERVE"]
DATA = pathlib.Path(os.environ.get("SEGSERVE_DATA_DIR", ""))

SUCCESS, FAILED, BAD_INPUT = 0, 1, 2


def segctl(*arguments, stdin=b"", environment=None):
    """Runs segctl to its end; its output is bytes. It does not see the variables of the caller that begin with SEGCTL_."""
    clean = {name: value for name, value in os.environ.items() if not name.startswith("SEGCTL_")}
    return subprocess.run([SEGCTL, *map(str, arguments)], input=stdin, capture_output=True, timeout=120,
                          env=clean | (environment or {}))


class Server:
    """A server process, on a free loopback port unless `listen` says otherwise."""

    def __init__(self, folder, *flags, before=None, listen="127.0.0.1:0", log=None, environment=None):
        """`before` is called in the new process before it becomes the server, for example to set limits. `log` is a
        path, or a file descriptor, that gets the log with all its lines; without it there are errors only. `environment`
        adds variables."""
        port_file = pathlib.Path(folder) / f"port-{time.monotonic_ns()}"
        level = [] if "--log-level" in flags else ["--log-level", "error" if log is None else "debug"]
        with contextlib.nullcontext() if log is None else open(log, "wb") as stderr:
            self.process = subprocess.Popen(
                [SEGSERVE, "--listen", listen, "--port-file", str(port_file), *level, *flags], preexec_fn=before,
                stderr=stderr, env=os.environ | (environment or {}))
        deadline = time.monotonic() + 60
        while not (port_file.exists() and port_file.read_text().strip()):
            if self.process.poll() is not None or time.monotonic() > deadline:
                self.process.kill()
                raise RuntimeError(f"segserve did not start: exit code {self.process.wait()}")
            time.sleep(0.02)
        self.address = f"127.0.0.1:{port_file.read_text().strip()}"

    def terminate(self):
        """SIGTERM; returns the exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout=60)

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()


class EndToEnd(unittest.TestCase):
    """One server and one folder for all tests of a class."""

    server_flags = ()
    server_listen = "127.0.0.1:0"

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-e2e-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.server = Server(cls.folder, *cls.server_flags, listen=cls.server_listen)
        cls.addClassCleanup(cls.server.close)

    def wait_for(self, happened, seconds=30):
        """Fails unless `happened` becomes true within so many seconds."""
        deadline = time.monotonic() + seconds
        while not happened():
            self.assertLess(time.monotonic(), deadline, "it did not happen in time")
            time.sleep(0.05)

    def path(self, name):
        return self.folder / f"{self.id()}-{name}"

    def run_well(self, *arguments, **options):
        done = segctl(*arguments, **options)
        self.assertEqual(done.returncode, SUCCESS, f"segctl {arguments}: {done.stderr.decode()}")
        self.assertEqual(done.stderr, b"")
        return done

    def run_badly(self, exit_code, *arguments, **options):
        """Expects the exit code, one line on standard error, nothing on standard output; returns the line."""
        done = segctl(*arguments, **options)
        self.assertEqual(done.returncode, exit_code, f"segctl {arguments}: {done.stdout!r} {done.stderr!r}")
        self.assertEqual(done.stdout, b"")
        line = done.stderr.decode()
        self.assertRegex(line, r"\Asegctl: [^\n]+\n\Z")
        return line

    def segment(self, scene, *flags):
        """Segments through the server; returns labels and summary."""
        return self._segment(scene, "--server", self.server.address, *flags)

    def segment_locally(self, scene, *flags):
        return self._segment(scene, "--local", *flags)

    def _segment(self, scene, *flags):
        output = self.path(f"labeled-{time.monotonic_ns()}.pcd")
        done = self.run_well("segment", scene, "-o", output, "--json", "-", *flags)
        return pcd.read_labels(output), json.loads(done.stdout)

    def synth(self, *flags, name="scene.pcd"):
        scene = self.path(name)
        self.run_well("synth", "-o", scene, "--quiet", *flags)
        return scene
