# SPDX-License-Identifier: Apache-2.0
"""Unary calls of both clients: repetition, tokens, TLS, and what is refused before anything is sent."""
import asyncio
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import unittest

import grpc
import numpy as np

import segserve
from segserve.calls import Repetition, Settings
from fake_server import FakeServer

XYZ = np.ones((4, 5, 3), np.float32)
FULL = (grpc.StatusCode.RESOURCE_EXHAUSTED, "full", "QUEUE_FULL", 40)
DRAINING = (grpc.StatusCode.UNAVAILABLE, "about to stop", "DRAINING", 0)


class Blocking:
    """Calls the client that blocks."""

    @staticmethod
    def call(address, use, **settings):
        with segserve.Client(address, **settings) as client:
            return use(client)

    @staticmethod
    def first_of_stream(address, **settings):
        with segserve.Client(address, **settings) as client, client.stream(view="camera") as stream:
            stream.send(XYZ, timeout=40)
            return stream.next().get()


class Asyncio:
    """Calls the client for asyncio."""

    @staticmethod
    def call(address, use, **settings):
        async def run():
            async with segserve.aio.Client(address, **settings) as client:
                return await use(client)

        return asyncio.run(run())

    @staticmethod
    def first_of_stream(address, **settings):
        async def run():
            async with segserve.aio.Client(address, **settings) as client, client.stream(view="camera") as stream:
                await stream.send(XYZ, timeout=40)
                return (await stream.next()).get()

        return asyncio.run(run())


class Calls:
    """The tests of one of the clients."""

    def serve(self, *errors, **arguments):
        server = FakeServer(errors, **arguments)
        self.addCleanup(server.close)
        return server

    def segment(self, address, settings=None, **arguments):
        return self.call(address, lambda client: client.segment(XYZ, view="camera", outputs="labels", **arguments),
                         **(settings or {}))

    def test_a_result_has_the_shape_of_the_cloud(self):
        server = self.serve()
        result = self.segment(server.address, request_id="a", frame_id="b", method="border", regions=3)
        self.assertEqual((result.labels.shape, result.request_id, result.frame_id), ((4, 5), "a", "b"))
        request = server.requests[0]
        self.assertEqual((request.request_id, request.options.regions, request.outputs.labels, request.outputs.tree),
                         ("a", 3, True, False))

    def test_health_and_info(self):
        server = self.serve()
        self.assertTrue(self.call(server.address, lambda client: client.health()))
        self.assertEqual(self.call(server.address, lambda client: client.info()).version, "fake")

    def test_a_full_server_is_asked_again_after_the_time_that_it_asked_for(self):
        server = self.serve(FULL, FULL)
        began = time.monotonic()
        self.segment(server.address)
        self.assertGreaterEqual(time.monotonic() - began, 0.08)
        self.assertEqual(len(server.metadata), 3)

    def test_a_draining_server_is_left_for_the_next(self):
        first, second = self.serve(DRAINING), self.serve()
        self.segment(f"{first.address},{second.address}")
        self.assertEqual((len(first.metadata), len(second.requests)), (1, 1))

    def test_attempts_are_limited(self):
        server = self.serve(*[FULL] * 9)
        with self.assertRaises(segserve.ResourceExhausted) as caught:
            self.segment(server.address, settings={"retry": segserve.Retry(max_attempts=2)})
        self.assertEqual((caught.exception.reason, caught.exception.retry_delay, len(server.metadata)),
                         ("QUEUE_FULL", 0.04, 2))

    def test_what_cannot_get_better_is_not_repeated(self):
        for code, kind in ((grpc.StatusCode.INVALID_ARGUMENT, segserve.InvalidArgument),
                           (grpc.StatusCode.UNAUTHENTICATED, segserve.Unauthenticated),
                           (grpc.StatusCode.PERMISSION_DENIED, segserve.PermissionDenied)):
            server = self.serve((code, "no", "", 0))
            with self.assertRaises(kind):
                self.segment(server.address)
            self.assertEqual(len(server.metadata), 1)

    def test_metadata(self):
        server = self.serve()
        trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
        self.segment(server.address, settings={"token": "secret"}, traceparent=trace)
        self.assertEqual(server.metadata[0]["authorization"], "Bearer secret")
        self.assertEqual(server.metadata[0]["traceparent"], trace)
        with self.assertRaisesRegex(ValueError, "traceparent"):
            self.segment(server.address, traceparent="00-xyz")

    def test_a_token_file_is_read_again(self):
        server = self.serve()
        path = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "token"
        path.write_text("one\n")
        with segserve.Client(server.address, token_file=path) as client:
            client.health()
            path.write_text("another\n")
            client.health()
            path.unlink()
            client.health()
        self.assertEqual([metadata["authorization"] for metadata in server.metadata],
                         ["Bearer one", "Bearer another", "Bearer another"])

    def test_a_cloud_too_large_for_a_message_goes_by_a_stream(self):
        server = self.serve()
        xyz = np.ones((800_000, 3), np.float32)
        result = self.call(server.address,
                           lambda client: client.segment(xyz, view="camera", outputs="labels"),
                           token="secret")
        self.assertEqual(result.labels.shape, (800_000,))
        self.assertEqual((len(server.headers), server.requests), (1, []))
        self.assertEqual(server.metadata[0]["authorization"], "Bearer secret")

    def test_nothing_is_sent_that_makes_no_sense(self):
        server = self.serve()
        for arguments in ({"codec": "none"}, {"options": {"lambada": 1}}, {"outputs": ("label",)}, {"regions": 1.5}):
            with self.assertRaises(ValueError):
                self.call(server.address, lambda client: client.segment(XYZ, **arguments))
        with self.assertRaises(ValueError):
            self.segment(server.address, timeout=0)
        self.assertEqual(server.metadata, [])

    @unittest.skipUnless(shutil.which("openssl"), "there is no openssl")
    def test_tls(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        for name in ("ca", "server", "client"):
            issuer = [] if name == "ca" else ["-CA", folder / "ca.crt", "-CAkey", folder / "ca.key"]
            subprocess.run([
                "openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
                "-days", "2", "-subj", f"/CN={name}", "-addext", f"subjectAltName=DNS:{name}.test", "-keyout",
                folder / f"{name}.key", "-out", folder / f"{name}.crt", *issuer
            ],
                           check=True,
                           capture_output=True)
        read = {name: (folder / name).read_bytes() for name in os.listdir(folder)}
        server = self.serve(
            credentials=grpc.ssl_server_credentials([(read["server.key"], read["server.crt"])], read["ca.crt"], True))
        mine = {
            "ca": folder / "ca.crt",
            "cert": folder / "client.crt",
            "key": folder / "client.key",
            "server_name": "server.test"
        }
        self.assertTrue(
            self.call(server.address, lambda client: client.health(), tls=segserve.Tls(**mine), token="secret"))
        plain = self.serve()
        for address, tls, message in (
                (server.address, {"server_name": "other.test"}, "not believed: Hostname mismatch"),
                (server.address, {"ca": folder / "client.crt"}, "not believed: self-signed certificate"),
                (server.address, {"ca": folder / "server.crt", "server_name": "other.test"}, "not believed"),
                (server.address, {"cert": None, "key": None}, "refuses the client: it asks for a certificate"),
                (plain.address, {}, "the server does not speak TLS"), (server.address, None, "the server speaks TLS")):
            settings = {"tls": None if tls is None else segserve.Tls(**mine | tls), "wait_for_server": True}
            began = time.monotonic()
            with self.subTest(message), self.assertRaisesRegex(segserve.TlsError, message):
                self.call(address, lambda client: client.health(timeout=40), **settings)
            with self.subTest(message, stream=True), self.assertRaisesRegex(segserve.TlsError, message):
                self.first_of_stream(address, **settings)
            self.assertLess(time.monotonic() - began, 20)
        with self.assertRaises(OSError):
            self.call(server.address, lambda client: client.health(), tls=segserve.Tls(ca=folder / "absent"))


class BlockingCalls(Calls, Blocking, unittest.TestCase):
    pass


class AsyncioCalls(Calls, Asyncio, unittest.TestCase):
    pass


class SettingsOfClients(unittest.TestCase):
    def test_a_token_does_not_cross_a_network_unprotected(self):
        with self.assertRaisesRegex(ValueError, "^token: it would cross the network to robot:50051") as caught:
            segserve.Client("127.0.0.1:1,robot", token="secret")
        self.assertNotIn("secret", str(caught.exception))
        segserve.Client("robot", token="secret", tls=segserve.Tls()).close()
        segserve.Client("robot", token="secret", unprotected_token=True).close()
        segserve.Client("unix:/run/segserve,localhost,[::1]:7", token="secret").close()

    def test_that_make_no_sense_are_refused(self):
        for wrong, error in (({
                "address": ""
        }, ValueError), ({
                "timeout": 0
        }, ValueError), ({
                "token": "two\nlines"
        }, ValueError), ({
                "token": ""
        }, ValueError), ({
                "token": "a",
                "token_file": "b"
        }, ValueError), ({
                "token_file": "/absent"
        }, OSError)):
            with self.subTest(wrong), self.assertRaises(error):
                segserve.Client(**wrong)
        with self.assertRaises(ValueError):
            segserve.Tls(cert="x")

    def test_after_close_nothing_goes_out(self):
        client = segserve.Client("127.0.0.1:1")
        client.close()
        with self.assertRaises(segserve.FailedPrecondition):
            client.health()


class Repetitions(unittest.TestCase):
    """The test is the clock."""

    def repetition(self, address="a,b", deadline=100.0, wait_for_server=False):
        return Repetition(Settings(address,
                                   token=None,
                                   token_file=None,
                                   tls=None,
                                   timeout=1,
                                   wait_for_server=wait_for_server,
                                   retry=None,
                                   use_proxy=False,
                                   unprotected_token=False),
                          deadline,
                          seed=1)

    def test_every_address_is_tried_once_if_no_server_answers(self):
        calls = self.repetition()
        for address in (0, 1):
            attempt = calls.next(0)
            self.assertEqual(attempt, (address, 0))
            calls.failed(attempt, segserve.Unavailable(f"no {address}"), 0)
        with self.assertRaisesRegex(segserve.Unavailable, "no 1"):
            calls.next(0)

    def test_or_until_the_deadline_if_that_was_asked_for(self):
        calls, now, tries = self.repetition(wait_for_server=True), 0.0, 0
        with self.assertRaises(segserve.Unavailable):
            while True:
                attempt = calls.next(now)
                now, tries = attempt.not_before, tries + 1
                calls.failed(attempt, segserve.Unavailable("no"), now)
        self.assertTrue(20 < tries < 100 and 90 < now < 100, (tries, now))


if __name__ == "__main__":
    unittest.main()
