# SPDX-License-Identifier: Apache-2.0
"""The process segserve ends cleanly on SIGTERM, and segctl health tells whether it serves."""
import signal
import socket
import subprocess
import time
import unittest

from harness import BAD_INPUT, FAILED, SEGCTL, EndToEnd, Server, segctl


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


class ServerProcess(EndToEnd):
    def test_sigterm_gives_exit_code_0(self):
        server = Server(self.folder)
        self.addCleanup(server.close)
        self.run_well("health", "--server", server.address)
        self.assertEqual(server.terminate(), 0)
        self.run_badly(FAILED, "health", "--server", server.address)

    def test_probes_have_an_address_of_their_own(self):
        port_file = self.path("health-port")
        server = Server(self.folder, "--health-listen", "127.0.0.1:0", "--health-port-file", str(port_file))
        self.addCleanup(server.close)
        probes = f"127.0.0.1:{port_file.read_text().strip()}"
        for service in ("", "liveness", "readiness", "segserve.v1.SegmentationService"):
            self.run_well("health", "--server", probes, "--service", service)
        self.assertIn("does not know", self.run_badly(BAD_INPUT, "health", "--server", probes, "--service", "other"))
        self.assertIn("does it answer probes only?", self.run_badly(FAILED, "segment", self.synth(), "--server", probes))
        self.assertEqual(server.terminate(), 0)
        self.run_badly(FAILED, "health", "--server", probes, "--service", "liveness")

    def test_sigint_gives_exit_code_0(self):
        server = Server(self.folder)
        self.addCleanup(server.close)
        server.process.send_signal(signal.SIGINT)
        self.assertEqual(server.process.wait(timeout=60), 0)

    def test_sigquit_stops_and_sighup_does_not(self):
        log = self.path("log")
        server = Server(self.folder, log=log)
        self.addCleanup(server.close)
        server.process.send_signal(signal.SIGHUP)
        self.wait_for(lambda: "SIGHUP changes nothing" in log.read_text())
        self.run_well("health", "--server", server.address)
        server.process.send_signal(signal.SIGQUIT)
        self.assertEqual(server.process.wait(20), 0)
        self.assertIn("signal=QUIT", log.read_text())

    def test_health_waits_for_a_server_that_starts(self):
        address = f"127.0.0.1:{free_port()}"
        waiting = subprocess.Popen([SEGCTL, "health", "--server", address, "--wait", "60"], stdout=subprocess.PIPE, text=True)
        self.addCleanup(waiting.communicate)
        self.addCleanup(waiting.kill)
        time.sleep(0.5)
        server = Server(self.folder, listen=address)
        self.addCleanup(server.close)
        self.assertEqual(waiting.communicate(timeout=60)[0], f"{address} is SERVING\n")
        self.assertEqual(waiting.returncode, 0)
        begin = time.monotonic()
        self.run_badly(FAILED, "health", "--server", f"127.0.0.1:{free_port()}", "--wait", "1")
        self.assertGreater(time.monotonic() - begin, 0.8)

    def test_a_client_that_vanishes_does_no_harm(self):
        scene = self.synth()
        for _ in range(3):
            segctl("segment", scene, "--server", self.server.address, "--timeout", "0.02")
        self.assertGreater(max(self.segment(scene)[0]), 1)
        self.assertIsNone(self.server.process.poll())


if __name__ == "__main__":
    unittest.main()
