# SPDX-License-Identifier: Apache-2.0
"""Clients spread frames over several servers, and lose none when a server dies, drains, falls silent or moves."""
import json
import os
import signal
import subprocess
import threading
import time
import unittest

from harness import SEGCTL, SUCCESS, EndToEnd, Server

SCENES = ("--size", "80x60", "--scenes", "2", "--warm-up", "0", "--verify", "--json", "-")
LOAD = (*SCENES, "--clients", "4", "--rate", "80")
# Factor on time limits for machines that run other tests beside this one.
SLACK = float(os.environ.get("FLEET_SLACK", "1"))
FAIR = 0.05  # the least share of the frames that each of three servers gets; a hiccup of the machine costs one much


class Replica(Server):
    """A server at a loopback address of its own."""

    def __init__(self, folder, host, port=0, flags=()):
        super().__init__(folder, *flags, listen=f"{host}:{port}")
        self.host, self.port = host, self.address.rsplit(":", 1)[1]
        self.address = f"{host}:{self.port}"

    def stop(self):
        """The server neither answers nor closes its connections, like a machine whose cable was cut."""
        self.process.send_signal(signal.SIGSTOP)

    def go_on(self):
        self.process.send_signal(signal.SIGCONT)


class FleetTest(EndToEnd):
    def replicas(self, count=3, flags=()):
        servers = []
        for i in range(count):
            server = Replica(self.folder, f"127.0.0.{i + 1}", flags=flags)
            self.addCleanup(server.close)
            self.addCleanup(server.go_on)
            servers.append(server)
        return servers

    def bench(self, address, seconds, *flags, meanwhile=lambda: None, before=(), load=LOAD):
        """Runs the load, and something else one third of its time later. Returns what it tells, after every frame had
        its right result."""
        command = [*before, SEGCTL, "bench", "--server", address, "--duration", str(seconds), *load, *flags]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            timer = threading.Timer(seconds / 3, meanwhile)
            timer.start()
            try:
                output, errors = process.communicate(timeout=seconds + 30 * SLACK)
            finally:
                process.kill()
            timer.join()
        self.assertEqual(process.returncode, SUCCESS, errors.decode())
        told = json.loads(output)
        frames = told["frames"]
        self.assertGreater(frames["sent"], 20)
        self.assertEqual((frames["results"], told["verified"], told["mismatches"]), (frames["sent"], frames["sent"], 0))
        return told

    def share(self, told, server):
        return told["results_of_server"].get(server.address, 0) / told["frames"]["results"]


class Spread(FleetTest):
    def test_each_of_three_servers_gets_its_share(self):
        servers = self.replicas()
        told = self.bench(",".join(server.address for server in servers), 4)
        for server in servers:
            self.assertGreater(self.share(told, server), FAIR, told["results_of_server"])

    def test_one_client_uses_all_servers(self):
        servers = self.replicas()
        told = self.bench(",".join(server.address for server in servers), 3, load=SCENES + ("--in-flight", "6"))
        for server in servers:
            self.assertGreater(self.share(told, server), FAIR, told["results_of_server"])

    def test_a_slow_server_gets_less(self):
        servers = self.replicas()
        ended = threading.Event()

        def slow_down():
            while not ended.is_set():
                servers[0].stop()
                time.sleep(0.2)
                servers[0].go_on()
                time.sleep(0.05)

        slow = threading.Thread(target=slow_down)
        slow.start()
        try:
            told = self.bench(",".join(server.address for server in servers), 6)
        finally:
            ended.set()
            slow.join()
        self.assertLess(self.share(told, servers[0]), 0.2, told["results_of_server"])
        self.assertGreater(min(self.share(told, server) for server in servers[1:]), 0.2, told["results_of_server"])

    def test_calls_use_all_servers_too(self):
        servers = self.replicas()
        scene = self.synth("--width", "80", "--height", "60")
        servers[1].close()
        address = ",".join(server.address for server in servers)
        for _ in range(4):
            self.run_well("segment", scene, "--server", address, "--json", "-")

    def test_many_files_go_to_all_servers(self):
        servers = self.replicas()
        folder = self.path("scenes")
        folder.mkdir()
        for seed in range(12):
            self.run_well("synth", "-o", folder / f"{seed}.pcd", "--quiet", "--width", "80", "--height", "60", "--seed", seed)
        self.run_well("segment", folder, "--out-dir", self.path("out"), "--quiet", "--server",
                      ",".join(server.address for server in servers))


class Loss(FleetTest):
    def lose(self, end, most_seconds, *flags, seconds=6):
        """`end` takes the first of three servers away under load."""
        servers = self.replicas()
        told = self.bench(",".join(server.address for server in servers), seconds, *flags,
                          meanwhile=lambda: end(servers[0]))
        self.assertLess(told["latency_ms"]["max"], 1000 * most_seconds * SLACK)
        for server in servers[1:]:
            self.assertGreater(self.share(told, server), FAIR, told["results_of_server"])
        return told

    def test_killed(self):
        self.lose(lambda server: server.process.kill(), 2)

    def test_drained(self):
        self.lose(lambda server: server.process.send_signal(signal.SIGTERM), 2)

    def test_cut_off_silently(self):
        told = self.lose(Replica.stop, 2.5)
        self.assertGreater(told["frames"]["hedged"], 0)

    def test_a_late_frame_is_hedged_if_asked_for(self):
        told = self.lose(Replica.stop, 2.5, "--hedge-after", "200")
        self.assertGreater(told["frames"]["hedged"], 0)

    def test_a_server_that_comes_back_is_used_again(self):
        servers = self.replicas()
        servers[0].stop()
        told = self.bench(",".join(server.address for server in servers), 9, meanwhile=servers[0].go_on)
        self.assertGreater(self.share(told, servers[0]), 0.1, told["results_of_server"])

    def test_a_client_that_stood_still_suspects_nobody(self):
        servers = self.replicas()
        command = [SEGCTL, "bench", "--server", ",".join(server.address for server in servers), "--duration", "5",
                   *SCENES, "--clients", "2", "--rate", "20"]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            time.sleep(1.5)
            process.send_signal(signal.SIGSTOP)
            time.sleep(1.5)
            process.send_signal(signal.SIGCONT)
            told = json.loads(process.communicate(timeout=120)[0])
        self.assertEqual(process.returncode, SUCCESS)
        self.assertEqual((told["frames"]["results"], told["frames"]["repeated"]), (told["frames"]["sent"], 0))


if __name__ == "__main__":
    unittest.main()
