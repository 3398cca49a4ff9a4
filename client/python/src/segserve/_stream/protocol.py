# SPDX-License-Identifier: Apache-2.0
"""The client's side of the protocol in stream.proto, on one connection."""
from __future__ import annotations

import enum
import zlib
from collections import deque
from typing import NamedTuple

from segserve.errors import Internal
from segserve.payload import Bytes, Payload
from segserve.v1 import block_pb2, result_pb2, stream_pb2

_MOST_CHUNK_BYTES = 256 << 10
_CHUNK_TAG = stream_pb2.SegmentStreamRequest.CHUNK_FIELD_NUMBER << 3 | 2
_SEQUENCE_TAG = stream_pb2.FrameChunk.SEQUENCE_FIELD_NUMBER << 3
_DATA_TAG = stream_pb2.FrameChunk.DATA_FIELD_NUMBER << 3 | 2


class Fit(enum.Enum):
    NOW = enum.auto()
    LATER = enum.auto()
    NEVER = enum.auto()


class Outgoing(NamedTuple):
    """A message to be sent, serialized."""

    data: bytes
    kind: str  # "open", "frame", "chunk" or "cancel"
    sequence: int | None = None  # of the frame that it is a part of
    completes_payload: bool = False


class EventKind(enum.Enum):
    NOTHING = enum.auto()
    OPENED = enum.auto()
    DRAINING = enum.auto()
    OLD = enum.auto()  # the server asks for another stream
    BEGUN = enum.auto()  # the first bytes of an outcome came
    OUTCOME = enum.auto()


class Event(NamedTuple):
    """The meaning of a message from the server."""

    kind: EventKind
    sequence: int = 0  # BEGUN, OUTCOME
    outcome: stream_pb2.FrameOutcome | None = None  # OUTCOME: complete, with the bytes of the result in its blocks
    is_intact: bool = True  # OUTCOME: False if the checksum differs from the one that was announced


class _SentFrame(NamedTuple):
    sequence: int
    size: int
    points: int  # 0: not known


def _varint(value: int) -> bytes:
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def chunk_message(number: int, data: Bytes) -> bytes:
    """A serialized SegmentStreamRequest with a FrameChunk. Protobuf itself would copy the data three times."""
    head = _varint(_SEQUENCE_TAG) + _varint(number) + _varint(_DATA_TAG) + _varint(len(data))
    return b"".join((_varint(_CHUNK_TAG), _varint(len(head) + len(data)), head, data))


class _OutgoingBytes:
    """The bytes of a payload that are still to be sent."""

    def __init__(self, blocks: tuple[Bytes, ...]) -> None:
        self._blocks = deque(memoryview(block) for block in blocks if len(block) > 0)

    def is_done(self) -> bool:
        return not self._blocks

    def take(self, most: int) -> memoryview:
        block = self._blocks.popleft()
        if len(block) > most:
            self._blocks.appendleft(block[most:])
        return block[:most]


def result_blocks(message: result_pb2.SegmentationResult) -> list[block_pb2.Block]:
    """The blocks of a result, in the order in which their bytes come."""
    blocks = [getattr(message, name).data for name in ("labels", "supervoxels") if message.HasField(name)]
    if message.HasField("tree"):
        tree = message.tree
        blocks += [tree.leaf_points.data, tree.left.data, tree.right.data, tree.weight]
    if message.HasField("selected"):
        blocks.append(message.selected.data)
    return blocks


def _most_result_bytes(points: int) -> int:
    """The most bytes that the result for a cloud can have; 100 million points are allowed if their number is not known.

    Each point has two labels of 4 bytes and may be a leaf of 20 bytes; zstd and the columns need some slack.
    """
    return (64 << 10) + 28 * (points or 100_000_000)


class StreamProtocol:
    """Numbers the frames, keeps to the credit, cuts payloads into chunks and joins the chunks of results.

    Knows neither transport nor clock. Callers name frames by the stream's sequence. On the wire frames have numbers of
    their own, because a frame may be sent twice on one connection.
    """

    def __init__(self, open_message: stream_pb2.StreamOpen) -> None:
        self._open: stream_pb2.StreamOpen | None = open_message
        self.opened = False  # the server has granted credit
        self._draining = False
        self._ended = False
        self._credit_frames = 0
        self.credit_bytes = 0  # that the server has granted
        self._chunk_bytes = 0
        self._bytes_used = 0  # of the credit
        self._last_number = 0
        self._sent: dict[int, _SentFrame] = {}  # by number on the wire
        self._cancels: deque[int] = deque()  # numbers on the wire
        self._upload = 0  # the number of the frame whose payload is being sent; 0: none
        self._header: stream_pb2.FrameHeader | None = None
        self._payload = _OutgoingBytes(())
        self._outcome: stream_pb2.FrameOutcome | None = None  # whose bytes are arriving
        self._arrived: list[bytes] = []
        self._missing = 0

    @property
    def ending(self) -> bool:
        """No new frame may begin: the server is about to stop, or end() was called."""
        return self._draining or self._ended

    @property
    def in_flight(self) -> int:
        """How many frames have no outcome."""
        return len(self._sent)

    def has_turn(self) -> bool:
        """Whether a frame may begin now, as far as the upload before it and the credit in frames are concerned."""
        return self.opened and not self.ending and self._upload == 0 and len(self._sent) < self._credit_frames

    def fit(self, size: int) -> Fit:
        """Whether the credit in bytes has room for so many bytes now, or ever."""
        if size > self.credit_bytes:
            return Fit.NEVER
        return Fit.NOW if self._bytes_used + size <= self.credit_bytes else Fit.LATER

    def begin(self, sequence: int, header: stream_pb2.FrameHeader, payload: Payload) -> None:
        """Begins the next frame. has_turn() must be true, and the payload must fit."""
        self._last_number += 1
        self._upload = self._last_number
        header.sequence = self._upload
        header.cloud.CopyFrom(payload.header)
        header.encoded_bytes, header.points, header.decoded_bytes = payload.size, payload.points, payload.decoded_bytes
        header.crc32 = payload.crc32
        self._header = header
        self._bytes_used += payload.size
        self._sent[self._upload] = _SentFrame(sequence, payload.size, payload.points)
        self._payload = _OutgoingBytes(payload.blocks)

    def cancel(self, sequence: int) -> None:
        """Asks the server to drop the frame; its outcome comes all the same. Unknown frames are left alone."""
        self._cancels.extend(number for number, frame in self._sent.items() if frame.sequence == sequence)

    def end(self) -> None:
        """No more frames will begin."""
        self._ended = True

    def next(self) -> Outgoing | None:
        """The message to be sent next; None if there is none now."""
        if self._open is not None:
            message = stream_pb2.SegmentStreamRequest(open=self._open)
            self._open = None
            return Outgoing(message.SerializeToString(), "open")
        if self._header is not None:  # first, so that no cancel comes before the header of its frame
            return self._next_header(self._header)
        if self._cancels:
            return self._next_cancel()
        if self._upload:
            return self._next_chunk()
        return None

    def _next_header(self, header: stream_pb2.FrameHeader) -> Outgoing:
        self._header = None
        sequence, is_done = self._sent[self._upload].sequence, self._payload.is_done()
        if is_done:
            self._upload = 0
        return Outgoing(stream_pb2.SegmentStreamRequest(frame=header).SerializeToString(), "frame", sequence, is_done)

    def _next_cancel(self) -> Outgoing:
        number = self._cancels.popleft()
        if self._upload == number:
            self._upload = 0  # no chunks of the frame may follow
        message = stream_pb2.SegmentStreamRequest(cancel=stream_pb2.FrameCancel(sequence=number))
        return Outgoing(message.SerializeToString(), "cancel")

    def _next_chunk(self) -> Outgoing:
        number = self._upload
        data = chunk_message(number, self._payload.take(self._chunk_bytes))
        is_done = self._payload.is_done()
        if is_done:
            self._upload = 0
        return Outgoing(data, "chunk", self._sent[number].sequence, is_done)

    def wants_half_close(self) -> bool:
        """True after end(), once nothing will be sent any more."""
        return self.ending and self._open is None and self._upload == 0 and not self._cancels

    def receive(self, message: stream_pb2.SegmentStreamResponse) -> Event:
        """Takes a message from the server. Internal if the server broke the protocol; the connection is of no use
        then."""
        kind = message.WhichOneof("kind")
        if not self.opened and kind != "opened":
            raise _broken("its first message was not StreamOpened")
        if self._outcome is not None and kind != "chunk":
            raise _broken("another message interrupted the bytes of a result")
        if kind == "opened":
            return self._receive_opened(message.opened)
        if kind == "outcome":
            return self._receive_outcome(message.outcome)
        if kind == "chunk":
            return self._receive_chunk(message.chunk)
        if kind == "draining":
            if message.draining.reason == stream_pb2.DRAIN_REASON_STREAM_AGE:
                return Event(EventKind.OLD)
            self._draining = True
            return Event(EventKind.DRAINING)
        return Event(EventKind.NOTHING)  # a message that a newer version knows

    def _receive_opened(self, opened: stream_pb2.StreamOpened) -> Event:
        if self.opened:
            raise _broken("it opened the stream twice")
        if not (opened.credit.frames and opened.credit.bytes and opened.max_chunk_bytes):
            raise _broken("it granted no credit")
        self.opened = True
        self._credit_frames, self.credit_bytes = opened.credit.frames, opened.credit.bytes
        self._chunk_bytes = min(opened.max_chunk_bytes, _MOST_CHUNK_BYTES)
        return Event(EventKind.OPENED)

    def _receive_outcome(self, outcome: stream_pb2.FrameOutcome) -> Event:
        frame = self._sent.get(outcome.sequence)
        if frame is None:
            raise _broken(f"it ended frame {outcome.sequence}, which it does not have")
        if self._upload == outcome.sequence:
            self._upload = 0  # the server does not want the rest of the payload
        if outcome.encoded_bytes > (most := _most_result_bytes(frame.points)):
            raise _broken(f"it announced a result of {outcome.encoded_bytes} bytes; {most} are allowed")
        promised = sum(block.encoded_bytes for block in result_blocks(outcome.result))
        if promised != outcome.encoded_bytes:
            raise _broken(f"it announced a result of {outcome.encoded_bytes} bytes whose blocks have {promised}")
        self._outcome, self._missing = outcome, promised
        if promised == 0:
            return self._complete_outcome(outcome)
        return Event(EventKind.BEGUN, frame.sequence)

    def _receive_chunk(self, chunk: stream_pb2.ResultChunk) -> Event:
        outcome = self._outcome
        if outcome is None or chunk.sequence != outcome.sequence:
            raise _broken("it sent a chunk that belongs to no result")
        if not 0 < len(chunk.data) <= self._missing:
            raise _broken(f"it sent a chunk of {len(chunk.data)} bytes where {self._missing} were missing")
        self._arrived.append(chunk.data)
        self._missing -= len(chunk.data)
        return Event(EventKind.NOTHING) if self._missing else self._complete_outcome(outcome)

    def _complete_outcome(self, outcome: stream_pb2.FrameOutcome) -> Event:
        data = b"".join(self._arrived)
        self._outcome, self._arrived = None, []
        begin = 0
        for block in result_blocks(outcome.result):
            block.data = data[begin:begin + block.encoded_bytes]
            begin += block.encoded_bytes
        frame = self._sent.pop(outcome.sequence)
        self._bytes_used -= frame.size
        self._cancels = deque(number for number in self._cancels if number != outcome.sequence)
        return Event(EventKind.OUTCOME, frame.sequence, outcome, not data or zlib.crc32(data) == outcome.crc32)


def _broken(message: str) -> Internal:
    return Internal("the server broke the protocol of the stream: " + message)
