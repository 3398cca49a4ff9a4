# SPDX-License-Identifier: Apache-2.0
"""The frames of a stream whose outcome was not taken."""
from __future__ import annotations

import dataclasses
import enum
from collections import deque
from dataclasses import dataclass, field

from segserve._stream.frame import (FrameReport, FrameRequest, Order, Outcome, OutcomeKind, StreamOptions,
                                    UndecodedOutcome)
from segserve._stream.messages import error_of
from segserve.errors import DeadlineExceeded, Error, ResourceExhausted
from segserve.payload import Payload
from segserve.v1 import cloud_pb2

_NO_PAYLOAD = Payload(cloud_pb2.Cloud(), (), None)


class State(enum.Enum):
    WAITING = enum.auto()  # to be sent, or to be sent again
    SENT = enum.auto()  # on `connection`, in part or as a whole
    DONE = enum.auto()  # has its outcome, which nobody has taken yet


@dataclass
class QueuedFrame:
    """A frame from hand-over to outcome."""

    sequence: int
    request: FrameRequest
    deadline: float  # of its outcome
    undecoded: UndecodedOutcome
    state: State = State.WAITING
    ready_at: float = field(default=float("-inf"))  # WAITING: not to be sent before
    sent_at: float = 0.0  # SENT: when that began
    connection: int = 0  # SENT
    cancelled: bool = False  # by the application, while it was SENT
    last_error: Error | None = None  # why it is sent again

    @property
    def report(self) -> FrameReport:
        return self.undecoded.outcome.report

    def can_expire(self) -> bool:
        """Whether its use ends no later than its deadline."""
        return self.request.expires is not None and self.request.expires <= self.deadline

    def useful_until(self) -> float:
        """From then on its result is of no use."""
        expires = self.request.expires
        return self.deadline if expires is None else min(expires, self.deadline)

    def is_in_flight(self) -> bool:
        """Whether it takes a place in the window. Results that nobody has taken do, which bounds the memory in use."""
        return self.state is State.SENT or (self.state is State.DONE and
                                            self.undecoded.outcome.kind is OutcomeKind.RESULT)

    def too_late(self, connection_error: Error | None) -> Error:
        cause = self.last_error or connection_error
        waits = self.state is State.WAITING
        message = "the frame waited until it was too late to send it" if waits else "no answer came in time"
        return DeadlineExceeded(message + (f"; the last error was: {cause.message}" if cause else ""))


class FrameQueue:
    """Which frames may enter, which goes next, how each ends, and in which order the outcomes come.

    Knows neither connections nor transport; time is handed in.
    """

    def __init__(self, options: StreamOptions) -> None:
        self._options = options
        self._frames: dict[int, QueuedFrame] = {}  # by sequence, ascending
        self._done: deque[int] = deque()  # in the order in which they ended
        self._last_sequence = 0
        self.ended = 0  # how many frames have got an outcome so far
        self.track_state = b"" if options.tracking is None else options.tracking.state  # that the last result left

    def __len__(self) -> int:
        return len(self._frames)

    def waiting(self) -> int:
        """How many frames are to be sent."""
        return sum(frame.state is State.WAITING for frame in self._frames.values())

    def unfinished(self) -> list[QueuedFrame]:
        """The frames without an outcome."""
        return [frame for frame in self._frames.values() if frame.state is not State.DONE]

    def sent(self) -> list[QueuedFrame]:
        """The frames that were sent and have no outcome."""
        return [frame for frame in self._frames.values() if frame.state is State.SENT]

    def accept(self, request: FrameRequest, now: float) -> int:
        """Takes a frame and returns its sequence: 1, 2, 3 and so on. If too many wait, the oldest of them is
        dropped."""
        if self.waiting() >= self._options.max_waiting:
            oldest = next(frame for frame in self._frames.values() if frame.state is State.WAITING)
            self.end(oldest, OutcomeKind.DROPPED, error_of(OutcomeKind.DROPPED), now)
        self._last_sequence += 1
        outcome = Outcome(self._last_sequence, request.request_id, request.frame_id, request.stamp)
        outcome.report.handed_over = now
        self._frames[self._last_sequence] = QueuedFrame(
            self._last_sequence, request, now + request.timeout, ready_at=now,
            undecoded=UndecodedOutcome(outcome, request.payload.shape, request.outputs, request.tracking is not None))
        return self._last_sequence

    def find(self, sequence: int) -> QueuedFrame | None:
        """None for unknown frames and those whose outcome was taken."""
        return self._frames.get(sequence)

    def next_to_send(self, now: float) -> QueuedFrame | None:
        """The waiting frame that goes next, if the window has room for one. In a stream that follows objects it is the
        oldest frame without an outcome, and has the state that the frames before it left."""
        if self._options.tracking is not None:
            return self._next_in_chain(now)
        is_full = sum(frame.is_in_flight() for frame in self._frames.values()) >= self._options.max_in_flight
        best: QueuedFrame | None = None
        for frame in self._frames.values():
            is_ready = frame.state is State.WAITING and frame.ready_at <= now < frame.deadline
            if is_ready and (best is None or frame.request.priority > best.request.priority):
                best = frame
            # Results that came before their turn fill the window, but must not shut out the frame they wait for.
            others_wait_for_it = self._options.order is Order.SENT and frame.state is not State.DONE
            if is_full and others_wait_for_it:
                return frame if is_ready else None
        return None if is_full else best

    def _next_in_chain(self, now: float) -> QueuedFrame | None:
        frame = next((frame for frame in self._frames.values() if frame.state is not State.DONE), None)
        if frame is None or frame.state is not State.WAITING or not frame.ready_at <= now < frame.deadline:
            return None
        if sum(other.is_in_flight() for other in self._frames.values()) >= self._options.max_in_flight:
            return None
        assert frame.request.tracking is not None
        frame.request.tracking.state = self.track_state
        return frame

    def end(self, frame: QueuedFrame, kind: OutcomeKind, error: Error | None, now: float) -> None:
        """Gives the frame its outcome."""
        frame.state = State.DONE
        self.ended += 1
        outcome = frame.undecoded.outcome
        outcome.kind, outcome.error = kind, error
        outcome.report.outcome_done = now
        if outcome.report.outcome_begun is None:
            outcome.report.outcome_begun = now
        self._done.append(frame.sequence)
        frame.request = dataclasses.replace(frame.request, payload=_NO_PAYLOAD)  # which may be many megabytes

    def end_late(self, frame: QueuedFrame, connection_error: Error | None, now: float) -> None:
        """Ends a frame whose result would come too late: as EXPIRED or FAILED, by which of its times is over first."""
        if frame.can_expire():
            self.end(frame, OutcomeKind.EXPIRED, error_of(OutcomeKind.EXPIRED), now)
        else:
            self.end(frame, OutcomeKind.FAILED, frame.too_late(connection_error), now)

    def end_all(self, kind: OutcomeKind, error: Error, now: float) -> None:
        """Ends all frames without an outcome."""
        for frame in self.unfinished():
            self.end(frame, kind, error, now)

    def fail_waiting(self, error: Error, now: float) -> None:
        """Ends all frames that are to be sent, as failed."""
        for frame in self.unfinished():
            if frame.state is State.WAITING:
                self.end(frame, OutcomeKind.FAILED, error, now)

    def end_overdue(self, connection_error: Error | None, now: float) -> list[QueuedFrame]:
        """Ends the frames whose time is over. Returns those that were sent, so that their servers can be told."""
        told = []
        for frame in self.unfinished():
            expires = frame.request.expires
            if frame.state is State.WAITING and expires is not None and expires <= now:
                self.end(frame, OutcomeKind.EXPIRED, error_of(OutcomeKind.EXPIRED), now)
            elif frame.deadline <= now:
                error = frame.too_late(connection_error)
                if frame.state is State.SENT:
                    told.append(frame)
                self.end(frame, OutcomeKind.FAILED, error, now)
        return told

    def send_again(self, frame: QueuedFrame, error: Error, ready_at: float, now: float) -> None:
        """The frame waits again. It ends instead if it was cancelled, or was sent too often and the server had room."""
        has_no_room = isinstance(error, ResourceExhausted)  # the frame waits, however long that takes
        if frame.cancelled:
            self.end(frame, OutcomeKind.CANCELLED, error_of(OutcomeKind.CANCELLED), now)
        elif frame.report.attempts >= self._options.retry.max_attempts and not has_no_room:
            self.end(frame, OutcomeKind.FAILED, error, now)
        else:
            frame.state, frame.ready_at, frame.last_error = State.WAITING, ready_at, error

    def next_change(self, now: float) -> float | None:
        """When end_overdue() or next_to_send() have to be asked again, at the latest."""
        times = []
        for frame in self.unfinished():
            times.append(frame.deadline)
            if frame.state is State.WAITING:
                if frame.request.expires is not None:
                    times.append(frame.request.expires)
                if frame.ready_at > now:
                    times.append(frame.ready_at)
        return min(times, default=None)

    def has_outcome(self) -> bool:
        """Whether an outcome can be taken now, by the order that was asked for."""
        if self._options.order is Order.DONE:
            return bool(self._done)
        return bool(self._frames) and next(iter(self._frames.values())).state is State.DONE

    def take_outcome(self) -> UndecodedOutcome | None:
        if not self.has_outcome():
            return None
        sequence = self._done[0] if self._options.order is Order.DONE else next(iter(self._frames))
        self._done.remove(sequence)
        return self._frames.pop(sequence).undecoded
