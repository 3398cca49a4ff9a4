#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Inputs that are no regular files: pipes are read, devices and sockets are refused, and a signal ends every wait."""
import os
import signal
import socket
import subprocess
import threading
import time
import unittest

from harness import BAD_INPUT, SEGCTL, EndToEnd

SMALL = ("--width", "96", "--height", "72")


class Pipes(EndToEnd):
    def setUp(self):
        self.scene = self.synth(*SMALL)
        self.pipe = self.path("pipe.pcd")
        os.mkfifo(self.pipe)

    def feed(self, pipe, bytes_, delay=0.0):
        """Writes into a pipe as soon as somebody reads it."""
        def write():
            time.sleep(delay)
            with open(pipe, "wb") as writer:
                writer.write(bytes_)
        thread = threading.Thread(target=write, daemon=True)
        thread.start()
        self.addCleanup(thread.join, 30)

    def test_a_pipe_is_read_to_its_end(self):
        labels, _ = self.segment_locally(self.scene)
        self.feed(self.pipe, self.scene.read_bytes(), delay=0.5)
        self.assertEqual(self.segment_locally(self.pipe)[0], labels)
        done = subprocess.run(["bash", "-c", f"{SEGCTL} segment <(gzip -c {self.scene}) --local --json - | grep -c segments"],
                              capture_output=True, timeout=60, check=True)
        self.assertEqual((done.stdout, done.stderr), (b"1\n", b""))

    def test_a_pipe_that_closes_without_a_byte_is_empty(self):
        self.feed(self.pipe, b"")
        self.assertIn("the file is empty", self.run_badly(BAD_INPUT, "segment", self.pipe, "--local"))

    def test_descriptors_are_read_as_standard_input_is(self):
        for name in ("/dev/stdin", "/dev/fd/0", "/proc/self/fd/0", "-"):
            self.run_well("segment", name, "--local", "-q", stdin=self.scene.read_bytes())
            with open("/dev/null", "rb") as null:
                done = subprocess.run([SEGCTL, "segment", name, "--local"], stdin=null, capture_output=True, timeout=60, check=False)
            self.assertIn(b"the file is empty", done.stderr)
        self.assertIn("cannot read /dev/fd/987: Bad file descriptor", self.run_badly(1, "segment", "/dev/fd/987", "--local"))

    def test_what_is_no_file_is_refused_by_what_it_is(self):
        place = self.folder / "s"
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(str(place))
            for path, kind in (("/dev/zero", "a character device"), ("/dev/null", "a character device"), (place, "a socket"),
                               (self.folder, "a folder")):
                line = self.run_badly(BAD_INPUT, "info", path)
                self.assertIn(f"cannot read {path}: it is {kind}", line)
        self.assertIn("/dev/zero: it is a character device", self.run_badly(BAD_INPUT, "segment", "/dev/zero", "--local"))
        self.assertIn("/dev/zero: it is a character device",
                      self.run_badly(BAD_INPUT, "segment", "--depth", "/dev/zero", "--intrinsics", "500,500,50,50", "--local"))
        result = self.path("result")
        self.run_well("segment", self.scene, "--local", "-q", "--result", result)
        self.assertIn("/dev/zero: it is a character device",
                      self.run_badly(BAD_INPUT, "cut", result, "--regions", "2", "--cloud", "/dev/zero", "-o", self.path("a.pcd")))

    def ends_by_signal(self, which, *arguments):
        """Starts segctl, which waits for a pipe without a writer, and sends one signal; returns how it ended."""
        with subprocess.Popen([SEGCTL, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            try:
                time.sleep(1)
                self.assertIsNone(process.poll())
                began = time.monotonic()
                process.send_signal(which)
                _, told = process.communicate(timeout=10)
                self.assertLess(time.monotonic() - began, 3)
                return process.returncode, told.decode()
            finally:
                process.kill()

    def test_the_first_signal_ends_the_wait_for_a_writer(self):
        for which in (signal.SIGINT, signal.SIGTERM):
            self.assertEqual(self.ends_by_signal(which, "segment", self.pipe, "--local"), (-which, ""))
            for server in (("--local",), ("--server", self.server.address)):
                code, told = self.ends_by_signal(which, "segment", self.pipe, self.scene, "--out-dir", self.path("out"), *server)
                self.assertEqual(code, 130, told)
                self.assertNotIn("failed", told)
            code, told = self.ends_by_signal(which, "stream", self.pipe, "--server", self.server.address)
            self.assertEqual((code, told), (0, ""))


if __name__ == "__main__":
    unittest.main()
