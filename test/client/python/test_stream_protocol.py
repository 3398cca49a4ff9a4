# SPDX-License-Identifier: Apache-2.0
"""One connection: which messages the client sends, and which messages of a server break the protocol."""
import copy
import unittest
import zlib

import segserve
from segserve._stream.protocol import EventKind, Fit, StreamProtocol
from segserve.v1 import stream_pb2
from stream_harness import DRAINING, opened, outcome, payload_of


def result(number, size):
    """An outcome whose labels have so many bytes L."""
    response = outcome(number)
    response.outcome.result.labels.data.encoded_bytes = size
    response.outcome.encoded_bytes, response.outcome.crc32 = size, zlib.crc32(b"L" * size if size < 1 << 20 else b"")
    return response


def chunk(number, size):
    return stream_pb2.SegmentStreamResponse(chunk=stream_pb2.ResultChunk(sequence=number, data=b"L" * size))


class Protocol(unittest.TestCase):
    def setUp(self):
        self.payload = payload_of()  # x, y, z and colors: 400 + 400 + 400 + 300 bytes
        self.protocol = StreamProtocol(stream_pb2.StreamOpen())
        self.assertEqual(self.protocol.next().kind, "open")
        self.protocol.receive(opened(2, 10_000, 150))

    def begin(self, sequence):
        self.protocol.begin(sequence, stream_pb2.FrameHeader(), self.payload)

    def sent(self):
        return [stream_pb2.SegmentStreamRequest.FromString(message.data) for message in iter(self.protocol.next, None)]

    def assert_refused(self, response):
        with self.assertRaises(segserve.Internal):
            self.protocol.receive(response)

    def test_cuts_a_payload_into_chunks_that_fit_its_checksum(self):
        self.begin(7)
        header, *chunks = self.sent()
        self.assertEqual(header.frame.sequence, 1, "the number on the wire, not the sequence")
        self.assertGreater(len(chunks), 9)
        self.assertTrue(all(0 < len(message.chunk.data) <= 150 and message.chunk.sequence == 1 for message in chunks))
        data = b"".join(message.chunk.data for message in chunks)
        self.assertEqual((len(data), zlib.crc32(data)), (header.frame.encoded_bytes, header.frame.crc32))
        self.assertEqual(data, b"".join(bytes(block) for block in self.payload.blocks))

    def test_chunks_are_written_as_protobuf_writes_them(self):
        for _ in range(200):  # so that the number takes two bytes
            self.protocol._last_number += 1
        self.begin(1)
        self.protocol.next()
        for message in iter(self.protocol.next, None):
            self.assertEqual(message.data, stream_pb2.SegmentStreamRequest.FromString(message.data).SerializeToString())

    def test_one_upload_after_the_other(self):
        self.assertTrue(self.protocol.has_turn())
        self.begin(1)
        self.assertFalse(self.protocol.has_turn())
        self.sent()
        self.assertTrue(self.protocol.has_turn())
        self.begin(2)
        self.sent()
        self.assertFalse(self.protocol.has_turn(), "the credit is for two frames")

    def test_credit_in_bytes_is_back_after_the_last_byte_of_the_answer(self):
        self.assertIs(self.protocol.fit(10_001), Fit.NEVER)
        self.begin(1)
        self.assertIs(self.protocol.fit(9000), Fit.LATER)
        self.sent()
        self.assertIs(self.protocol.receive(result(1, 20)).kind, EventKind.BEGUN)
        self.assertIs(self.protocol.fit(9000), Fit.LATER)
        event = self.protocol.receive(chunk(1, 20))
        self.assertIs(event.kind, EventKind.OUTCOME)
        self.assertTrue(event.is_intact)
        self.assertEqual(event.outcome.result.labels.data.data, b"L" * 20)
        self.assertIs(self.protocol.fit(9000), Fit.NOW)

    def test_a_damaged_answer_is_noticed(self):
        self.begin(1)
        self.sent()
        response = result(1, 20)
        response.outcome.crc32 ^= 1
        self.protocol.receive(response)
        self.assertFalse(self.protocol.receive(chunk(1, 20)).is_intact)

    def test_no_chunks_follow_a_cancel_or_an_outcome(self):
        self.begin(1)
        self.protocol.next(), self.protocol.next()
        self.protocol.cancel(1)
        self.assertEqual([message.WhichOneof("kind") for message in self.sent()], ["cancel"])
        self.begin(2)
        self.protocol.next(), self.protocol.next()
        self.protocol.receive(outcome(2, stream_pb2.OUTCOME_KIND_FAILED))
        self.assertEqual(self.sent(), [])

    def test_ends_when_the_upload_is_through(self):
        self.begin(1)
        self.protocol.end()
        self.assertFalse(self.protocol.has_turn())
        self.assertFalse(self.protocol.wants_half_close())
        self.sent()
        self.assertTrue(self.protocol.wants_half_close())

    def test_a_server_must_keep_to_the_protocol(self):
        self.begin(1)
        self.sent()
        self.assert_refused(outcome(2))  # there is no such frame
        self.assert_refused(chunk(1, 1))  # there is no result
        self.assert_refused(opened())  # twice
        lying = result(1, 20)
        lying.outcome.encoded_bytes = 21
        self.assert_refused(lying)
        self.assert_refused(result(1, 2**64 - 1))
        most = 100 * 28 + (64 << 10)  # for 100 points
        self.assert_refused(result(1, most + 1))
        self.assertIs(copy.copy(self.protocol).receive(result(1, most)).kind, EventKind.BEGUN)
        self.protocol.receive(result(1, 20))
        self.assert_refused(chunk(1, 21))  # it is too long
        self.assert_refused(chunk(2, 5))  # it belongs to another frame
        self.assert_refused(result(1, 20))  # it interrupts a result

    def test_nothing_comes_before_opened(self):
        self.protocol = StreamProtocol(stream_pb2.StreamOpen())
        self.assert_refused(DRAINING)
        self.assert_refused(stream_pb2.SegmentStreamResponse(opened=stream_pb2.StreamOpened()))  # it grants no credit


if __name__ == "__main__":
    unittest.main()
