# SPDX-License-Identifier: Apache-2.0
"""The process segserve ends cleanly on SIGTERM, and segctl health tells whether it serves."""
import signal
import unittest

from harness import FAILED, EndToEnd, Server, segctl


class ServerProcess(EndToEnd):
    def test_sigterm_gives_exit_code_0(self):
        server = Server(self.folder)
        self.addCleanup(server.close)
        self.run_well("health", "--server", server.address)
        self.assertEqual(server.terminate(), 0)
        self.run_badly(FAILED, "health", "--server", server.address)

    def test_sigint_gives_exit_code_0(self):
        server = Server(self.folder)
        self.addCleanup(server.close)
        server.process.send_signal(signal.SIGINT)
        self.assertEqual(server.process.wait(timeout=60), 0)

    def test_a_client_that_vanishes_does_no_harm(self):
        scene = self.synth()
        for _ in range(3):
            segctl("segment", scene, "--server", self.server.address, "--timeout", "0.02")
        self.assertGreater(max(self.segment(scene)[0]), 1)
        self.assertIsNone(self.server.process.poll())


if __name__ == "__main__":
    unittest.main()
