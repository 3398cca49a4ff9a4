# SPDX-License-Identifier: Apache-2.0
"""A StreamScheduler whose application, clock, transport and servers are the test."""
import numpy as np

import segserve
from segserve._stream.frame import FrameRequest, StreamOptions
from segserve._stream.links import ActionKind
from segserve._stream.scheduler import StreamScheduler
from segserve.rpc import error_details_pb2
from segserve.v1 import stream_pb2


def payload_of(width=10, height=10):
    """A flat cloud with colors: 15 bytes a point, in the blocks x, y, z and rgb."""
    y, x = np.mgrid[:height, :width].astype(np.float32)
    xyz = np.stack([x, y, np.ones_like(x)], axis=-1)
    return segserve.encode(xyz, np.zeros((height, width, 3), np.uint8), view="camera", codec="planar")


def opened(frames=4, size=1_000_000, chunk=256 << 10):
    return stream_pb2.SegmentStreamResponse(opened=stream_pb2.StreamOpened(
        credit=stream_pb2.Credit(frames=frames, bytes=size), max_chunk_bytes=chunk))


def outcome(number, kind=stream_pb2.OUTCOME_KIND_RESULT):
    return stream_pb2.SegmentStreamResponse(outcome=stream_pb2.FrameOutcome(sequence=number, kind=kind))


OLD = stream_pb2.SegmentStreamResponse(draining=stream_pb2.StreamDraining(reason=stream_pb2.DRAIN_REASON_STREAM_AGE))
DRAINING = stream_pb2.SegmentStreamResponse(draining=stream_pb2.StreamDraining())


class StreamHarness:
    """Functions without a connection talk about the newest one."""

    def __init__(self, addresses=("a", "b"), **rules):
        self.options = StreamOptions(**rules)
        self.scheduler = StreamScheduler(self.options, list(addresses), 0, seed=1)
        self.now = 3600.0
        self.actions = []  # all so far
        self.connections = []  # all so far
        self.last = None  # the outcome that was taken last
        self._payload = payload_of()

    def send(self, *, timeout=None, captured=None, **frame):
        """Hands a frame of 100 points over: 1500 bytes. Returns its sequence."""
        return self.scheduler.accept(
            FrameRequest(self._payload,
                         self.options.options,
                         self.options.outputs,
                         captured=self.now if captured is None else captured,
                         timeout=self.options.frame_timeout if timeout is None else timeout,
                         **frame), self.now)

    def act(self):
        """Ticks, and notes what the scheduler asks of the transport."""
        tick = self.scheduler.tick(self.now)
        self.actions += tick.actions
        self.connections += [action.connection for action in tick.actions if action.kind is ActionKind.OPEN]
        return tick

    def pass_time(self, seconds):
        self.now += seconds
        self.act()

    def sent(self, connection=None):
        """All messages that a connection sends now."""
        connection = connection or self.connections[-1]
        messages = iter(lambda: self.scheduler.next_message(connection, self.now), None)
        return [stream_pb2.SegmentStreamRequest.FromString(message.data) for message in messages]

    @staticmethod
    def headers(messages):
        """The numbers on the wire of the frames that begin in these messages."""
        return [message.frame.sequence for message in messages if message.HasField("frame")]

    def begun(self):
        """How many frames begin now."""
        return len(self.headers(self.sent()))

    def answer(self, response, connection=None):
        self.scheduler.on_message(connection or self.connections[-1], response, self.now)

    def open(self, frames=4, size=1_000_000):
        """Makes a connection on which the server grants this credit."""
        self.act()
        self.sent()
        self.answer(opened(frames, size))

    def end(self, number, kind=stream_pb2.OUTCOME_KIND_RESULT):
        """The server ends the frame that has this number on the wire."""
        self.answer(outcome(number, kind))

    def fail(self, number, error):
        response = outcome(number, stream_pb2.OUTCOME_KIND_FAILED)
        status = response.outcome.status
        status.code, status.message = error.code.value[0], error.message
        info = status.details.add(type_url="type.googleapis.com/google.rpc.ErrorInfo")
        info.value = error_details_pb2.ErrorInfo(reason=error.reason, domain="segserve").SerializeToString()
        if error.retry_delay is not None:
            retry = error_details_pb2.RetryInfo()
            retry.retry_delay.FromMilliseconds(round(error.retry_delay * 1000))
            status.details.add(type_url="type.googleapis.com/google.rpc.RetryInfo", value=retry.SerializeToString())
        self.answer(response)

    def close(self, error=None):
        """The connection ends."""
        self.scheduler.on_closed(self.connections[-1], error, self.now)

    def taken(self):
        """Takes all outcomes that there are: sequence and kind of each."""
        ends = []
        for undecoded in iter(self.scheduler.take_outcome, None):
            self.last = undecoded.outcome
            ends.append((self.last.sequence, self.last.kind.value))
        return ends
