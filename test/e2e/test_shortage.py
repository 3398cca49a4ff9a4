# SPDX-License-Identifier: Apache-2.0
"""A server that runs short of what the system gives it, and one that has to stop in the middle of its work."""
import json
import os
import pathlib
import resource
import signal
import socket
import subprocess
import threading
import time
import unittest

import grpc

from harness import SEGCTL, SEGSERVE, SUCCESS, EndToEnd, Server, segctl

MIB = 1 << 20
IS_FAST = os.environ.get("BOUNDS_MEMORY", "1") == "1"  # not under a sanitizer
DEAF = 4
SERVING, NOT_SERVING = b"\x08\x01", b"\x08\x02"  # HealthCheckResponse
UNARY = "/segserve.v1.SegmentationService/Segment"


def at_most(what, value):
    return lambda: resource.setrlimit(what, (value, value))


def bench(address, *flags):
    return subprocess.Popen([SEGCTL, "bench", "--server", address, "--size", "160x120", "--scenes", "2", "--json", "-",
                             *flags], stdout=subprocess.PIPE, stderr=subprocess.PIPE)


class FileDescriptors(EndToEnd):
    def fill(self, family, address):
        """Opens more connections than a server with few descriptors can have, and closes them again."""
        connections = []
        try:
            for _ in range(100):
                connections.append(socket.socket(family))
                connections[-1].settimeout(1)
                connections[-1].connect(address)
        except OSError:
            pass  # the backlog is full
        time.sleep(1)
        for connection in connections:
            connection.close()

    def test_idle_connections_to_a_port_leave_the_server_its_descriptors(self):
        server = Server(self.folder, "--listener-check", "0.5", before=at_most(resource.RLIMIT_NOFILE, 64))
        self.addCleanup(server.close)
        host, port = server.address.split(":")
        for _ in range(3):
            self.fill(socket.AF_INET, (host, int(port)))
            self.run_well("health", "--server", server.address, "--timeout", "5")
        self.assertEqual(server.terminate(), 0)

    def test_a_server_that_has_become_deaf_ends(self):
        port_file, path = self.path("health-port"), str(self.folder / "socket")
        server = Server(self.folder, "--listener-check", "0.5", "--health-listen", "127.0.0.1:0",
                        "--health-port-file", str(port_file), listen=f"unix:{path}",
                        before=at_most(resource.RLIMIT_NOFILE, 64))
        self.addCleanup(server.close)
        channel = grpc.insecure_channel(f"127.0.0.1:{port_file.read_text().strip()}",
                                        options=[("grpc.enable_http_proxy", 0)])
        self.addCleanup(channel.close)
        liveness = channel.unary_stream("/grpc.health.v1.Health/Watch")(b"\x0a\x08liveness", timeout=60)
        self.assertEqual(next(liveness), SERVING)
        self.fill(socket.AF_UNIX, path)
        # At a path gRPC listens itself, and 1.51 accepts no more connections after that. Versions that do are right, too.
        deadline = time.monotonic() + 20
        while server.process.poll() is None and time.monotonic() < deadline:
            if segctl("health", "--server", f"unix:{path}", "--timeout", "1").returncode == SUCCESS:
                return
        self.assertEqual(server.process.poll(), DEAF)
        self.assertEqual(next(liveness), NOT_SERVING)


class IdleConnections(EndToEnd):
    """Connections that bring nothing, to an entrance beside gRPC, leave gRPC its descriptors."""

    def setUp(self):
        files = {name: self.path(f"{name}-port") for name in ("health", "http", "metrics")}
        ports = [part for name, path in files.items() for part in (f"--{name}-port-file", str(path))]
        self.one = Server(self.folder, "--listener-check", "0.5", "--health-listen", "127.0.0.1:0", "--http",
                          "127.0.0.1:0", "--metrics-listen", "127.0.0.1:0", *ports,
                          before=at_most(resource.RLIMIT_NOFILE, 128))
        self.addCleanup(self.one.close)
        self.ports = {name: int(path.read_text()) for name, path in files.items()}

    def flood(self, port, count):
        connections = []
        for _ in range(count):
            connections.append(socket.create_connection(("127.0.0.1", port), timeout=5))
            self.addCleanup(connections[-1].close)
        return connections

    def served(self):
        self.run_well("health", "--server", self.one.address, "--timeout", "5")
        self.assertIsNone(self.one.process.poll())

    def test_they_leave_grpc_its_descriptors(self):
        for name, port in self.ports.items():
            with self.subTest(entrance=name):
                connections = self.flood(port, 160)
                time.sleep(2.5)  # longer than three checks of the listeners
                self.served()
                self.run_well("health", "--server", f"127.0.0.1:{self.ports['health']}", "--timeout", "5")
                for connection in connections:
                    connection.close()
        self.served()

    def test_probes_are_answered_while_others_hold_connections(self):
        self.flood(self.ports["health"], 160)
        for _ in range(20):
            self.run_well("health", "--server", f"127.0.0.1:{self.ports['health']}", "--timeout", "5")

    def test_a_silent_connection_to_the_health_port_ends(self):
        silent = self.flood(self.ports["health"], 1)[0]
        silent.settimeout(20)
        while silent.recv(4096):  # the server's settings of HTTP/2, and at last the end
            pass


@unittest.skipUnless(IS_FAST, "a sanitizer needs a large address space")
class AddressSpace(EndToEnd):
    def test_every_call_ends_and_so_does_the_server(self):
        server = Server(self.folder, "--workers", "2", "--grace-period", "2", "--memory", "4GiB",
                        before=at_most(resource.RLIMIT_AS, 900 * MIB))
        self.addCleanup(server.close)
        scene = self.synth("--width", "640", "--height", "480")
        clients = [subprocess.Popen([SEGCTL, "segment", scene, "--server", server.address, "--timeout", "20", "--quiet",
                                     "--voxel-resolution", "0.002", "--seed-resolution", "0.02", "-o",
                                     self.path(f"out-{i}.pcd")],
                                    stderr=subprocess.PIPE) for i in range(12)]
        channel = grpc.insecure_channel(server.address)
        self.addCleanup(channel.close)
        garbage = [channel.unary_unary(UNARY).future(b"\x82\x01" + bytes([0x80, 0x80, 0x80, 0x03]) + bytes(6 * MIB),
                                                     timeout=30) for _ in range(40)]
        for call in garbage:
            self.assertIsNotNone(call.exception(timeout=60))
        for client in clients:
            client.communicate(timeout=60)
        if server.process.poll() is None:  # gRPC itself ends a process that lacks memory
            began = time.monotonic()
            server.process.send_signal(signal.SIGTERM)
            server.process.wait(timeout=30)
            self.assertLess(time.monotonic() - began, 2 + 2 + 1)


class Stops(EndToEnd):
    def test_sigterm_under_load_loses_nothing(self):
        servers = [Server(self.folder, "--grace-period", "10") for _ in range(2)]
        for server in servers:
            self.addCleanup(server.close)
        both = ",".join(server.address for server in servers)
        load = bench(both, "--clients", "4", "--duration", "8", "--verify")
        for server in servers:  # one after the other, and each comes back before the next one goes
            time.sleep(2)
            port = server.address.split(":")[1]
            began = time.monotonic()
            self.assertEqual(server.terminate(), 0)
            self.assertLess(time.monotonic() - began, 10 + 2)
            again = subprocess.Popen([SEGSERVE, "--listen", f"127.0.0.1:{port}", "--log-level", "error"])
            self.addCleanup(again.wait)
            self.addCleanup(again.kill)
        output, errors = load.communicate(timeout=120)
        told = json.loads(output)
        self.assertEqual(load.returncode, SUCCESS, errors)
        self.assertEqual(told["errors"], {})
        self.assertEqual(told["mismatches"], 0)
        self.assertGreater(told["verified"], 20)

    def test_dribbling_clients_do_not_delay_the_end(self):
        server = Server(self.folder, "--grace-period", "1")
        self.addCleanup(server.close)
        host, port = server.address.split(":")
        with socket.create_connection((host, int(port))) as connection:
            connection.sendall(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0")
            stop = threading.Event()

            def dribble():
                while not stop.wait(0.1):
                    try:
                        connection.sendall(b"\0")
                    except OSError:
                        return

            thread = threading.Thread(target=dribble)
            thread.start()
            time.sleep(0.5)
            began = time.monotonic()
            self.assertEqual(server.terminate(), 0)
            self.assertLess(time.monotonic() - began, 1 + 2)
            stop.set()
            thread.join()


@unittest.skipUnless(IS_FAST, "a sanitizer keeps freed memory")
class MemoryAfterwards(EndToEnd):
    server_flags = ("--workers", "2")

    def resident(self):
        for line in pathlib.Path(f"/proc/{self.server.process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return 1024 * int(line.split()[1])
        raise AssertionError("no VmRSS")

    def test_memory_goes_back_to_the_system(self):
        before = self.resident()
        scene = self.synth("--width", "1600", "--height", "1200")
        for _ in range(2):
            self.segment(scene)
        self.assertGreater(self.resident(), before + 120 * MIB, "the frames were to need memory")
        deadline = time.monotonic() + 60
        # The ends of the arenas of gRPC's threads stay: some 20 MiB each.
        while self.resident() > before + 96 * MIB and time.monotonic() < deadline:
            time.sleep(1)
        self.assertLess(self.resident(), before + 96 * MIB)


if __name__ == "__main__":
    unittest.main()
