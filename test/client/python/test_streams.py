# SPDX-License-Identifier: Apache-2.0
"""The streams of both clients against a server whose answers the test chooses."""
import asyncio
import threading
import time
import unittest

import grpc
import numpy as np

import segserve
from fake_server import FakeServer
from segserve.v1 import stream_pb2

XYZ = np.ones((4, 5, 3), np.float32)


class BlockingStreams(unittest.TestCase):
    def setUp(self):
        self.server = self.serve()

    def serve(self, *errors):
        server = FakeServer(errors)
        self.addCleanup(server.close)
        return server

    def stream(self, *servers, **rules):
        client = segserve.Client(",".join(server.address for server in servers or (self.server,)))
        self.addCleanup(client.close)
        stream = client.stream(**{"view": "camera", "outputs": "labels", "codec": "planar"} | rules)
        self.addCleanup(stream.close)
        return stream

    def test_echoes_and_reports(self):
        stream = self.stream()
        before = time.monotonic()
        self.assertEqual(stream.send(XYZ, request_id="r", frame_id="f", priority=3), 1)
        outcome = stream.next(timeout=20)
        self.assertEqual((outcome.request_id, outcome.frame_id, outcome.get().labels.tolist()),
                         ("r", "f", [[1] * 5] * 4))
        report = outcome.report
        times = [
            before, report.handed_over, report.header_sent, report.payload_sent, report.outcome_begun,
            report.outcome_done
        ]
        self.assertEqual(times, sorted(times))
        self.assertEqual((report.attempts, report.address), (1, self.server.address))
        self.assertGreater(report.bytes_sent, 240)
        self.assertGreater(report.bytes_received, 20)
        self.assertFalse(stream.done)
        stream.finish()
        self.assertIsNone(stream.next())
        self.assertTrue(stream.done)

    def test_what_makes_no_sense_is_refused_at_once(self):
        for wrong in ({"when_behind": "panic"}, {"order": "random"}, {"outputs": ("colors",)}, {"max_in_flight": 0}):
            with self.assertRaises(ValueError):
                self.stream(**wrong)
        with self.assertRaises(TypeError):
            self.stream(no_such_rule=1)
        stream = self.stream()
        for wrong in ({"points": XYZ[..., :2]}, {"points": XYZ, "outputs": "x"}, {"points": XYZ, "timeout": -1}):
            with self.assertRaises(ValueError):
                stream.send(**wrong)
        self.assertEqual(stream.send(XYZ), 1)

    def test_takes_no_frame_after_the_last(self):
        stream = self.stream()
        stream.finish()
        with self.assertRaises(segserve.FailedPrecondition):
            stream.send(XYZ)
        self.assertEqual(list(stream), [])

    def test_a_failed_frame_does_not_end_the_stream(self):
        def fail_first(header):
            if header.sequence == 1:
                outcome = stream_pb2.FrameOutcome(sequence=1, kind=stream_pb2.OUTCOME_KIND_FAILED)
                outcome.status.code, outcome.status.message = 3, "wrong"
                yield stream_pb2.SegmentStreamResponse(outcome=outcome)
            else:
                yield from FakeServer.result(header)

        self.server.on_frame = fail_first
        outcomes = list(self.stream().map([XYZ] * 2))
        self.assertEqual([outcome.kind.value for outcome in outcomes], ["FAILED", "RESULT"])
        self.assertIsInstance(outcomes[0].error, segserve.InvalidArgument)

    def test_a_broken_answer_is_an_error_of_its_frame(self):
        def lie(header):
            outcome = stream_pb2.FrameOutcome(sequence=header.sequence, kind=stream_pb2.OUTCOME_KIND_RESULT)
            yield stream_pb2.SegmentStreamResponse(outcome=outcome)

        self.server.on_frame = lie
        outcome, = self.stream().map([XYZ])
        self.assertIsInstance(outcome.error, segserve.Internal)

    def test_a_broken_stream_is_reopened_and_nothing_is_lost(self):
        self.server.errors = [(grpc.StatusCode.UNAVAILABLE, "not yet", "", 0)] * 2
        outcomes = list(self.stream().map([XYZ] * 5))
        self.assertEqual([outcome.kind.value for outcome in outcomes], ["RESULT"] * 5)
        self.assertEqual(len(self.server.metadata), 3)

    def test_a_server_that_refuses_us_ends_the_stream(self):
        self.server.errors = [(grpc.StatusCode.UNAUTHENTICATED, "who are you?", "", 0)]
        stream = self.stream()
        try:
            stream.send(XYZ)
        except segserve.Unauthenticated:
            pass  # the refusal was faster than the frame
        else:
            self.assertIsInstance(stream.next(timeout=20).error, segserve.Unauthenticated)
        with self.assertRaises(segserve.Unauthenticated):
            stream.send(XYZ)
        self.assertIsNone(stream.next())
        self.assertEqual(len(self.server.metadata), 1)

    def hold(self, server):
        """Makes a server keep its frames until the event is set."""
        release = threading.Event()
        self.addCleanup(release.set)

        def on_frame(header):
            release.wait(60)
            yield from FakeServer.result(header)

        server.on_frame = on_frame
        return release

    def test_a_silent_server_is_left_for_the_next(self):
        other = self.serve()
        self.hold(self.server)
        self.server.silent.set()
        outcome, = self.stream(self.server, other, progress_timeout=0.4).map([XYZ])
        self.assertEqual((outcome.kind.value, outcome.report.attempts, outcome.report.address),
                         ("RESULT", 2, other.address))

    def test_a_server_that_computes_for_long_is_not_taken_for_dead(self):
        release = self.hold(self.server)
        threading.Timer(1.5, release.set).start()
        outcome, = self.stream(progress_timeout=0.4).map([XYZ])
        self.assertEqual((outcome.kind.value, outcome.report.attempts), ("RESULT", 1))

    def test_the_deadline_of_a_frame_holds_whatever_the_server_does(self):
        self.hold(self.server)
        stream = self.stream()
        stream.send(XYZ, timeout=0.2)
        began = time.monotonic()
        self.assertIsNone(stream.next(timeout=0.05))
        self.assertIsInstance(stream.next().error, segserve.DeadlineExceeded)
        self.assertLess(time.monotonic() - began, 10)

    def test_block_waits_for_the_timeout_of_the_frame(self):
        self.hold(self.server)
        stream = self.stream(max_in_flight=1)
        stream.send(XYZ)
        stream.send(XYZ)
        with self.assertRaisesRegex(segserve.DeadlineExceeded, "frames wait already"):
            stream.send(XYZ, timeout=0.3)

    def test_reject_and_drop_oldest(self):
        release = self.hold(self.server)
        stream = self.stream(max_in_flight=1, when_behind="reject")
        with self.assertRaises(segserve.ResourceExhausted):
            for _ in range(3):
                stream.send(XYZ)
        newest = self.stream(max_in_flight=1, when_behind="drop_oldest")
        newest.send(XYZ)
        while not len(self.server.headers) >= 2:
            time.sleep(0.01)
        for _ in range(3):
            newest.send(XYZ)
        newest.finish()
        release.set()
        self.assertEqual([outcome.kind.value for outcome in newest], ["RESULT", "DROPPED", "DROPPED", "RESULT"])

    def test_fails_at_once_without_server_if_told_to(self):
        self.server.close()
        outcome, = self.stream(wait_for_server=False).map([XYZ])
        self.assertIsInstance(outcome.error, segserve.Unavailable)

    def test_waits_for_a_server_that_comes_back(self):
        self.server.errors = [(grpc.StatusCode.UNAVAILABLE, "starting", "", 0)] * 4
        outcome, = self.stream().map([XYZ])
        self.assertEqual(outcome.kind.value, "RESULT")

    def test_closing_cancels_what_is_unfinished(self):
        self.hold(self.server)
        stream = self.stream()
        stream.send(XYZ)
        while not self.server.headers:
            time.sleep(0.01)
        threads = threading.active_count()
        stream.close()
        self.assertLess(threading.active_count(), threads)
        self.assertEqual([outcome.kind.value for outcome in stream], ["CANCELLED"])
        stream.close()

    def test_a_stream_ends_with_its_client(self):
        self.hold(self.server)
        with segserve.Client(self.server.address) as client:
            stream = client.stream(view="camera")
            self.addCleanup(stream.close)
            stream.send(XYZ)
            while not self.server.headers:
                time.sleep(0.01)
        self.assertEqual([outcome.kind.value for outcome in stream], ["CANCELLED"])
        with self.assertRaises(segserve.FailedPrecondition):
            stream.send(XYZ)

    def test_many_threads_may_send(self):
        stream = self.stream(max_waiting=50, order="done")
        threads = [threading.Thread(target=lambda: [stream.send(XYZ) for _ in range(10)]) for _ in range(4)]
        for thread in threads:
            thread.start()
        outcomes = [stream.next(timeout=30) for _ in range(40)]
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(outcome.sequence for outcome in outcomes), list(range(1, 41)))

    def test_an_error_in_the_caller_ends_its_stream(self):
        self.hold(self.server)
        with self.assertRaises(ZeroDivisionError), self.stream() as stream:
            stream.send(XYZ)
            1 / 0


class AsyncioStreams(unittest.IsolatedAsyncioTestCase):
    def serve(self, *errors):
        server = FakeServer(errors)
        self.addCleanup(server.close)
        return server

    async def stream(self, *servers, **rules):
        client = await self.enterAsyncContext(segserve.aio.Client(",".join(server.address for server in servers)))
        return await self.enterAsyncContext(
            client.stream(**{
                "view": "camera",
                "outputs": "labels",
                "codec": "planar"
            } | rules))

    async def test_outcomes_come_in_order(self):
        server = self.serve((grpc.StatusCode.UNAVAILABLE, "not yet", "", 0))
        stream = await self.stream(server)
        outcomes = [outcome async for outcome in stream.map([XYZ] * 20)]
        self.assertEqual([outcome.sequence for outcome in outcomes], list(range(1, 21)))
        self.assertEqual({outcome.kind.value for outcome in outcomes}, {"RESULT"})
        self.assertTrue(stream.done)

    async def test_frames_may_come_from_a_generator(self):
        async def frames():
            for number in range(3):
                await asyncio.sleep(0.01)
                yield {"points": XYZ, "request_id": str(number)}

        stream = await self.stream(self.serve())
        self.assertEqual([outcome.request_id async for outcome in stream.map(frames())], ["0", "1", "2"])

    async def test_an_error_in_the_frames_reaches_the_caller(self):
        stream = await self.stream(self.serve())
        seen = []
        with self.assertRaisesRegex(ValueError, "xyz: "):
            async for outcome in stream.map([XYZ, XYZ[..., :1]]):
                seen.append(outcome)
        self.assertEqual(len(seen), 1)

    async def test_a_silent_server_is_left_for_the_next(self):
        server, other = self.serve(), self.serve()
        release = threading.Event()
        self.addCleanup(release.set)
        server.on_frame = lambda header: iter(lambda: release.wait(60), True)
        server.silent.set()
        stream = await self.stream(server, other, progress_timeout=0.4)
        outcome, = [outcome async for outcome in stream.map([XYZ])]
        self.assertEqual((outcome.kind.value, outcome.report.attempts, outcome.report.address),
                         ("RESULT", 2, other.address))

    async def test_a_stream_ends_with_its_client(self):
        server = self.serve()
        release = threading.Event()
        self.addCleanup(release.set)
        server.on_frame = lambda header: iter(lambda: release.wait(60), True)
        async with segserve.aio.Client(server.address) as client:
            stream = await self.enterAsyncContext(client.stream(view="camera"))
            await stream.send(XYZ)
            while not server.headers:
                await asyncio.sleep(0.01)
        self.assertEqual([outcome.kind.value async for outcome in stream], ["CANCELLED"])

    async def test_deadlines_rejections_and_cancels(self):
        server = self.serve()
        release = threading.Event()
        self.addCleanup(release.set)
        server.on_frame = lambda header: iter(lambda: release.wait(60), True)
        stream = await self.stream(server, max_in_flight=1, when_behind="reject")
        first = await stream.send(XYZ, timeout=0.3)
        self.assertIsNone(await stream.next(timeout=0.05))
        await stream.send(XYZ)
        with self.assertRaises(segserve.ResourceExhausted):
            await stream.send(XYZ)
        self.assertIsInstance((await stream.next()).error, segserve.DeadlineExceeded)
        stream.cancel(first + 1)
        stream.finish()
        with self.assertRaises(segserve.FailedPrecondition):
            await stream.send(XYZ)
        await stream.close()
        self.assertEqual([outcome.kind.value async for outcome in stream], ["CANCELLED"])


if __name__ == "__main__":
    unittest.main()
