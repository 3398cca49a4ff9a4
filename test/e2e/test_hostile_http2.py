# SPDX-License-Identifier: Apache-2.0
"""Clients that break the manners of HTTP/2 cost bounded memory, and leave others their service."""
import json
import os
import pathlib
import select
import subprocess
import time
import unittest

import http2
import pcd
from harness import SEGCTL, EndToEnd
from held_connections import HeldConnections
from messages import MIB, OPEN, delimited, file_request, varint

IS_FAST = os.environ.get("BOUNDS_MEMORY", "1") == "1"  # not under a sanitizer
SECONDS = int(os.environ.get("ATTACK_SECONDS", "4"))
UNARY = "/segserve.v1.SegmentationService/Segment"
STREAM = "/segserve.v1.SegmentationService/SegmentStream"


def frame_of_file(sequence, content):
    """The messages of a frame on a stream: its header, and the file in one chunk."""
    block = b"\x20" + varint(len(content))
    header = b"\x08" + varint(sequence) + delimited(5, delimited(17, delimited(1, block))) + b"\x30" + varint(len(content))
    chunk = b"\x08" + varint(sequence) + delimited(2, content)
    return delimited(2, header), delimited(3, chunk)


class Attack(EndToEnd):
    """An attack beside a victim."""
    BUDGET = 256 * MIB
    BEYOND_BUDGET = 128 * MIB  # gRPC's buffers, and the program itself
    server_flags = ("--memory", "256MiB", "--workers", "2")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.usual = cls.await_victim(cls.start_victim())

    @classmethod
    def start_victim(cls):
        return subprocess.Popen([SEGCTL, "bench", "--server", cls.server.address, "--rate", "10", "--size", "80x60",
                                 "--scenes", "1", "--duration", str(SECONDS), "--warm-up", "0", "--timeout", "3", "--json",
                                 "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    @staticmethod
    def await_victim(victim):
        output, errors = victim.communicate(timeout=120)
        assert output, errors
        return json.loads(output)

    def setUp(self):
        super().setUp()
        self.held = HeldConnections()
        self.addCleanup(self.held.close)

    def connect(self, **options):
        connection = self.held.add(http2.Connection(self.server.address, **options))
        for _ in range(2):  # the server's settings and its window
            connection.receive()
        return connection

    def attack(self, once):
        """Does it again and again as long as there is a victim. Returns what became of the victim's frames."""
        victim = self.start_victim()
        while victim.poll() is None:
            try:
                once()
            except OSError:
                time.sleep(0.02)  # the server has closed the connection
        told = self.await_victim(victim)
        frames = told["frames"]
        p99 = told["latency_ms"]["p99"]  # None: among the last percent are frames that failed
        print(f"{self.id()}: victim {frames['results']} of {frames['sent']}, p99 "
              f"{'never' if p99 is None else f'{p99:.0f} ms'}, usual {self.usual['latency_ms']['p99']:.0f} ms; "
              f"peak {self.peak() // MIB} MiB")
        return told

    def peak(self):
        for line in pathlib.Path(f"/proc/{self.server.process.pid}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return 1024 * int(line.split()[1])
        raise AssertionError("no VmHWM")


@unittest.skipUnless(IS_FAST, "attacks are measured by memory and time")
class HostileHttp2(Attack):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.million_points = pcd.equal_points(1_000_000)

    def attack_in_vain(self, once, slow_ms=500):
        """The victim keeps its frames, nearly at their usual latency, and the server its budget of memory."""
        told = self.attack(once)
        self.assertGreaterEqual(told["frames"]["results"], 0.9 * told["frames"]["sent"], told["errors"])
        slow = max(3 * self.usual["latency_ms"]["p99"], slow_ms)  # a few frames say little, and other tests run beside this one
        self.assertLess(told["latency_ms"]["p90"], slow)
        self.assertLess(self.peak(), self.BUDGET + self.BEYOND_BUDGET)

    def test_results_of_calls_that_nobody_reads(self):
        connections = [self.connect(window=0) for _ in range(10)]
        request = http2.message(file_request(self.million_points))
        calls = 0

        def once():
            nonlocal calls
            connection = connections[calls % len(connections)]
            calls += 1
            if calls <= 100:
                connection.send_data(connection.call(UNARY), request, http2.END_STREAM)
            time.sleep(0.02)

        self.attack_in_vain(once)

    def test_results_of_streams_that_nobody_reads(self):
        streams = []

        def once():
            if len(streams) < 30:
                connection = self.connect(window=0)
                stream = connection.call(STREAM)
                connection.send_data(stream, http2.message(OPEN))
                for sequence in range(1, 9):
                    for message in frame_of_file(sequence, self.million_points):
                        connection.send_data(stream, http2.message(message))
                streams.append(stream)
            time.sleep(0.02)

        self.attack_in_vain(once)

    def test_requests_that_never_end(self):
        connections = []

        def once():
            if len(connections) < 100:
                connection = self.connect()
                connections.append(connection)
                for _ in range(4):
                    stream = connection.call(UNARY)
                    connection.send_data(stream, b"\0" + (8 * MIB).to_bytes(4, "big") + bytes(200_000))
            time.sleep(0.02)

        self.attack_in_vain(once)

    def test_header_continuation_without_end(self):
        filler = b"".join(http2.literal(b"x-%03d" % i, b"y" * 100) for i in range(140))

        def once():
            connection = self.connect()
            with connection.socket:
                connection.send(http2.HEADERS, 0, 1, http2.headers_of_call(UNARY))
                for _ in range(64):
                    connection.send(http2.CONTINUATION, 0, 1, filler)

        self.attack_in_vain(once)

    def test_garbage_instead_of_frames(self):
        def once():
            connection = self.connect()
            with connection.socket:
                connection.socket.sendall(os.urandom(10_000))

        self.attack_in_vain(once)

    def test_pings(self):
        connection = self.connect()

        def once():
            nonlocal connection
            try:
                connection.socket.sendall(http2.Connection.frame(http2.PING, 0, 0, bytes(8)) * 100)
                while select.select([connection.socket], [], [], 0)[0]:
                    if not connection.socket.recv(65536):
                        raise OSError("closed")
            except OSError:
                connection = self.connect()

        self.attack_in_vain(once)

    def reset_rapidly(self, methods, connections=1):
        """Opens calls and resets them at once, as fast as possible (CVE-2023-44487, to which gRPC 1.51 is open). The victim
        is there before, because new connections of an address that floods the server wait."""
        open_ones = [self.connect() for _ in range(connections)]
        turn = 0

        def once():
            nonlocal turn
            if turn == 0:
                time.sleep(0.5)
            turn += 1
            place = turn % connections
            connection = open_ones[place]
            try:
                for i in range(50):
                    stream = connection.call(methods[i % len(methods)])
                    connection.send(http2.RST_STREAM, 0, stream, (8).to_bytes(4, "big"))
                while select.select([connection.socket], [], [], 0)[0]:
                    if not connection.socket.recv(65536):
                        raise OSError("closed")
            except OSError:
                open_ones[place] = self.connect()

        self.attack_in_vain(once, slow_ms=2000)  # frames wait for the calls that came before the connection was ended

    def test_rapid_reset(self):
        self.reset_rapidly([UNARY])

    def test_rapid_reset_of_streams_and_of_what_there_is_not(self):
        self.reset_rapidly([STREAM, "/no.such.Service/Method", "/grpc.health.v1.Health/Watch"])

    def test_rapid_reset_on_many_connections(self):
        self.reset_rapidly([UNARY, STREAM], connections=20)


@unittest.skipUnless(IS_FAST, "attacks are measured by memory and time")
class WeaknessesOfGrpc(Attack):
    """gRPC 1.51 is open to these: SECURITY.md says what they do. The server must survive them, and serve as before
    afterwards."""

    def test_empty_data_frames(self):
        connection = self.connect()
        stream = connection.call(UNARY)

        def once():
            nonlocal connection, stream
            try:
                connection.socket.sendall(http2.Connection.frame(http2.DATA, 0, stream) * 1000)
            except OSError:
                connection = self.connect()
                stream = connection.call(UNARY)

        self.attack(once)
        self.serves_as_before()

    def serves_as_before(self):
        """Once gRPC has worked off what came. Until then it may not answer at all."""
        deadline = time.monotonic() + 60
        while True:
            output, errors = self.start_victim().communicate(timeout=120)
            frames = json.loads(output)["frames"] if output else None
            if frames and frames["results"] == frames["sent"]:
                return
            self.assertLess(time.monotonic(), deadline, frames or errors)



if __name__ == "__main__":
    unittest.main()
