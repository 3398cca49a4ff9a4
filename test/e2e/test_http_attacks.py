# SPDX-License-Identifier: Apache-2.0
"""Attacks on the web entrance, in short. Beside each one an honest client, the victim, goes on."""
import contextlib
import os
import pathlib
import re
import shutil
import socket
import tempfile
import threading
import time
import unittest

from harness import SUCCESS, segctl
from held_connections import HeldConnections
from http_client import WebServer

SECONDS = float(os.environ.get("ATTACK_SECONDS", "4"))
MEMORY = 512 << 20
#: Memory of the process beyond the budget of frames: the program, its buffers and the victim's frames.
SLACK = 256 << 20
BOUNDS_MEMORY = os.environ.get("BOUNDS_MEMORY", "1") == "1"  # not under a sanitizer
#: The victim's answers must come within this time, also on a machine that does other things.
VICTIM_SECONDS = 5 * float(os.environ.get("FLEET_SLACK", "1"))  # a sanitizer adds to it


class Victim:
    """Asks again and again, each time on a connection of its own; counts what went wrong."""

    def __init__(self, server, scene):
        self.server, self.body = server, pathlib.Path(scene).read_bytes()
        self.answers, self.faults, self.slowest = 0, [], 0.0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self):
        while not self._stop.is_set():
            begin = time.monotonic()
            try:
                status, _, body = self.server.request("POST", "/v1/segment", self.body, timeout=VICTIM_SECONDS)
                if status == 200:
                    self.answers += 1
                else:
                    self.faults.append((status, body[:200]))
            except OSError as error:
                self.faults.append(repr(error))
            self.slowest = max(self.slowest, time.monotonic() - begin)
            self._stop.wait(0.1)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *error):
        self._stop.set()
        self._thread.join()


class HttpAttacks(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-http-attacks-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.scene = self.folder / "scene.pcd"
        self.assertEqual(segctl("synth", "-o", self.scene, "-q", "--width", 64, "--height", 48).returncode, SUCCESS)
        # Its check of its own listeners must not take an attack for a deaf listener, however often it looks.
        self.server = WebServer(self.folder, "--memory", str(MEMORY), "--listener-check", "0.5")
        self.addCleanup(self.server.close)
        self.held = HeldConnections()
        self.addCleanup(self.held.close)

    def connect(self):
        return self.held.add(socket.create_connection(("127.0.0.1", self.server.http_port), timeout=20))

    def resident(self):
        status = pathlib.Path(f"/proc/{self.server.process.pid}/status").read_text()
        return int(status.split("VmHWM:")[1].split()[0]) << 10

    def survive(self, attack, least_answers=5 if BOUNDS_MEMORY else 1):
        """Attacks for some seconds, and expects that the victim notices nothing and that the memory is bounded."""
        with Victim(self.server, self.scene) as victim:
            end = time.monotonic() + SECONDS
            while time.monotonic() < end:
                attack()
        self.assertEqual(victim.faults, [])
        self.assertGreaterEqual(victim.answers, least_answers)
        if BOUNDS_MEMORY:
            self.assertLess(self.resident(), MEMORY + SLACK)
        self.assertEqual(self.server.request("GET", "/healthz")[0], 200)
        print(f"{self.id()}: {victim.answers} answers, the slowest after {victim.slowest:.2f} s, "
              f"{self.resident() >> 20} MiB", flush=True)
        begin = time.monotonic()
        self.assertEqual(self.server.terminate(), 0)
        self.assertLess(time.monotonic() - begin, 10)

    def send(self, connection, content):
        """True if the server still takes it."""
        try:
            connection.sendall(content)
            return True
        except OSError:
            return False

    def test_slow_headers(self):
        slow = [self.connect() for _ in range(300)]
        for connection in slow:
            self.send(connection, b"POST /v1/segment HTTP/1.1\r\nHost: localhost\r\n")

        def attack():
            for connection in slow:
                self.send(connection, b"X: y\r\n")
            time.sleep(0.5)

        self.survive(attack)

    def test_headers_that_never_end(self):
        def attack():
            connection = self.connect()
            while self.send(connection, b"X-Header: " + b"y" * 4000 + b"\r\n"):
                pass
            connection.close()

        self.survive(attack)

    def test_slow_bodies(self):
        def attack():
            for _ in range(20):
                connection = self.connect()
                self.send(connection, b"POST /v1/segment HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\n" + b"x" * 10)
            time.sleep(0.5)

        self.survive(attack)

    def test_lengths_that_are_lies(self):
        def attack():
            for length in (b"99999999999999999999", b"18446744073709551615", b"-1", b"536870913", b"400000000", b"0x10"):
                connection = self.connect()
                self.send(connection, b"POST /v1/segment HTTP/1.1\r\nHost: localhost\r\nContent-Length: " + length + b"\r\n\r\nx")
            time.sleep(0.1)

        self.survive(attack)

    def test_bombs_of_chunks(self):
        def attack():
            connection = self.connect()
            self.send(connection, b"POST /v1/segment HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n")
            self.send(connection, b"1\r\nx\r\n" * 50_000)
            self.send(connection, b"1;" + b"e" * 200_000 + b"\r\n")
            for size in (b"ffffffffffffffff", b"7fffffffffffffff", b"zz"):
                other = self.connect()
                self.send(other, b"POST /v1/segment HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n" + size +
                          b"\r\nx")

        self.survive(attack)

    def test_connections_faster_than_they_are_accepted_do_not_end_the_server(self):
        small_chunks = b"1\r\nx\r\n" * 1100  # more than the server takes, and as much work as it does for a refusal
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            connection = self.connect()
            self.send(connection, b"POST /v1/segment HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n" +
                      small_chunks)
        begin = time.monotonic()
        self.assertEqual(self.server.request("GET", "/healthz", timeout=60)[0], 200)
        print(f"{self.id()}: answers after {time.monotonic() - begin:.2f} s", flush=True)
        self.assertEqual(self.server.terminate(), 0)

    def test_a_body_in_chunks_that_never_ends_is_bounded(self):
        connection = self.connect()
        self.send(connection, b"POST /v1/segment HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n")
        piece = b"%x\r\n%s\r\n" % (1 << 20, b"x" * (1 << 20))

        def attack():
            nonlocal connection
            if not self.send(connection, piece):
                connection = self.connect()
                self.send(connection, b"POST /v1/segment HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n")

        self.survive(attack)

    def test_many_idle_connections(self):
        def attack():
            with contextlib.suppress(OSError):
                for _ in range(100):
                    self.connect()
            time.sleep(0.2)

        self.survive(attack)

    def test_pipelining(self):
        def attack():
            connection = self.connect()
            connection.settimeout(1)
            self.send(connection, b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n" * 2000)
            with contextlib.suppress(OSError):
                while connection.recv(1 << 20):
                    pass
            connection.close()

        self.survive(attack)

    def test_pipelined_requests_are_answered_in_order(self):
        connection = self.connect()
        self.send(connection, b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\nGET /none HTTP/1.1\r\nHost: localhost\r\n\r\n"
                  b"GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        answer = b""
        while part := connection.recv(1 << 16):
            answer += part
        self.assertEqual(re.findall(rb"HTTP/1.1 (\d+)", answer), [b"200", b"404", b"200"])

    def test_clients_that_do_not_read_their_answers(self):
        body = self.scene.read_bytes()
        header = (b"POST /v1/segment?outputs=labels,supervoxels,tree,segments HTTP/1.1\r\nHost: localhost\r\n"
                  b"Content-Length: %d\r\n\r\n" % len(body))

        def attack():
            for _ in range(5):
                connection = socket.socket()
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                connection.connect(("127.0.0.1", self.server.http_port))
                self.held.add(connection)
                self.send(connection, header + body)
            time.sleep(0.5)

        self.survive(attack)

    def test_clients_that_go_away(self):
        body = self.scene.read_bytes()

        def attack():
            for share in (0.5, 1):
                connection = self.connect()
                self.send(connection, b"POST /v1/segment HTTP/1.1\r\nHost: localhost\r\nContent-Length: %d\r\n\r\n" % len(body) +
                          body[:int(share * len(body))])
                connection.close()
            time.sleep(0.05)

        self.survive(attack)

    def test_garbage_and_smuggling(self):
        def attack():
            for content in (b"\x16\x03\x01\x02\x00", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n",
                            b"GET  HTTP/1.1\r\n\r\n", b"\0" * 100, b"GET / HTTP/1.1\r\nA\r\n\r\n",
                            b"POST /v1/segment HTTP/1.1\r\nContent-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET /",
                            b"POST /v1/segment HTTP/1.1\r\nContent-Length: 5\r\nContent-Length: 6\r\n\r\nabcdef"):
                connection = self.connect()
                connection.settimeout(3)
                self.send(connection, content)
                connection.shutdown(socket.SHUT_WR)
                with contextlib.suppress(OSError):
                    answer = connection.recv(1 << 16)
                    self.assertTrue(answer == b"" or answer.startswith(b"HTTP/1.1 4"), (content, answer))
                connection.close()

        self.survive(attack)


if __name__ == "__main__":
    unittest.main()
