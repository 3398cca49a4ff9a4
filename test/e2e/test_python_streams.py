# SPDX-License-Identifier: Apache-2.0
"""Streams of client/python lose no frame when servers stop, and go through TLS."""
import asyncio
import pathlib
import shutil
import tempfile
import threading
import time
import unittest

import numpy as np
import segserve

from certificates import Authority
from harness import Server
from python_client import CODECS, PythonClient


class Streams(PythonClient):
    """Two servers of their own, one of which stops while frames are under way."""

    FRAMES = 24

    def setUp(self):
        self.expected = self.client.segment(self.xyz, self.rgb, view="camera").labels
        self.pair = [Server(self.folder) for _ in range(2)]
        for server in self.pair:
            self.addCleanup(server.close)
        self.addresses = ",".join(server.address for server in self.pair)

    def check(self, outcomes, count):
        self.assertEqual([outcome.sequence for outcome in outcomes], list(range(1, count + 1)))
        for outcome in outcomes:
            np.testing.assert_array_equal(outcome.get().labels, self.expected)

    def run_through(self, stop):
        """Sends frames while the server that has them stops; all come back, the last ones from the other."""
        with segserve.Client(self.addresses) as client, client.stream(view="camera", max_in_flight=4) as stream:
            outcomes = []
            for outcome in stream.map([(self.xyz, self.rgb)] * self.FRAMES):
                outcomes.append(outcome)
                if len(outcomes) == 5:
                    stop(next(server for server in self.pair if server.address == outcome.report.address))
            self.check(outcomes, self.FRAMES)
            self.assertEqual(len({outcome.report.address for outcome in outcomes}), 2)
            return outcomes

    def test_kill_loses_no_frame(self):
        outcomes = self.run_through(lambda server: server.close())
        self.assertGreater(max(outcome.report.attempts for outcome in outcomes), 1)

    def test_drain_loses_no_frame(self):
        thread = []

        def drain(server):
            thread.append(threading.Thread(target=server.terminate))
            thread[0].start()

        outcomes = self.run_through(drain)
        thread[0].join()
        # A frame whose header the server read after SIGTERM is sent again, elsewhere.
        self.assertLessEqual(max(outcome.report.attempts for outcome in outcomes), 2)

    def test_asyncio_with_a_kill(self):
        async def run():
            async with segserve.aio.Client(self.addresses) as client:
                self.assertTrue(await client.health())
                self.assertEqual((await client.info()).version, self.client.info().version)
                one = await client.segment(self.xyz, self.rgb, view="camera")
                np.testing.assert_array_equal(one.labels, self.expected)
                outcomes = []
                async with client.stream(view="camera") as stream:
                    async for outcome in stream.map([(self.xyz, self.rgb)] * self.FRAMES):
                        outcomes.append(outcome)
                        if len(outcomes) == 5:
                            next(server for server in self.pair if server.address == outcome.report.address).close()
                return outcomes

        outcomes = asyncio.run(run())
        self.check(outcomes, self.FRAMES)
        self.assertEqual(len({outcome.report.address for outcome in outcomes}), 2)

    def frames_for(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            yield self.xyz, self.rgb

    def check_moved(self, outcomes):
        self.check(outcomes, len(outcomes))
        self.assertEqual({outcome.report.attempts for outcome in outcomes}, {1})
        self.assertEqual({outcome.report.address for outcome in outcomes}, set(self.addresses.split(",")))

    def test_old_streams_move_and_send_no_frame_twice(self):
        self.pair = [Server(self.folder, "--max-stream-age", "0.3") for _ in range(2)]
        for server in self.pair:
            self.addCleanup(server.close)
        self.addresses = ",".join(server.address for server in self.pair)
        with segserve.Client(self.addresses) as client, client.stream(view="camera") as stream:
            self.check_moved(list(stream.map(self.frames_for(1.5))))

        async def run():
            async with segserve.aio.Client(self.addresses) as client, client.stream(view="camera") as stream:
                return [outcome async for outcome in stream.map(self.frames_for(1.5))]

        self.check_moved(asyncio.run(run()))

    def test_other_codecs_options_and_outcomes(self):
        for codec in CODECS:
            with self.client.stream(view="camera", codec=codec, method="lambda", outputs="labels") as stream:
                stream.send(self.xyz, self.rgb, request_id="a", frame_id="camera", time_to_live=20)
                stream.send(self.xyz, self.rgb, regions=5, outputs=("labels", "tree"))
                stream.send(self.xyz, self.rgb, options={"voxel_resolution": 100})
                stream.finish()
                first, second, third = stream
            expected, _ = self.by_segctl("--codec", codec, "--method", "lambda")
            self.assert_labels(first.get().labels, expected)
            self.assertEqual((first.request_id, first.frame_id, first.get().frame_id, first.get().tree),
                             ("a", "camera", "camera", None))
            self.assertEqual((second.get().segment_count, second.get().method), (5, "border"))
            self.assertEqual(third.kind, segserve.OutcomeKind.FAILED)
            with self.assertRaises(segserve.InvalidArgument):
                third.get()

    def test_a_cancelled_frame_ends_and_the_next_one_passes(self):
        with self.client.stream(view="camera", max_in_flight=1, max_waiting=3, order="done") as stream:
            numbers = [stream.send(self.xyz, self.rgb) for _ in range(3)]
            stream.cancel(numbers[2])
            stream.finish()
            kinds = {outcome.sequence: outcome.kind.value for outcome in stream}
        self.assertEqual(kinds, {1: "RESULT", 2: "RESULT", 3: "CANCELLED"})


class ThroughTls(PythonClient):
    """A server that asks for certificates, with those of an authority of the test."""

    @classmethod
    def setUpClass(cls):
        certificates = pathlib.Path(tempfile.mkdtemp(prefix="segserve-e2e-tls-"))
        cls.addClassCleanup(shutil.rmtree, certificates)
        cls.authority, cls.stranger = Authority(certificates, "authority"), Authority(certificates, "stranger")
        certificate, key = cls.authority.sign("server")
        cls.ca = cls.authority.certificate
        cls.server_flags = ("--tls-cert", str(certificate), "--tls-key", str(key), "--tls-client-ca", str(cls.ca))
        super().setUpClass()

    def test_calls_and_streams(self):
        certificate, key = self.authority.sign("robot")
        tls = segserve.Tls(ca=self.ca, cert=certificate, key=key)
        with segserve.Client(self.server.address, tls=tls) as client:
            labels = client.segment(self.xyz, self.rgb, view="camera").labels
            with client.stream(view="camera") as stream:
                for outcome in stream.map([(self.xyz, self.rgb)] * 3):
                    np.testing.assert_array_equal(outcome.get().labels, labels)

    def test_why_a_connection_fails_is_said_at_once(self):
        certificate, key = self.stranger.sign("robot")
        for tls, message in ((None, "the server speaks TLS"), (segserve.Tls(ca=self.ca), "it asks for a certificate"),
                             (segserve.Tls(ca=self.stranger.certificate), "is not believed"),
                             (segserve.Tls(ca=self.ca, cert=certificate, key=key), "does not believe the client's")):
            with segserve.Client(self.server.address, tls=tls, wait_for_server=True) as client:
                began = time.monotonic()
                with self.subTest(message), self.assertRaisesRegex(segserve.TlsError, message):
                    client.health(timeout=60)
                self.assertLess(time.monotonic() - began, 20)


if __name__ == "__main__":
    unittest.main()
