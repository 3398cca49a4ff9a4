# SPDX-License-Identifier: Apache-2.0
"""All that a stream decides."""
from __future__ import annotations

import enum
import random
from typing import NamedTuple

from segserve.errors import (Aborted, Cancelled, Error, FailedPrecondition, Internal, InvalidArgument, OutageError,
                             ResourceExhausted, TlsError, Unauthenticated, Unavailable, from_status, is_retryable,
                             unavailable_if_cancelled)
from segserve.v1 import stream_pb2
from segserve._stream.frame import FrameRequest, OutcomeKind, StreamOptions, UndecodedOutcome, WhenBehind
from segserve._stream.frame_queue import FrameQueue, QueuedFrame, State
from segserve._stream.links import Action, ActionKind, Link, Links
from segserve._stream.messages import error_of, header_message, outcome_kind
from segserve._stream.protocol import Event, EventKind, Fit, Outgoing
from segserve._stream.service_time import ServiceTime

_HOUR = 3600.0


class Admission(enum.Enum):
    OPEN = enum.auto()
    WAIT = enum.auto()
    REFUSED = enum.auto()


class Tick(NamedTuple):
    actions: list[Action]
    wake_at: float  # the next tick is due then, and after any change


class StreamScheduler:
    """Which frame goes to which server and when, what is sent again and what is given up.

    A frame that was accepted has exactly one outcome, whatever connections do. Knows no threads, no transport and no
    clock: a shell brings the lock, the time, and the calls that carry the messages. Times are seconds.
    """

    def __init__(self, options: StreamOptions, addresses: list[str], first_address: int = 0,
                 seed: int | None = None) -> None:
        """`first_address` is where to begin, and `seed` makes waits random."""
        self._options = options
        self._frames = FrameQueue(options)
        self._links = Links(options, addresses, first_address, seed)
        self._service_time = ServiceTime()
        self._rng = random.Random(seed)
        self._finished_sending = False
        self._closed = False
        self._outage_began: float | None = None  # None: a server is in reach, or still computes frames of this stream
        self._fatal: Error | None = None  # why no server will ever take a frame of this stream

    # The application's calls.

    def admission(self) -> Admission:
        """Whether accept() may be called."""
        if self._closed or self._finished_sending or self._fatal is not None:
            return Admission.REFUSED
        has_room = self._frames.waiting() < self._options.max_waiting
        if has_room or self._options.when_behind is WhenBehind.DROP_OLDEST:
            return Admission.OPEN
        return Admission.REFUSED if self._options.when_behind is WhenBehind.REJECT else Admission.WAIT

    def refusal(self) -> Error:
        """Why admission() is REFUSED."""
        if self._fatal is not None:
            return self._fatal
        if self._closed or self._finished_sending:
            return FailedPrecondition("the stream takes no more frames: finish() or close() was called")
        return ResourceExhausted(f"{self._options.max_waiting} frames wait already")

    def accept(self, request: FrameRequest, now: float) -> int:
        """Takes a frame, if admission() is OPEN, and returns its sequence: 1, 2, 3 and so on."""
        return self._frames.accept(request, now)

    def cancel(self, sequence: int, now: float) -> None:
        """The frame ends as CANCELLED unless its result is faster. Unknown and finished frames are left alone."""
        frame = self._frames.find(sequence)
        if frame is None or frame.state is State.DONE:
            return
        if frame.state is not State.SENT:
            self._frames.end(frame, OutcomeKind.CANCELLED, error_of(OutcomeKind.CANCELLED), now)
            return
        frame.cancelled = True
        link = self._links.find(frame.connection)
        if link is not None:
            link.protocol.cancel(sequence)

    def finish_sending(self) -> None:
        """No more frames will come."""
        self._finished_sending = True

    def close(self, now: float) -> None:
        """All frames without an outcome end as CANCELLED, and the connections break at the next tick."""
        self._closed = True
        self._frames.end_all(OutcomeKind.CANCELLED, Cancelled("the stream was closed"), now)

    def has_outcome(self) -> bool:
        return self._frames.has_outcome()

    def take_outcome(self) -> UndecodedOutcome | None:
        return self._frames.take_outcome()

    def exhausted(self) -> bool:
        """True if no outcome will ever come."""
        return (self._finished_sending or self._closed or self._fatal is not None) and len(self._frames) == 0

    @property
    def ended(self) -> int:
        """How many frames have got an outcome so far. A call of next_message() may end some that come too late."""
        return self._frames.ended

    # The passing of time.

    def tick(self, now: float) -> Tick:
        wake_at = now + _HOUR
        for frame in self._frames.end_overdue(self._links.last_error, now):
            self._service_time.add_at_least(now - frame.sent_at)
            link = self._links.find(frame.connection)
            if link is not None:
                link.protocol.cancel(frame.sequence)
        may_wait = self._options.wait_for_server and not isinstance(self._links.last_error, TlsError)
        if self._links.out_of_reach() and not may_wait:
            self._frames.fail_waiting(self._links.last_error or Unavailable("no server is in reach"), now)
        due: list[float | None] = []
        if self._closed:
            self._links.break_all()
        else:
            if self._finished_sending and not self._frames.unfinished():
                self._links.end_all()
            due += [self._links.check_silence(now), self._check_outage(now)]
            if self._fatal is None and (not self._finished_sending or self._frames.waiting() > 0):
                due.append(self._links.open_if_needed(now))
        due.append(self._frames.next_change(now))
        return Tick(self._links.take_actions(), min([wake_at, *(time for time in due if time is not None)]))

    def _check_outage(self, now: float) -> float | None:
        """Ends the stream if no server was in reach for too long. Returns when to call again, if ever."""
        limit = self._options.longest_outage
        if limit <= 0 or self._fatal is not None or not self._links.out_of_reach() or self._frames.sent():
            self._outage_began = None
            return None
        if self._outage_began is None:
            self._outage_began = now
        if now < self._outage_began + limit:
            return self._outage_began + limit
        cause = self._links.last_error
        self._fatal = OutageError(
            f"no server has been in reach for {limit:g} s ({cause.message if cause else 'no answer'})")
        self._frames.end_all(OutcomeKind.FAILED, self._fatal, now)
        return None

    # Reports of the transport. Unknown connections are ignored.

    def next_message(self, connection: int, now: float) -> Outgoing | None:
        """The next message of a connection; None if there is none now."""
        link = self._links.find(connection)
        if link is None:
            return None
        if link.protocol.has_turn():
            self._begin_frame(link, now)
        outgoing = link.protocol.next()
        if outgoing is None or outgoing.sequence is None:
            return outgoing
        frame = self._frames.find(outgoing.sequence)
        if frame is not None and frame.connection == connection:
            frame.report.bytes_sent += len(outgoing.data)
            if outgoing.kind == "frame":
                frame.report.header_sent = now
            if outgoing.completes_payload:
                frame.report.payload_sent = now
        return outgoing

    def _begin_frame(self, link: Link, now: float) -> None:
        """Starts to send the next frame, if there is one and the credit has room for it."""
        frame = self._next_in_time(now)
        if frame is None:
            return
        size = frame.request.payload.size
        fit = link.protocol.fit(size)
        if fit is Fit.LATER:
            return  # smaller frames must not overtake it for ever
        if fit is Fit.NEVER:
            allowed = link.protocol.credit_bytes
            error = InvalidArgument(f"the frame has {size} bytes, and at most {allowed} are allowed (credit.bytes)",
                                    reason="LIMIT_EXCEEDED",
                                    metadata={"limit": "credit.bytes", "allowed": str(allowed), "actual": str(size)})
            self._frames.end(frame, OutcomeKind.FAILED, error, now)
            return
        if link.protocol.in_flight == 0:
            link.last_sign_of_life = now  # an idle server is silent with good reason
        frame.state, frame.connection, frame.sent_at = State.SENT, link.connection, now
        frame.report.attempts += 1
        frame.report.bytes_sent = frame.report.bytes_received = 0
        header = header_message(frame.request, self._options, frame.useful_until(), now)
        link.protocol.begin(frame.sequence, header, frame.request.payload)

    def _next_in_time(self, now: float) -> QueuedFrame | None:
        """The next frame to send.

        Frames that would come too late, judged by how long the last ones took, end instead if others wait: a server
        that is behind would otherwise be late with all of them.
        """
        while (frame := self._frames.next_to_send(now)) is not None:
            others_wait = self._frames.waiting() > 1
            # Without any frame under way, nothing would tell that the server is faster again.
            is_late = now + self._service_time.bound() > frame.useful_until() and bool(self._frames.sent())
            if not others_wait or not is_late:
                return frame
            self._frames.end_late(frame, self._links.last_error, now)
        return None

    def wants_half_close(self, connection: int) -> bool:
        """Whether nothing will be sent on the connection any more."""
        link = self._links.find(connection)
        return link is not None and link.protocol.wants_half_close()

    def on_sign_of_life(self, connection: int, now: float) -> None:
        self._links.on_sign_of_life(connection, now)

    def on_message(self, connection: int, message: stream_pb2.SegmentStreamResponse, now: float) -> bool:
        """True if there may be something for the application or a tick to do."""
        link = self._links.find(connection)
        if link is None:
            return False
        self._links.on_sign_of_life(connection, now)
        if message.HasField("outcome"):
            link.outcome_bytes = 0
        link.outcome_bytes += message.ByteSize()
        try:
            event = link.protocol.receive(message)
        except Internal as error:
            self._links.break_link(link, ActionKind.BREAK, error, now)
            return True
        self._on_event(link, event, now)
        return event.kind not in (EventKind.NOTHING, EventKind.BEGUN)

    def _on_event(self, link: Link, event: Event, now: float) -> None:
        if event.kind is EventKind.OPENED:
            self._links.on_opened(link)
        elif event.kind is EventKind.DRAINING:
            self._links.on_draining(link, now)
        elif event.kind is EventKind.OLD:
            self._links.on_old(link)
        elif event.kind is EventKind.BEGUN:
            frame = self._frames.find(event.sequence)
            if frame is not None:
                frame.report.outcome_begun = now
        elif event.outcome is not None:
            self._on_outcome(link, event, event.outcome, now)

    def _on_outcome(self, link: Link, event: Event, outcome: stream_pb2.FrameOutcome, now: float) -> None:
        frame = self._frames.find(event.sequence)
        if frame is None or frame.state is not State.SENT or frame.connection != link.connection:
            return  # the frame has ended here before
        frame.report.bytes_received = link.outcome_bytes
        frame.report.address = self._links.address_of(link)
        kind, took = outcome_kind(outcome.kind), now - frame.sent_at
        if kind is OutcomeKind.EXPIRED:
            self._service_time.add_at_least(took)
            self._frames.end_late(frame, self._links.last_error, now)
            return
        if kind is OutcomeKind.FAILED:
            self._on_failed_frame(link, frame, outcome, now)
            return
        if kind is OutcomeKind.RESULT:
            self._service_time.add(took)
        if not event.is_intact:
            error = Aborted("the bytes of the result do not have the checksum that was announced", reason="CHECKSUM")
            self._frames.send_again(frame, error, now, now)
            return
        if kind is OutcomeKind.RESULT:
            frame.undecoded.message = outcome.result
            if outcome.result.HasField("tracking"):
                self._frames.track_state = outcome.result.tracking.state
        self._frames.end(frame, kind, error_of(kind), now)

    def _on_failed_frame(self, link: Link, frame: QueuedFrame, outcome: stream_pb2.FrameOutcome, now: float) -> None:
        if outcome.status.code == 0:
            error: Error = Internal("the server failed the frame and did not say why")
        else:
            error = unavailable_if_cancelled(from_status(outcome.status))
        if isinstance(error, Unauthenticated) and link.protocol.ending:
            # The time of the stream's token is over. The next stream may have a newer one; if not, that stream fails.
            self._frames.send_again(frame, error, now, now)
            return
        is_rejected = isinstance(error, ResourceExhausted) and self._options.when_behind is WhenBehind.REJECT
        if is_rejected or not is_retryable(error):
            self._frames.end(frame, OutcomeKind.FAILED, error, now)
            return
        wait = self._options.retry.backoff(frame.report.attempts, error.retry_delay, self._rng)
        self._frames.send_again(frame, error, now + wait, now)

    def on_closed(self, connection: int, status: Error | None, now: float) -> None:
        """A connection has ended, with an error or, if it is None, with OK."""
        end = self._links.on_closed(connection, status, now)
        if end is None:
            return
        if end.is_fatal:
            self._fatal = end.why
            self._frames.end_all(OutcomeKind.FAILED, end.why, now)
            return
        for frame in self._frames.sent():
            if frame.connection == connection:
                self._frames.send_again(frame, end.why, now, now)
