# SPDX-License-Identifier: Apache-2.0
"""The stream for threads."""
from __future__ import annotations

import datetime
import threading
import time
from collections.abc import Collection, Iterable, Iterator, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any

import grpc

from segserve import calls
from segserve.encoding import Encoding
from segserve.errors import DeadlineExceeded, Error, Unavailable, of_rpc_error
from segserve.handshake import explained
from segserve.options import options_message, outputs_message
from segserve.payload import Payload
from segserve.selection import Prompts
from segserve.v1 import options_pb2, segmentation_service_pb2
from segserve.view import ViewLike
from segserve._stream.frame import FrameRequest, Outcome, StreamOptions
from segserve._stream.links import Action, ActionKind
from segserve._stream.outcomes import decode_outcome
from segserve._stream.scheduler import Admission, StreamScheduler

if TYPE_CHECKING:
    from segserve.client import Channels


def frame_request(stream: StreamOptions, payload: Payload, *, method: str | None, threshold: float | None,
                  regions: int | None, options: Mapping[str, float | str] | None, outputs: Collection[str] | None,
                  prompts: Prompts | None, request_id: str, frame_id: str, stamp: datetime.datetime | None, captured: float | None,
                  time_to_live: float | None, priority: int, timeout: float | None, now: float,
                  pose: Any = None) -> FrameRequest:
    """A frame as it is handed over; what is None has the value of the stream. ValueError, TypeError."""
    has_own = not (method is None and threshold is None and regions is None and options is None)
    if outputs is not None:
        outputs_message(outputs, False)  # so that wrong names are noticed here
    own: options_pb2.SegmentOptions = options_message(method, threshold, regions,
                                                      options) if has_own else stream.options
    captured = now if captured is None else min(captured, now)
    tracking = None
    if stream.tracking is not None:
        tracking = stream.tracking.of_frame(pose, captured if stamp is None else stamp.timestamp()).message()
    elif pose is not None:
        raise ValueError("pose: it is for a stream that was opened with tracking")
    return FrameRequest(
        payload, own, stream.outputs if outputs is None else outputs, prompts=prompts, captured=captured,
        tracking=tracking,
        timeout=stream.frame_timeout if timeout is None else calls.checked_timeout(timeout), request_id=request_id,
        frame_id=frame_id, stamp=stamp, time_to_live=time_to_live, priority=priority)


class Stream:
    """A stream of frames to whichever server is in reach, made by Client.stream().

        with client.stream(view="camera", when_behind="drop_oldest") as stream:
            stream.send(xyz, rgb, time_to_live=0.5)  # from any thread
            stream.finish()
            for outcome in stream:
                use(outcome)

    Every frame that send() accepts ends in exactly one Outcome, also when the server stops, the connection breaks or
    the network goes silent. Unfinished frames then go to another server, which is safe because a result is a pure
    function of the frame.

    Any number of threads may call the functions at the same time. A thread that both sends and takes outcomes must take
    some before it has sent max_in_flight + max_waiting frames more than it has taken, or use map(): with
    when_behind="block", send() would otherwise wait in vain until the timeout.
    """

    def __init__(self, channels: Channels, options: StreamOptions, encoding: Encoding) -> None:
        self._channels = channels
        self._options = options
        self._encoding = encoding
        settings = channels.settings
        self._scheduler = StreamScheduler(options, settings.addresses, settings.next_start())
        self._changed = threading.Condition()
        self._changes = 0
        self._stopping = False
        self._connections: dict[int, _Connection] = {}
        channels.streams.add(self)
        self._timer = threading.Thread(target=self._keep_time, name="segserve stream", daemon=True)
        self._timer.start()

    # The application's calls.

    def send(self, points: Any, rgb: Any = None, *, view: ViewLike = None, method: str | None = None,
             threshold: float | None = None, regions: int | None = None, options: Mapping[str, float | str] | None = None,
             outputs: Collection[str] | None = None, prompts: Prompts | None = None, request_id: str = "",
             frame_id: str = "",
             stamp: datetime.datetime | None = None, captured: float | None = None, time_to_live: float | None = None,
             priority: int = 0, timeout: float | None = None, pose: Any = None) -> int:
        """Hands a frame over, of which the stream keeps a copy, and returns its sequence: 1, 2, 3 and so on.

        points, rgb, view: as for Client.segment(). method, threshold, regions, options: if one of them is given, they
        replace those of the stream as a whole. prompts: see Client.segment(). captured: when the cloud was taken, by time.monotonic(). time_to_live:
        the result is of no use later than so many seconds after that; the frame then ends as EXPIRED. Among frames that
        wait, those of higher priority go first. timeout: from now to the outcome, all repetitions included.
        pose: see Tracking, for a stream with tracking.

        ValueError, TypeError: the arguments make no sense. ResourceExhausted: too many frames wait ("reject").
        DeadlineExceeded: too many frames waited for the timeout of this one ("block"). FailedPrecondition: finish() or
        close() was called. Any other Error is one for which no server will ever take a frame of this stream.
        """
        now = time.monotonic()
        request = frame_request(self._options,
                                self._encoding.payload(points, rgb, view),
                                method=method,
                                threshold=threshold,
                                regions=regions,
                                options=options,
                                outputs=outputs,
                                prompts=prompts,
                                request_id=request_id,
                                frame_id=frame_id,
                                stamp=stamp,
                                captured=captured,
                                time_to_live=time_to_live,
                                priority=priority,
                                timeout=timeout,
                                pose=pose,
                                now=now)
        request.payload.crc32  # computed here, where no lock is held
        with self._changed:
            while self._scheduler.admission() is Admission.WAIT:
                if not self._wait(now + request.timeout) and self._scheduler.admission() is Admission.WAIT:
                    raise DeadlineExceeded(
                        f"{self._options.max_waiting} frames wait already, and none of them was sent in time")
            if self._scheduler.admission() is Admission.REFUSED:
                raise self._scheduler.refusal()
            sequence = self._scheduler.accept(request, time.monotonic())
            self._notify()
            return sequence

    def next(self, timeout: float | None = None) -> Outcome | None:
        """Waits for the next outcome, without limit if `timeout` (seconds) is None.

        None if the time is over, or if finish() or close() was called and every outcome was taken.
        """
        until = None if timeout is None else time.monotonic() + timeout
        with self._changed:
            while not self._scheduler.has_outcome() and not self._scheduler.exhausted():
                if not self._wait(until) and not self._scheduler.has_outcome():
                    return None
            undecoded = self._scheduler.take_outcome()
            self._notify()  # there may be room for another frame, and this may have been the last outcome
        return None if undecoded is None else decode_outcome(undecoded)

    def __iter__(self) -> Iterator[Outcome]:
        """The outcomes, until finish() was called and every one was taken."""
        while (outcome := self.next()) is not None:
            yield outcome

    def map(self, frames: Iterable[Any]) -> Iterator[Outcome]:
        """Sends frames and yields outcomes, all on this thread, and finishes the stream.

        A frame is what send() takes as its first argument, a pair (xyz, rgb), or a dict of all its arguments. While the
        next frame does not come, no outcome is yielded: a camera and its consumer are better two threads.
        """
        for frame in frames:
            while not self._can_send():
                outcome = self.next()
                if outcome is not None:
                    yield outcome
            if isinstance(frame, dict):
                self.send(**frame)
            else:
                self.send(*(frame if isinstance(frame, tuple) else (frame,)))
            while (outcome := self.next(timeout=0)) is not None:
                yield outcome
        self.finish()
        yield from self

    def _can_send(self) -> bool:
        """Waits until a frame can be sent, True, or an outcome must be taken before that, False."""
        with self._changed:
            while self._scheduler.admission() is Admission.WAIT:
                if self._scheduler.has_outcome():
                    return False
                self._wait(None)
            return True

    def cancel(self, sequence: int) -> None:
        """The frame is not wanted any more: it ends as CANCELLED, unless its result is faster."""
        with self._changed:
            self._scheduler.cancel(sequence, time.monotonic())
            self._notify()

    def finish(self) -> None:
        """No more frames will be sent. Those that were sent end as usual."""
        with self._changed:
            self._scheduler.finish_sending()
            self._notify()

    @property
    def done(self) -> bool:
        """True once finish() or close() was called and every outcome was taken."""
        with self._changed:
            return self._scheduler.exhausted()

    def close(self) -> None:
        """Ends the unfinished frames as CANCELLED, and waits for the threads of the stream."""
        with self._changed:
            self._stopping = True
            self._scheduler.close(time.monotonic())
            self._notify()
        self._timer.join()

    def __enter__(self) -> Stream:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    # The threads. Every function whose name begins so expects the lock: _notify, _wait.

    def _notify(self) -> None:
        self._changes += 1
        self._changed.notify_all()

    def _wait(self, until: float | None) -> bool:
        """False if the time is over."""
        if until is None:
            self._changed.wait()
            return True
        left = until - time.monotonic()
        return left > 0 and self._changed.wait(left)

    def _keep_time(self) -> None:
        """The timer thread."""
        while True:
            with self._changed:
                seen = self._changes
                tick = self._scheduler.tick(time.monotonic())
                # The tick may have ended frames, which concerns those who wait for outcomes or for room.
                self._changed.notify_all()
                if self._stopping and not self._connections and not tick.actions:
                    return
            for action in tick.actions:
                self._perform(action)
            with self._changed:
                while self._changes == seen and self._wait(tick.wake_at):
                    pass

    def _perform(self, action: Action) -> None:
        if action.kind is ActionKind.OPEN:
            self._open(action)
            return
        with self._changed:
            connection = self._connections.get(action.connection)
        if connection is None:
            return
        if action.kind is ActionKind.PROBE:
            connection.probe(self._options.progress_timeout / 2)
            return
        if action.kind is not ActionKind.BREAK:
            self._channels.renew(action.address, connection.channel)
        if action.kind is not ActionKind.RENEW:
            connection.call.cancel()

    def _open(self, action: Action) -> None:
        address = self._channels.settings.addresses[action.address]
        try:
            channel = self._channels.get(action.address)
            metadata = self._channels.settings.metadata()
            with self._changed:
                self._connections[action.connection] = _Connection(self, action.connection, address, channel, metadata)
        except Error as error:
            self._on_closed(action.connection, error)
        except (OSError, ValueError) as error:  # a file of TLS or of the token; a closed channel
            self._on_closed(action.connection, Unavailable(f"{address}: {error}"))

    def _on_closed(self, connection: int, error: Error | None) -> None:
        with self._changed:
            self._scheduler.on_closed(connection, error, time.monotonic())
            self._connections.pop(connection, None)
            self._notify()

    def _requests(self, connection: int) -> Iterator[bytes]:
        """The messages of a connection, on a thread of gRPC's, which asks for the next when the one before is
        written."""
        while True:
            with self._changed:
                self._scheduler.on_sign_of_life(connection, time.monotonic())
                while (outgoing := self._next_message(connection)) is None:
                    if connection not in self._connections or self._scheduler.wants_half_close(connection):
                        return
                    self._changed.wait()
            yield outgoing

    def _next_message(self, connection: int) -> bytes | None:
        ended = self._scheduler.ended
        outgoing = self._scheduler.next_message(connection, time.monotonic())
        begins_frame = outgoing is not None and outgoing.kind == "frame"
        if begins_frame or self._scheduler.ended != ended:
            self._notify()  # fewer frames wait, or there is an outcome
        return None if outgoing is None else outgoing.data

    def _receive(self, connection: int, address: str, call: Any) -> None:
        """The reading thread of a connection."""
        error: Error | None = None
        heard = False  # anything from the server
        try:
            for message in call:
                heard = True
                with self._changed:
                    if self._scheduler.on_message(connection, message, time.monotonic()):
                        self._notify()
        except grpc.RpcError as failure:
            error = of_rpc_error(failure, address)
            if not heard:
                error = explained(error, address, self._channels.settings.tls)
        self._on_closed(connection, error)

    def _on_probed(self, connection: int) -> None:
        with self._changed:
            self._scheduler.on_sign_of_life(connection, time.monotonic())
            self._notify()


class _Connection:
    """The call of a stream to one server."""

    def __init__(self, stream: Stream, number: int, address: str, channel: grpc.Channel,
                 metadata: list[tuple[str, str]]) -> None:
        self.channel = channel
        self._stream = stream
        self._number = number
        self._metadata = metadata
        open_call = channel.stream_stream(calls.STREAM.path, calls.STREAM.serialize, calls.STREAM.parse)
        self.call = open_call(stream._requests(number), metadata=metadata)
        threading.Thread(target=stream._receive, args=(number, address, self.call), name="segserve reader",
                         daemon=True).start()

    def probe(self, timeout: float) -> None:
        """Asks the server something that any living one answers at once, even while it computes."""
        method = calls.SERVER_INFO
        ask = self.channel.unary_unary(method.path, method.serialize, method.parse)
        try:
            answer = ask.future(segmentation_service_pb2.GetServerInfoRequest(),
                                timeout=timeout,
                                metadata=self._metadata)
        except ValueError:  # gRPC's word for a channel that was closed meanwhile
            return

        def on_answer(done: Any) -> None:
            if done.code() in (grpc.StatusCode.OK, grpc.StatusCode.UNAUTHENTICATED):  # a refusal is an answer, too
                self._stream._on_probed(self._number)

        answer.add_done_callback(on_answer)
