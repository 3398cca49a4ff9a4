# SPDX-License-Identifier: Apache-2.0
"""What a stream decides about its connections. The test is the clock, the transport and the servers."""
import unittest

import segserve
from segserve import Retry, WhenBehind
from segserve._stream.links import ActionKind
from segserve._stream.scheduler import Admission
from stream_harness import DRAINING, OLD, StreamHarness, outcome


class Connections(unittest.TestCase):
    def test_a_broken_connection_moves_its_frames_to_the_next_address(self):
        stream = StreamHarness(max_waiting=3)
        stream.open()
        stream.send()
        stream.send()
        self.assertEqual(stream.begun(), 2)
        stream.close(segserve.Cancelled(""))  # a server that shuts down ends calls so
        stream.open()
        self.assertEqual([action.address for action in stream.actions], [0, 1])
        self.assertEqual(stream.begun(), 2)
        stream.end(2)
        stream.end(1)
        self.assertEqual(len(stream.taken()), 2)
        self.assertEqual((stream.last.report.attempts, stream.last.report.address), (2, "b"))

    def test_with_one_address_it_waits_before_it_tries_again(self):
        stream = StreamHarness(["a"])
        stream.open()
        stream.close(segserve.Unavailable("gone"))
        stream.act()
        self.assertEqual(len(stream.connections), 1)
        stream.pass_time(Retry().first_backoff)
        self.assertEqual(len(stream.connections), 2)

    def test_a_long_outage_ends_the_stream(self):
        stream = StreamHarness(["a"], max_waiting=3, frame_timeout=60, longest_outage=4)
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        stream.close(segserve.Unavailable("gone"))
        for _ in range(3):
            stream.pass_time(1)
        stream.open()  # that was short enough
        self.assertEqual(stream.begun(), 1)
        stream.pass_time(1)
        stream.close(segserve.Unavailable("gone again"))
        stream.act()
        stream.pass_time(3.5)
        self.assertEqual(stream.taken(), [])
        self.assertIs(stream.scheduler.admission(), Admission.OPEN)
        stream.pass_time(0.5)
        self.assertEqual(stream.taken(), [(1, "FAILED")])
        self.assertIsInstance(stream.last.error, segserve.OutageError)
        self.assertEqual(stream.last.error.message, "no server has been in reach for 4 s (gone again)")
        self.assertIsInstance(stream.scheduler.refusal(), segserve.OutageError)
        self.assertTrue(stream.scheduler.exhausted())

    def test_a_server_that_drains_is_no_outage_while_it_computes(self):
        stream = StreamHarness(["a"], frame_timeout=60, longest_outage=4)
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        old = stream.connections[-1]
        stream.answer(DRAINING)
        for _ in range(20):
            stream.pass_time(1)
            if stream.connections[-1] != old:
                stream.close(segserve.Unavailable("not yet"))
            stream.scheduler.on_sign_of_life(old, stream.now)
        stream.answer(outcome(1), old)
        self.assertEqual(stream.taken(), [(1, "RESULT")])
        stream.pass_time(3)
        self.assertIs(stream.scheduler.admission(), Admission.OPEN)

    def test_without_a_limit_an_outage_may_last(self):
        stream = StreamHarness(["a"], frame_timeout=86400)
        stream.send()
        for _ in range(20):
            stream.pass_time(3600)
            stream.close(segserve.Unavailable("gone"))
        self.assertEqual(stream.taken(), [])

    def test_without_waiting_for_a_server_frames_fail_at_once(self):
        stream = StreamHarness(wait_for_server=False)
        stream.send()
        for _ in range(2):
            stream.act()
            self.assertEqual(stream.taken(), [])
            stream.close(segserve.Unavailable("gone"))
        stream.act()
        self.assertEqual(stream.taken(), [(1, "FAILED")])
        self.assertIsInstance(stream.last.error, segserve.Unavailable)

    def test_a_draining_server_keeps_what_it_has_and_gets_nothing_new(self):
        stream = StreamHarness(max_waiting=5)
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        old = stream.connections[-1]
        stream.answer(DRAINING)
        stream.send()
        self.assertEqual(stream.headers(stream.sent(old)), [])
        self.assertTrue(stream.scheduler.wants_half_close(old))
        stream.open()
        self.assertNotEqual(stream.connections[-1], old)
        self.assertEqual(stream.begun(), 1)
        stream.answer(outcome(1), old)
        stream.scheduler.on_closed(old, segserve.Unavailable("drained"), stream.now)
        stream.end(1)
        self.assertEqual(stream.taken(), [(1, "RESULT"), (2, "RESULT")])
        self.assertEqual(stream.last.report.attempts, 1)

    def test_a_frame_after_the_end_of_a_token_goes_to_a_stream_with_the_next_token(self):
        stream = StreamHarness()
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        old = stream.connections[-1]
        stream.answer(DRAINING)
        stream.fail(1, segserve.Unauthenticated("the token is over"))
        stream.scheduler.on_closed(old, segserve.Unauthenticated("the token is over"), stream.now)
        stream.open()
        self.assertNotEqual(stream.connections[-1], old)
        self.assertEqual(stream.begun(), 1)
        stream.end(1)
        self.assertEqual(stream.taken(), [(1, "RESULT")])

    def test_an_old_connection_takes_frames_until_there_is_another(self):
        stream = StreamHarness(max_waiting=5)
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        old = stream.connections[-1]
        stream.answer(OLD)
        stream.act()
        self.assertEqual([action.kind for action in stream.actions], [ActionKind.OPEN, ActionKind.RENEW, ActionKind.OPEN])
        self.assertEqual((stream.actions[1].connection, stream.actions[2].address), (old, 1))
        stream.send()
        self.assertEqual(len(stream.headers(stream.sent(old))), 1, "nothing waits for the new connection")
        self.assertFalse(stream.scheduler.wants_half_close(old))
        stream.open()
        stream.send()
        self.assertEqual(stream.headers(stream.sent(old)), [])
        self.assertTrue(stream.scheduler.wants_half_close(old))
        self.assertEqual(stream.begun(), 1)
        for number in (1, 2):
            stream.answer(outcome(number), old)
        stream.scheduler.on_closed(old, None, stream.now)
        stream.end(1)
        self.assertEqual(stream.taken(), [(1, "RESULT"), (2, "RESULT"), (3, "RESULT")])
        self.assertEqual(stream.last.report.attempts, 1)

    def test_an_old_connection_serves_while_no_other_can_be_made(self):
        stream = StreamHarness(["a"], max_waiting=5, wait_for_server=False)
        stream.open()
        old = stream.connections[-1]
        stream.answer(OLD)
        stream.act()
        self.assertNotEqual(stream.connections[-1], old)
        stream.close(segserve.Unavailable("no more connections"))
        stream.send()
        stream.act()
        self.assertEqual(stream.taken(), [], "the old connection is in reach")
        self.assertEqual(len(stream.headers(stream.sent(old))), 1)
        stream.answer(outcome(1), old)
        self.assertEqual(stream.taken(), [(1, "RESULT")])
        stream.pass_time(1)
        self.assertEqual(len(stream.connections), 3, "it tries again")

    def test_an_old_connection_of_a_server_that_stops_is_left(self):
        stream = StreamHarness(max_waiting=5)
        stream.open()
        old = stream.connections[-1]
        stream.answer(OLD)
        stream.answer(DRAINING)
        stream.send()
        self.assertEqual(stream.headers(stream.sent(old)), [])
        self.assertTrue(stream.scheduler.wants_half_close(old))
        stream.open()
        self.assertEqual(stream.begun(), 1)

    def test_a_rejected_frame_fails_if_that_was_asked_for(self):
        stream = StreamHarness(when_behind=WhenBehind.REJECT)
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        stream.fail(1, segserve.ResourceExhausted("full"))
        self.assertEqual(stream.taken(), [(1, "FAILED")])

    def test_obeys_the_servers_retry_info(self):
        stream = StreamHarness()
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        stream.fail(1, segserve.ResourceExhausted("full", reason="QUEUE_FULL", retry_delay=3))
        stream.pass_time(2.75)
        self.assertEqual(stream.begun(), 0)
        stream.pass_time(0.25)
        self.assertEqual(stream.begun(), 1)

    def test_a_frame_beyond_a_limit_is_not_tried_again(self):
        stream = StreamHarness()
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        stream.fail(1, segserve.ResourceExhausted("large", reason="LIMIT_EXCEEDED"))
        self.assertEqual(stream.taken(), [(1, "FAILED")])
        self.assertEqual(stream.last.error.reason, "LIMIT_EXCEEDED")

    def test_a_frame_that_breaks_every_connection_is_given_up(self):
        stream = StreamHarness(retry=Retry(max_attempts=3))
        stream.send()
        for _ in range(3):
            stream.pass_time(2.5)
            stream.open()
            self.assertEqual(stream.begun(), 1)
            stream.close(segserve.Unavailable("crashed"))
        self.assertEqual(stream.taken(), [(1, "FAILED")])
        self.assertIsInstance(stream.last.error, segserve.Unavailable)

    def test_after_the_deadline_the_servers_answer_counts_no_more(self):
        stream = StreamHarness()
        stream.open()
        stream.send(timeout=0.1)
        self.assertEqual(stream.begun(), 1)
        stream.pass_time(0.1)
        self.assertEqual([message.WhichOneof("kind") for message in stream.sent()], ["cancel"])
        self.assertEqual(stream.taken(), [(1, "FAILED")])
        self.assertIsInstance(stream.last.error, segserve.DeadlineExceeded)
        stream.end(1)
        self.assertEqual(stream.taken(), [])

    def test_a_silent_connection_is_probed_and_then_given_up(self):
        stream = StreamHarness(progress_timeout=1)
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        stream.pass_time(0.5)
        self.assertIs(stream.actions[-1].kind, ActionKind.PROBE)
        stream.scheduler.on_sign_of_life(stream.connections[-1], stream.now)
        stream.pass_time(0.5)
        self.assertIs(stream.actions[-1].kind, ActionKind.PROBE)
        stream.pass_time(0.5)
        self.assertEqual([action.kind for action in stream.actions[3:]], [ActionKind.BREAK_SILENT, ActionKind.OPEN])
        self.assertEqual(stream.actions[-1].address, 1)

    def test_an_idle_connection_owes_nothing(self):
        stream = StreamHarness(progress_timeout=1)
        stream.open()
        stream.pass_time(60)
        self.assertEqual(len(stream.actions), 1)

    def test_a_server_that_breaks_the_protocol_is_left(self):
        stream = StreamHarness()
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        stream.answer(outcome(5))
        stream.act()
        self.assertEqual([action.kind for action in stream.actions],
                         [ActionKind.OPEN, ActionKind.BREAK, ActionKind.OPEN])

    def test_an_error_that_every_server_would_repeat_ends_the_stream(self):
        for error in (segserve.InvalidArgument("options.lambda: 7"), segserve.Unauthenticated("no token")):
            stream = StreamHarness()
            stream.open()
            stream.send()
            self.assertEqual(stream.begun(), 1)
            stream.close(error)
            self.assertEqual(stream.taken(), [(1, "FAILED")])
            self.assertIs(stream.scheduler.admission(), Admission.REFUSED)
            self.assertIs(stream.scheduler.refusal(), error)
            self.assertTrue(stream.scheduler.exhausted())
            stream.act()
            self.assertEqual(len(stream.connections), 1)

    def test_the_last_outcome_half_closes_and_nothing_is_reopened(self):
        stream = StreamHarness()
        stream.open()
        stream.send()
        self.assertEqual(stream.begun(), 1)
        stream.scheduler.finish_sending()
        stream.act()
        self.assertFalse(stream.scheduler.wants_half_close(stream.connections[-1]))
        stream.end(1)
        stream.act()
        self.assertTrue(stream.scheduler.wants_half_close(stream.connections[-1]))
        self.assertFalse(stream.scheduler.exhausted())
        self.assertEqual(len(stream.taken()), 1)
        self.assertTrue(stream.scheduler.exhausted())
        stream.close()
        stream.pass_time(10)
        self.assertEqual(len(stream.connections), 1)

    def test_closing_cancels_what_is_unfinished_and_breaks_the_connection(self):
        stream = StreamHarness()
        stream.open()
        stream.send()
        stream.sent()
        stream.scheduler.close(stream.now)
        self.assertEqual(stream.taken(), [(1, "CANCELLED")])
        stream.act()
        self.assertIs(stream.actions[-1].kind, ActionKind.BREAK)


if __name__ == "__main__":
    unittest.main()
