# SPDX-License-Identifier: Apache-2.0
"""A unix socket belongs to one server, as long as that lives."""
import signal
import socket
import subprocess
import time
import unittest

from harness import SEGCTL, SEGSERVE, SUCCESS, EndToEnd, Server, segctl


class UnixSocket(EndToEnd):
    def path(self, name):
        """The name of the test would make the path too long for a socket."""
        return self.folder / f"{name}{time.monotonic_ns() % 10**9}"

    def start(self, path):
        server = subprocess.Popen([SEGSERVE, "--listen", f"unix:{path}", "--workers", "1", "--log-level", "error"],
                                  stderr=subprocess.PIPE, text=True)
        self.addCleanup(server.stderr.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        return server

    @staticmethod
    def is_served(path):
        return segctl("health", "--server", f"unix:{path}").returncode == SUCCESS

    def start_and_wait(self, path):
        server = self.start(path)
        self.wait_for(lambda: self.is_served(path))
        return server

    def refusal(self, path, code=1):
        """The message of a server that is to refuse this path."""
        server = self.start(path)
        message = server.communicate(timeout=60)[1]
        self.assertEqual(server.returncode, code, message)
        return message

    def stop(self, server):
        server.send_signal(signal.SIGTERM)
        self.assertEqual(server.wait(timeout=60), 0)

    def test_one_of_many_that_start_at_the_same_moment_serves(self):
        path = self.path("s")
        for _ in range(3):
            servers = [self.start(path) for _ in range(4)]
            self.wait_for(lambda: sum(server.poll() is None for server in servers) == 1 and self.is_served(path))
            living = [server for server in servers if server.poll() is None]
            for server in servers:
                if server not in living:
                    self.assertEqual(server.returncode, 1)
                    self.assertIn("another process serves there", server.stderr.read())
            living[0].kill()  # so that the next round finds its leftover
            living[0].wait()
            self.assertTrue(path.is_socket())

    def test_the_path_of_a_living_server_stays_its_own(self):
        path = self.path("s")
        first = self.start_and_wait(path)
        self.assertIn("another process serves there", self.refusal(path))
        self.assertTrue(self.is_served(path))
        first.send_signal(signal.SIGSTOP)  # it is alive, but answers nothing
        try:
            self.assertIn("another process serves there", self.refusal(path))
        finally:
            first.send_signal(signal.SIGCONT)
        self.assertTrue(self.is_served(path))
        self.stop(first)
        self.assertEqual(list(path.parent.glob(".[0-9]*")), [], "nothing is left behind")
        self.assertFalse(path.exists())

    def test_a_server_removes_no_path_of_another(self):
        path = self.path("s")
        first = self.start_and_wait(path)
        path.unlink()
        second = self.start_and_wait(path)
        self.stop(first)
        self.assertTrue(self.is_served(path))
        self.stop(second)
        self.assertFalse(path.exists())

    def test_the_address_for_probes_is_kept_as_well(self):
        path = self.path("health")
        first = Server(self.folder, "--health-listen", f"unix:{path}")
        self.addCleanup(first.close)
        self.assertIn("another process serves there", self.refusal(path))
        self.assertTrue(self.is_served(path))
        self.assertEqual(first.terminate(), 0)
        self.assertFalse(path.exists())

    def test_what_is_no_socket_of_a_server_is_never_touched(self):
        path = self.path("file")
        path.write_text("precious")
        self.assertIn("there is a file that is no socket", self.refusal(path))
        self.assertEqual(path.read_text(), "precious")
        link = self.path("link")
        link.symlink_to(path)
        self.assertIn("there is a file that is no socket", self.refusal(link))
        self.assertTrue(link.is_symlink())
        log = self.path("datagrams")
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as datagrams:
            datagrams.bind(str(log))
            self.assertIn("whether a process serves on it cannot be found out", self.refusal(log))
        self.assertTrue(log.is_socket())

    def test_a_path_that_cannot_be_is_refused_in_a_sentence(self):
        self.assertIn("the path of a unix socket has at most 107 bytes", self.refusal(self.folder / ("x" * 120), code=2))
        self.assertIn("No such file or directory", self.refusal("/no/such/folder/s"))

    def test_a_relative_path_is_in_the_present_folder(self):
        server = subprocess.Popen([SEGSERVE, "--listen", "unix:s", "--workers", "1", "--log-level", "error"], cwd=self.folder)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        self.wait_for(lambda: self.is_served(self.folder / "s"))
        self.stop(server)
        self.assertFalse((self.folder / "s").exists())
        self.assertEqual(subprocess.run([SEGCTL, "health", "--server", "unix:s"], cwd=self.folder, capture_output=True,
                                        timeout=60).returncode, 1)


if __name__ == "__main__":
    unittest.main()
