# SPDX-License-Identifier: Apache-2.0
"""What a stream decides about its frames. The test is the clock, the transport and the servers."""
import unittest
import zlib

import segserve
from segserve import Order, WhenBehind
from segserve._stream.scheduler import Admission
from segserve._stream.service_time import ServiceTime
from segserve.v1 import stream_pb2
from stream_harness import StreamHarness, outcome


class Frames(unittest.TestCase):
    def test_opens_at_once_and_sends_nothing_before_the_server_agrees(self):
        stream = StreamHarness()
        stream.act()
        self.assertEqual(len(stream.connections), 1)
        stream.send()
        self.assertEqual([message.WhichOneof("kind") for message in stream.sent()], ["open"])
        stream.open()
        header, *chunks = stream.sent()
        self.assertEqual(header.frame.encoded_bytes, 1500)
        self.assertEqual(header.frame.cloud.planar.x.data, b"")
        self.assertEqual(header.frame.cloud.planar.x.encoded_bytes, 400)
        self.assertEqual([len(message.chunk.data) for message in chunks], [400, 400, 400, 300])

    def test_keeps_to_the_servers_credit_and_its_own_window(self):
        narrow = StreamHarness(max_in_flight=2, max_waiting=10)
        narrow.open(frames=4)
        for _ in range(5):
            narrow.send()
        self.assertEqual(narrow.begun(), 2)
        narrow.end(1)
        self.assertEqual(narrow.begun(), 0, "the result was not taken yet")
        self.assertEqual(len(narrow.taken()), 1)
        self.assertEqual(narrow.begun(), 1)

        wide = StreamHarness(max_in_flight=10, max_waiting=10)
        wide.open(frames=3)
        for _ in range(5):
            wide.send()
        self.assertEqual(wide.begun(), 3)
        wide.end(1)
        self.assertEqual(wide.begun(), 1)

        small = StreamHarness(max_in_flight=10, max_waiting=10)
        small.open(frames=10, size=3200)  # enough for two frames of 1500 bytes
        for _ in range(5):
            small.send()
        self.assertEqual(small.begun(), 2)
        small.end(2)
        self.assertEqual(small.begun(), 1)

    def test_a_frame_beyond_the_credit_fails_and_says_why(self):
        stream = StreamHarness()
        stream.open(size=1499)
        stream.send()
        self.assertEqual(stream.begun(), 0)
        self.assertEqual(stream.taken(), [(1, "FAILED")])
        self.assertIsInstance(stream.last.error, segserve.InvalidArgument)
        self.assertEqual(stream.last.error.metadata, {"limit": "credit.bytes", "allowed": "1499", "actual": "1500"})

    def test_block_waits_reject_refuses_drop_oldest_drops(self):
        block = StreamHarness(when_behind=WhenBehind.BLOCK, max_waiting=2)
        block.send()
        self.assertIs(block.scheduler.admission(), Admission.OPEN)
        block.send()
        self.assertIs(block.scheduler.admission(), Admission.WAIT)

        reject = StreamHarness(when_behind=WhenBehind.REJECT)
        reject.send()
        self.assertIs(reject.scheduler.admission(), Admission.REFUSED)
        self.assertIsInstance(reject.scheduler.refusal(), segserve.ResourceExhausted)
        reject.scheduler.finish_sending()
        self.assertIsInstance(reject.scheduler.refusal(), segserve.FailedPrecondition)

        drop = StreamHarness(when_behind=WhenBehind.DROP_OLDEST, max_waiting=2)
        for _ in range(4):
            self.assertIs(drop.scheduler.admission(), Admission.OPEN)
            drop.send()
        self.assertEqual(drop.taken(), [(1, "DROPPED"), (2, "DROPPED")])

    def test_frames_on_their_way_are_not_dropped(self):
        stream = StreamHarness(when_behind=WhenBehind.DROP_OLDEST, max_in_flight=1)
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        stream.send()
        stream.send()
        stream.end(1)
        self.assertEqual(stream.taken(), [(1, "RESULT"), (2, "DROPPED")])

    def test_outcomes_come_in_the_order_asked_for(self):
        sent = StreamHarness(order=Order.SENT, max_waiting=4)
        sent.open()
        for _ in range(3):
            sent.send()
        self.assertEqual(sent.begun(), 3)
        sent.end(3)
        sent.end(2)
        self.assertEqual(sent.taken(), [])
        sent.end(1)
        self.assertEqual([sequence for sequence, _ in sent.taken()], [1, 2, 3])

        done = StreamHarness(order=Order.DONE, max_waiting=4)
        done.open()
        for _ in range(3):
            done.send()
        self.assertEqual(done.begun(), 3)
        done.end(3)
        self.assertEqual(done.taken(), [(3, "RESULT")])

    def test_results_that_came_early_do_not_shut_out_the_one_they_wait_for(self):
        stream = StreamHarness(max_in_flight=2, max_waiting=4)
        stream.open()
        for _ in range(3):
            stream.send()
        self.assertEqual(stream.begun(), 2)
        stream.fail(1, segserve.Aborted("crc"))
        self.assertEqual(stream.begun(), 1)  # frame 3 has number 3 on the wire, while frame 1 waits
        stream.end(2)
        stream.end(3)
        stream.pass_time(1)
        self.assertEqual(stream.begun(), 1)  # frame 1 has number 4
        stream.end(4)
        self.assertEqual(len(stream.taken()), 3)

    def test_counts_the_bytes_of_all_messages_of_an_outcome(self):
        stream = StreamHarness()
        stream.open()
        for chunk in (400, 1200):
            number = stream.send()
            stream.sent()
            response = outcome(number)
            response.outcome.encoded_bytes, response.outcome.crc32 = 1200, zlib.crc32(b"x" * 1200)
            response.outcome.result.labels.data.encoded_bytes = 1200
            size = response.ByteSize()
            stream.answer(response)
            for _ in range(0, 1200, chunk):
                part = stream_pb2.SegmentStreamResponse(chunk=stream_pb2.ResultChunk(sequence=number, data=b"x" *
                                                                                     chunk))
                size += part.ByteSize()
                stream.answer(part)
            self.assertEqual(len(stream.taken()), 1)
            self.assertEqual(stream.last.report.bytes_received, size)

    def test_a_damaged_result_is_asked_for_again(self):
        stream = StreamHarness()
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        response = outcome(1)
        response.outcome.encoded_bytes, response.outcome.crc32 = 4, zlib.crc32(b"good")
        response.outcome.result.labels.data.encoded_bytes = 4
        stream.answer(response)
        stream.answer(stream_pb2.SegmentStreamResponse(chunk=stream_pb2.ResultChunk(sequence=1, data=b"evil")))
        self.assertEqual(stream.taken(), [])
        self.assertEqual(stream.begun(), 1)
        self.assertEqual(len(stream.connections), 1)

    def test_higher_priority_goes_first(self):
        stream = StreamHarness(order=Order.DONE, max_in_flight=1, max_waiting=4)
        for priority in (0, 5, 5):
            stream.send(priority=priority)
        stream.open()
        self.assertEqual(stream.begun(), 1)
        stream.end(1)
        self.assertEqual(stream.taken(), [(2, "RESULT")])

    def test_the_age_counts_from_the_capture(self):
        stream = StreamHarness(max_waiting=3)
        stream.send(captured=stream.now - 0.25, time_to_live=1)
        stream.send(captured=stream.now - 0.9, time_to_live=1)
        stream.pass_time(0.25)
        stream.open()
        messages = stream.sent()
        self.assertEqual(len(stream.headers(messages)), 1)
        self.assertEqual(messages[0].frame.age.nanos, 500_000_000)
        self.assertEqual(messages[0].frame.time_to_live.seconds, 1)
        stream.end(1, stream_pb2.OUTCOME_KIND_EXPIRED)
        self.assertEqual(stream.taken(), [(1, "EXPIRED"), (2, "EXPIRED")])

    def test_the_tick_says_when_it_is_needed_next(self):
        stream = StreamHarness(max_waiting=3)
        stream.open()
        stream.send(timeout=0.7)
        stream.send(time_to_live=0.3)
        self.assertEqual(stream.act().wake_at, stream.now + 0.3)

    def test_a_cancelled_frame_ends_once(self):
        stream = StreamHarness(max_in_flight=1, max_waiting=3)
        stream.open()
        stream.send()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        for sequence in (2, 1, 77):
            stream.scheduler.cancel(sequence, stream.now)
        self.assertEqual([message.cancel.sequence for message in stream.sent()], [1])
        stream.end(1, stream_pb2.OUTCOME_KIND_CANCELLED)
        self.assertEqual(stream.taken(), [(1, "CANCELLED"), (2, "CANCELLED")])
        stream.scheduler.cancel(1, stream.now)
        self.assertEqual(stream.taken(), [])

    def test_a_cancelled_frame_is_not_sent_again(self):
        stream = StreamHarness()
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        stream.scheduler.cancel(1, stream.now)
        stream.close(segserve.Unavailable("gone"))
        self.assertEqual(stream.taken(), [(1, "CANCELLED")])

    def test_the_server_hears_the_deadline_as_a_time_to_live(self):
        stream = StreamHarness(max_waiting=10)
        stream.open()
        stream.send(timeout=0.75)
        stream.send(time_to_live=0.25, timeout=0.75)
        stream.send(time_to_live=0.875, timeout=0.75)
        lives = [message.frame.time_to_live.ToMilliseconds() for message in stream.sent() if message.HasField("frame")]
        self.assertEqual(lives, [750, 250, 750])
        for number in (1, 2, 3):
            stream.end(number, stream_pb2.OUTCOME_KIND_EXPIRED)
        self.assertEqual(stream.taken(), [(1, "FAILED"), (2, "EXPIRED"), (3, "FAILED")])
        self.assertIsInstance(stream.last.error, segserve.DeadlineExceeded)

    def test_a_frame_that_ended_holds_no_payload(self):
        stream = StreamHarness()
        stream.open()
        stream.send()
        stream.sent()
        stream.end(1)
        self.assertEqual(stream.scheduler._frames.find(1).request.payload.size, 0)


class SlowServer(unittest.TestCase):
    """A stream whose window has room for two frames, and whose server has taken 0.5 s for each so far."""

    def setUp(self):
        self.stream = StreamHarness(order=Order.DONE, max_in_flight=2, max_waiting=10)
        self.stream.open()
        for number in range(1, 31):
            self.stream.send()
            self.stream.sent()
            self.stream.pass_time(0.5)
            self.stream.end(number)
            self.stream.taken()

    def test_a_frame_that_would_come_too_late_makes_way_for_the_next(self):
        stream = self.stream
        first = stream.send(timeout=1)
        stream.send(timeout=1)
        late = stream.send(timeout=1)
        self.assertEqual(stream.begun(), 2)
        stream.pass_time(0.6)
        fresh = stream.send(timeout=1)
        stream.end(31)
        self.assertEqual(stream.taken(), [(first, "RESULT")])
        self.assertEqual(stream.begun(), 1)
        self.assertEqual(stream.taken(), [(late, "FAILED")])
        self.assertIsInstance(stream.last.error, segserve.DeadlineExceeded)
        stream.end(33)
        self.assertEqual(stream.taken(), [(fresh, "RESULT")])

    def test_a_late_frame_is_tried_if_no_other_waits(self):
        self.stream.send(timeout=5)
        hurried = self.stream.send(timeout=0.1)
        self.assertEqual(self.stream.begun(), 2)
        self.stream.end(32)
        self.assertEqual(self.stream.taken(), [(hurried, "RESULT")])


class Rules(unittest.TestCase):
    def test_rules_that_make_no_sense_are_all_named(self):
        with self.assertRaisesRegex(ValueError, r"max_in_flight: 0 .*; frame_timeout: 1e-05 .*"):
            StreamHarness(max_in_flight=0, frame_timeout=1e-5)


class Times(unittest.TestCase):
    def test_the_bound_is_above_the_mean_by_the_spread(self):
        self.assertEqual(ServiceTime().bound(), 0)
        steady, changing = ServiceTime(), ServiceTime()
        for i in range(100):
            steady.add(0.1)
            changing.add(0.08 if i % 2 else 0.12)
        self.assertAlmostEqual(steady.bound(), 0.1, places=3)
        self.assertTrue(0.15 < changing.bound() < 0.2)

    def test_a_frame_that_was_given_up_makes_nothing_seem_faster(self):
        times = ServiceTime()
        for _ in range(100):
            times.add(0.1)
        before = times.bound()
        times.add_at_least(0.001)
        self.assertEqual(times.bound(), before)
        times.add_at_least(0.5)
        self.assertGreater(times.bound(), before)


if __name__ == "__main__":
    unittest.main()
