# SPDX-License-Identifier: Apache-2.0
"""Messages of the stream that are made of the caller's wishes."""
from __future__ import annotations

import datetime
import math

from google.protobuf import duration_pb2, timestamp_pb2

from segserve import errors
from segserve.options import outputs_message
from segserve.v1 import stream_pb2
from segserve._stream.frame import FrameRequest, OutcomeKind, StreamOptions, WhenBehind

_WHEN_BEHIND = {
    WhenBehind.BLOCK: stream_pb2.WHEN_BEHIND_BLOCK,
    WhenBehind.DROP_OLDEST: stream_pb2.WHEN_BEHIND_DROP_OLDEST,
    WhenBehind.REJECT: stream_pb2.WHEN_BEHIND_REJECT
}
_KINDS: dict[int, OutcomeKind] = {
    stream_pb2.OUTCOME_KIND_RESULT: OutcomeKind.RESULT,
    stream_pb2.OUTCOME_KIND_DROPPED: OutcomeKind.DROPPED,
    stream_pb2.OUTCOME_KIND_EXPIRED: OutcomeKind.EXPIRED,
    stream_pb2.OUTCOME_KIND_CANCELLED: OutcomeKind.CANCELLED
}


def duration(seconds: float) -> duration_pb2.Duration:
    fraction, whole = math.modf(max(seconds, 0.0))
    return duration_pb2.Duration(seconds=int(whole), nanos=int(fraction * 1e9))


def timestamp(time: datetime.datetime) -> timestamp_pb2.Timestamp:
    """A time without a zone is that of this machine."""
    message = timestamp_pb2.Timestamp()
    message.FromDatetime(time.astimezone(datetime.timezone.utc).replace(tzinfo=None))
    return message


def open_message(options: StreamOptions) -> stream_pb2.StreamOpen:
    # Frames may be sent twice, so that only this side can keep the order in which they were handed over.
    message = stream_pb2.StreamOpen(client_name=options.client_name,
                                    options=options.options,
                                    outputs=outputs_message(options.outputs, False),
                                    order=stream_pb2.RESULT_ORDER_UNORDERED,
                                    when_behind=_WHEN_BEHIND[options.when_behind])
    message.wanted.frames, message.wanted.bytes = options.max_in_flight, options.wanted_bytes
    return message


def header_message(request: FrameRequest, stream: StreamOptions, useful_until: float,
                   now: float) -> stream_pb2.FrameHeader:
    header = stream_pb2.FrameHeader(request_id=request.request_id, frame_id=request.frame_id, priority=request.priority)
    if request.stamp is not None:
        header.stamp.CopyFrom(timestamp(request.stamp))
    if request.options != stream.options:
        header.options.CopyFrom(request.options)
    # Whether an answer may be compressed depends on the frame.
    header.outputs.CopyFrom(outputs_message(request.outputs, request.payload.compressed))
    if request.prompts is not None:
        header.prompts.CopyFrom(request.prompts.message())
    if request.tracking is not None:
        header.tracking.CopyFrom(request.tracking)
    header.time_to_live.CopyFrom(duration(useful_until - request.captured))
    header.age.CopyFrom(duration(now - request.captured))
    return header


def outcome_kind(number: int) -> OutcomeKind:
    return _KINDS.get(number, OutcomeKind.FAILED)


def error_of(kind: OutcomeKind) -> errors.Error | None:
    """Why a frame has no result; None for RESULT and FAILED."""
    if kind is OutcomeKind.DROPPED:
        return errors.ResourceExhausted("a newer frame came")
    if kind is OutcomeKind.EXPIRED:
        return errors.DeadlineExceeded("the frame's time to live was over, or too little of it was left")
    if kind is OutcomeKind.CANCELLED:
        return errors.Cancelled("the frame was cancelled")
    return None
