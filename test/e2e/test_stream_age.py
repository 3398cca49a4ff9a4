# SPDX-License-Identifier: Apache-2.0
"""Streams move to other servers, because they are old or because their server stops, and lose no frame."""
import json
import subprocess
import threading
import time
import unittest

from harness import SEGCTL, SUCCESS, EndToEnd, Server

LOAD = ("--size", "80x60", "--scenes", "2", "--warm-up", "0", "--clients", "3", "--rate", "60", "--verify", "--json", "-")


class StreamAge(EndToEnd):
    server_flags = ("--max-stream-age", "0.5")

    def start(self, *flags, **options):
        server = Server(self.folder, *flags, **options)
        self.addCleanup(server.close)
        return server

    def bench(self, addresses, seconds, meanwhile=lambda: None):
        """Runs the load and returns what it tells, after every frame had its right result."""
        command = [SEGCTL, "bench", "--server", addresses, "--duration", str(seconds), *LOAD]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            during = threading.Thread(target=meanwhile)
            during.start()
            output, errors = process.communicate(timeout=120)
            during.join()
        self.assertEqual(process.returncode, SUCCESS, errors.decode())
        told = json.loads(output)
        frames = told["frames"]
        self.assertGreater(frames["sent"], 20)
        self.assertEqual((frames["results"], told["verified"], told["mismatches"]), (frames["sent"], frames["sent"], 0))
        return told

    def test_old_streams_move_on_without_losing_a_frame(self):
        log = self.path("log")
        server = self.start(*self.server_flags, log=log)
        told = self.bench(server.address, 4)
        self.assertEqual(told["frames"]["repeated"], 0)
        self.assertEqual(server.terminate(), SUCCESS)
        # Three clients, and about seven streams of each.
        self.assertGreater(log.read_text().count("SegmentStream"), 3 * 3)

    def test_a_new_replica_gets_load(self):
        # All streams begin at the first server. Later the second one starts at an address that they know.
        first = self.server
        second = self.start()
        address = second.address
        second.terminate()
        replica = []

        def start_later():
            time.sleep(1.5)
            replica.append(self.start(*self.server_flags, listen=address))

        told = self.bench(f"{first.address},{address}", 5, start_later)
        self.assertEqual(replica[0].address, address)
        self.assertGreaterEqual(told["results_of_server"][address], 10)

    def test_frames_of_a_server_that_stops_go_elsewhere(self):
        stopping, other = self.start(), self.start()
        codes = []

        def stop():
            time.sleep(1.5)
            codes.append(stopping.terminate())

        self.bench(f"{stopping.address},{other.address}", 4, stop)
        self.assertEqual(codes, [SUCCESS])


if __name__ == "__main__":
    unittest.main()
