# SPDX-License-Identifier: Apache-2.0
"""The frames that go into a stream, the outcomes that come out of it, and the rules between."""
from __future__ import annotations

import datetime
import enum
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from segserve.errors import Error
from segserve.options import DEFAULT_OUTPUTS
from segserve.payload import Payload
from segserve.result import Result
from segserve.selection import Prompts
from segserve.tracking import Tracking
from segserve.v1 import options_pb2, result_pb2, tracking_pb2
from segserve._stream.address_book import Retry

_DAY = 86400.0
_MOST_FRAMES = 1024


class WhenBehind(enum.Enum):
    """Says what happens to frames that come faster than they are segmented."""

    BLOCK = "block"  # send() waits; nothing is lost but by a frame's own deadline
    DROP_OLDEST = "drop_oldest"  # the oldest frame that waits ends as DROPPED: for robots that want the newest scene
    REJECT = "reject"  # send() raises ResourceExhausted


class Order(enum.Enum):
    """The order in which outcomes come."""

    SENT = "sent"  # that of send()
    DONE = "done"  # as soon as each is known


class OutcomeKind(enum.Enum):
    """How a frame ended."""

    RESULT = "RESULT"  # it was segmented
    DROPPED = "DROPPED"  # it made way for a newer frame
    EXPIRED = "EXPIRED"  # its time to live was over, or too little of it was left to compute the frame
    CANCELLED = "CANCELLED"  # by cancel(), or because the stream was closed
    FAILED = "FAILED"  # because of an error


@dataclass(frozen=True)
class StreamOptions:
    """The rules of a stream. ValueError, with all faults, if one of them makes no sense. Times are seconds."""

    #: For the server's logs, at most 256 bytes.
    client_name: str = ""
    #: Of frames that have none of their own.
    options: options_pb2.SegmentOptions = field(default_factory=options_pb2.SegmentOptions)
    outputs: Collection[str] = DEFAULT_OUTPUTS
    #: If it is given, objects keep their ids from frame to frame. A single frame is on its way at a time then, in the
    #: order of send(), because each needs the state that the one before leaves. A frame that ends without a result leaves
    #: the state as it was.
    tracking: Tracking | None = None
    order: Order = Order.SENT
    when_behind: WhenBehind = WhenBehind.BLOCK
    #: How many frames may be sent, or have a result that was not taken; 1 to 1024. The server may allow fewer.
    max_in_flight: int = 4
    #: How many frames may wait in this process until they may be sent; 1 to 1024.
    max_waiting: int = 1
    #: How many bytes of payload in flight the server is asked for; 0: as it thinks fit.
    wanted_bytes: int = 0
    #: A frame without an outcome fails after this time with DeadlineExceeded; 0.001 to a day. It fails earlier if
    #: others wait and too little time is left for its answer.
    frame_timeout: float = 30.0
    #: A connection without a sign of life for this time is given up; 0.002 to a day.
    progress_timeout: float = 5.0
    retry: Retry = field(default_factory=Retry)
    #: When no address is in reach: True, frames wait until one is or their time is over; False, they fail with
    #: Unavailable.
    wait_for_server: bool = True
    #: When no address has been in reach for this time, all unfinished frames fail with OutageError; 0: never.
    longest_outage: float = 0.0

    def __post_init__(self) -> None:
        ranges: Sequence[tuple[str, float, float]] = (
            ("max_in_flight", 1, _MOST_FRAMES), ("max_waiting", 1, _MOST_FRAMES), ("wanted_bytes", 0, 2**63),
            ("frame_timeout", 0.001, _DAY), ("progress_timeout", 0.002, _DAY), ("longest_outage", 0, _DAY))
        faults = [f"{name}: {getattr(self, name)} is not in [{low:g}, {high:g}]"
                  for name, low, high in ranges if not low <= getattr(self, name) <= high]
        if faults:
            raise ValueError("; ".join(faults))


@dataclass(frozen=True)
class FrameRequest:
    """A frame as it was handed over, with nothing left open. Times are those of time.monotonic()."""

    payload: Payload
    options: options_pb2.SegmentOptions
    outputs: Collection[str]
    captured: float
    timeout: float
    request_id: str = ""
    frame_id: str = ""
    stamp: datetime.datetime | None = None
    time_to_live: float | None = None
    priority: int = 0
    prompts: Prompts | None = None
    tracking: tracking_pb2.TrackRequest | None = None  # its state is set when the frame is sent

    @property
    def expires(self) -> float | None:
        return None if self.time_to_live is None else self.captured + self.time_to_live


@dataclass
class FrameReport:
    """The times and costs of a frame. Times are those of time.monotonic(), seconds; None if they did not come."""

    handed_over: float = 0.0
    header_sent: float | None = None  # in the last attempt
    payload_sent: float | None = None  # in the last attempt, its last byte was handed to gRPC
    outcome_begun: float | None = None  # the first byte of the answer came
    outcome_done: float | None = None  # the last byte of the answer came, or the frame ended without one
    attempts: int = 0  # how often the frame was sent; 1 if all went well
    bytes_sent: int = 0  # by all messages about the frame in the last attempt
    bytes_received: int = 0
    address: str = ""  # of the server that answered; empty: none did


@dataclass
class Outcome:
    """The end of a frame."""

    sequence: int  # that send() returned
    request_id: str = ""
    frame_id: str = ""
    stamp: datetime.datetime | None = None
    kind: OutcomeKind = OutcomeKind.FAILED
    result: Result | None = None  # set for RESULT
    error: Error | None = None  # set for all others: why there is no result
    report: FrameReport = field(default_factory=FrameReport)

    def get(self) -> Result:
        """The result; raises the error if there is none."""
        if self.result is None:
            assert self.error is not None
            raise self.error
        return self.result


@dataclass
class UndecodedOutcome:
    """An outcome whose result is still a message: decoding takes long, and is done by whoever takes the outcome."""

    outcome: Outcome
    shape: tuple[int, ...] | None = None
    outputs: Collection[str] = ()
    wants_tracks: bool = False
    message: result_pb2.SegmentationResult | None = None
