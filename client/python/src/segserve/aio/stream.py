# SPDX-License-Identifier: Apache-2.0
"""The stream for asyncio."""
from __future__ import annotations

import asyncio
import datetime
import time
from collections.abc import AsyncIterable, AsyncIterator, Collection, Iterable, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any

import grpc
import grpc.aio

from segserve import calls
from segserve.encoding import Encoding
from segserve.errors import DeadlineExceeded, Error, Unavailable, from_rpc
from segserve.handshake import explained
from segserve.selection import Prompts
from segserve.stream import frame_request
from segserve.tls import Tls
from segserve.v1 import segmentation_service_pb2
from segserve.view import ViewLike
from segserve._stream.frame import Outcome, StreamOptions
from segserve._stream.links import Action, ActionKind
from segserve._stream.outcomes import decode_outcome
from segserve._stream.scheduler import Admission, StreamScheduler

if TYPE_CHECKING:
    from segserve.aio.client import Channels


class Stream:
    """A stream of frames to whichever server is in reach, made by aio.Client.stream(). segserve.Stream describes it.

        async with client.stream(view="camera") as stream:
            await stream.send(xyz, rgb)
            stream.finish()
            async for outcome in stream:
                use(outcome)

    Only tasks of the event loop in which it was made may use it.
    """

    def __init__(self, channels: Channels, options: StreamOptions, encoding: Encoding) -> None:
        self._channels = channels
        self._options = options
        self._encoding = encoding
        settings = channels.settings
        self._scheduler = StreamScheduler(options, settings.addresses, settings.next_start())
        self._waiting: set[asyncio.Future[None]] = set()
        self._changes = 0
        self._stopping = False
        self._connections: dict[int, _Connection] = {}
        self._probes: set[asyncio.Task[None]] = set()
        channels.streams.add(self)
        self._timer = asyncio.get_running_loop().create_task(self._keep_time(), name="segserve stream")

    # The application's calls.

    async def send(self,
                   points: Any,
                   rgb: Any = None,
                   *,
                   view: ViewLike = None,
                   method: str | None = None,
                   threshold: float | None = None,
                   regions: int | None = None,
                   options: Mapping[str, float | str] | None = None,
                   outputs: Collection[str] | None = None,
                   prompts: Prompts | None = None,
                   request_id: str = "",
                   frame_id: str = "",
                   stamp: datetime.datetime | None = None,
                   captured: float | None = None,
                   time_to_live: float | None = None,
                   priority: int = 0,
                   timeout: float | None = None,
                   pose: Any = None) -> int:
        """Hands a frame over and returns its sequence; see segserve.Stream.send. The arrays must not change until it
        returns."""
        now = time.monotonic()
        payload = await asyncio.to_thread(self._encoding.payload, points, rgb, view)
        request = frame_request(self._options,
                                payload,
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
        await asyncio.to_thread(lambda: payload.crc32)
        while self._scheduler.admission() is Admission.WAIT:
            if not await self._wait(now + request.timeout) and self._scheduler.admission() is Admission.WAIT:
                raise DeadlineExceeded(
                    f"{self._options.max_waiting} frames wait already, and none of them was sent in time")
        if self._scheduler.admission() is Admission.REFUSED:
            raise self._scheduler.refusal()
        sequence = self._scheduler.accept(request, time.monotonic())
        self._notify()
        return sequence

    async def next(self, timeout: float | None = None) -> Outcome | None:
        """Waits for the next outcome; see segserve.Stream.next."""
        until = None if timeout is None else time.monotonic() + timeout
        while not self._scheduler.has_outcome() and not self._scheduler.exhausted():
            if not await self._wait(until) and not self._scheduler.has_outcome():
                return None
        undecoded = self._scheduler.take_outcome()
        self._notify()  # there may be room for another frame, and this may have been the last outcome
        return None if undecoded is None else await asyncio.to_thread(decode_outcome, undecoded)

    async def __aiter__(self) -> AsyncIterator[Outcome]:
        """The outcomes, until finish() was called and every one was taken."""
        while (outcome := await self.next()) is not None:
            yield outcome

    async def map(self, frames: Iterable[Any] | AsyncIterable[Any]) -> AsyncIterator[Outcome]:
        """Sends frames while it yields outcomes, and finishes the stream. segserve.Stream.map says what a frame is."""
        sender = asyncio.get_running_loop().create_task(self._send_all(frames))
        try:
            async for outcome in self:
                yield outcome
            await sender
        finally:
            sender.cancel()
            await asyncio.gather(sender, return_exceptions=True)  # so that its error counts as seen

    async def _send_all(self, frames: Iterable[Any] | AsyncIterable[Any]) -> None:
        async def send(frame: Any) -> None:
            if isinstance(frame, dict):
                await self.send(**frame)
            else:
                await self.send(*(frame if isinstance(frame, tuple) else (frame,)))

        try:
            if isinstance(frames, AsyncIterable):
                async for frame in frames:
                    await send(frame)
            else:
                for frame in frames:
                    await send(frame)
        finally:
            self.finish()

    def cancel(self, sequence: int) -> None:
        """The frame is not wanted any more: it ends as CANCELLED, unless its result is faster."""
        self._scheduler.cancel(sequence, time.monotonic())
        self._notify()

    def finish(self) -> None:
        """No more frames will be sent. Those that were sent end as usual."""
        self._scheduler.finish_sending()
        self._notify()

    @property
    def done(self) -> bool:
        """True once finish() or close() was called and every outcome was taken."""
        return self._scheduler.exhausted()

    async def close(self) -> None:
        """Ends the unfinished frames as CANCELLED, and waits for the tasks of the stream."""
        self._stopping = True
        self._scheduler.close(time.monotonic())
        self._notify()
        await self._timer
        for probe in self._probes:
            probe.cancel()
        await asyncio.gather(*self._probes, return_exceptions=True)

    async def __aenter__(self) -> Stream:
        return self

    async def __aexit__(self, kind: type[BaseException] | None, error: BaseException | None,
                        trace: TracebackType | None) -> None:
        await self.close()

    # The tasks.

    def _notify(self) -> None:
        self._changes += 1
        self._wake_all()

    def _wake_all(self) -> None:
        for waiter in self._waiting:
            if not waiter.done():
                waiter.set_result(None)

    async def _wait(self, until: float | None) -> bool:
        """Waits for a change. False if the time is over."""
        left = None if until is None else until - time.monotonic()
        if left is not None and left <= 0:
            return False
        waiter: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.add(waiter)
        try:
            done, _ = await asyncio.wait({waiter}, timeout=left)
            return bool(done)
        finally:
            self._waiting.discard(waiter)

    async def _keep_time(self) -> None:
        while True:
            seen = self._changes
            tick = self._scheduler.tick(time.monotonic())
            # The tick may have ended frames, which concerns those who wait for outcomes or for room.
            self._wake_all()
            if self._stopping and not self._connections and not tick.actions:
                return
            for action in tick.actions:
                self._perform(action)
            while self._changes == seen and await self._wait(tick.wake_at):
                pass

    def _perform(self, action: Action) -> None:
        if action.kind is ActionKind.OPEN:
            self._open(action)
            return
        connection = self._connections.get(action.connection)
        if connection is None:
            return
        if action.kind is ActionKind.PROBE:
            probe = asyncio.get_running_loop().create_task(self._probe(connection))
            self._probes.add(probe)
            probe.add_done_callback(self._probes.discard)
            return
        if action.kind is not ActionKind.BREAK:
            self._channels.renew(action.address, connection.channel)
        if action.kind is not ActionKind.RENEW:
            connection.call.cancel()

    def _open(self, action: Action) -> None:
        address = self._channels.settings.addresses[action.address]
        try:
            self._connections[action.connection] = _Connection(self, action.connection, address,
                                                               self._channels.get(action.address),
                                                               self._channels.settings.metadata())
        except Error as error:
            self.on_closed(action.connection, error)
        except (OSError, ValueError, grpc.aio.UsageError) as error:  # a file of TLS or of the token; a closed channel
            self.on_closed(action.connection, Unavailable(f"{address}: {error}"))

    async def _probe(self, connection: _Connection) -> None:
        """Asks the server something that any living one answers at once, even while it computes."""
        method = calls.SERVER_INFO
        ask = connection.channel.unary_unary(method.path, method.serialize, method.parse)
        try:
            await ask(segmentation_service_pb2.GetServerInfoRequest(), timeout=self._options.progress_timeout / 2,
                      metadata=connection.metadata)
        except grpc.aio.AioRpcError as error:
            if error.code() is not grpc.StatusCode.UNAUTHENTICATED:  # a refusal is an answer, too
                return
        except grpc.aio.UsageError:  # the channel was closed
            return
        self._scheduler.on_sign_of_life(connection.number, time.monotonic())
        self._notify()

    # For the connections.

    @property
    def tls(self) -> Tls | None:
        return self._channels.settings.tls

    async def next_message(self, connection: int) -> bytes | None:
        """Waits for the next message of a connection; None once there will be none."""
        while True:
            ended = self._scheduler.ended
            outgoing = self._scheduler.next_message(connection, time.monotonic())
            begins_frame = outgoing is not None and outgoing.kind == "frame"
            if begins_frame or self._scheduler.ended != ended:
                self._notify()  # fewer frames wait, or there is an outcome
            if outgoing is not None:
                return outgoing.data
            if connection not in self._connections or self._scheduler.wants_half_close(connection):
                return None
            await self._wait(None)

    def on_written(self, connection: int) -> None:
        self._scheduler.on_sign_of_life(connection, time.monotonic())

    def on_message(self, connection: int, message: Any) -> None:
        if self._scheduler.on_message(connection, message, time.monotonic()):
            self._notify()

    def on_closed(self, connection: int, error: Error | None) -> None:
        self._scheduler.on_closed(connection, error, time.monotonic())
        self._connections.pop(connection, None)
        self._notify()


class _Connection:
    """The call of a stream to one server."""

    def __init__(self, stream: Stream, number: int, address: str, channel: grpc.aio.Channel,
                 metadata: list[tuple[str, str]]) -> None:
        self.channel = channel
        self.number = number
        self.metadata = metadata
        self._stream = stream
        self._address = address
        open_call = channel.stream_stream(calls.STREAM.path, calls.STREAM.serialize, calls.STREAM.parse)
        self.call = open_call(metadata=metadata)
        loop = asyncio.get_running_loop()
        self._tasks = [loop.create_task(self._write()), loop.create_task(self._read())]

    async def _write(self) -> None:
        try:
            while (message := await self._stream.next_message(self.number)) is not None:
                await self.call.write(message)
                self._stream.on_written(self.number)
            if not self.call.done():
                await self.call.done_writing()
        except (grpc.RpcError, asyncio.InvalidStateError, asyncio.CancelledError):
            return  # the call has ended: _read says why

    async def _read(self) -> None:
        error: Error | None = None
        heard = False  # anything from the server
        try:
            while (message := await self.call.read()) is not grpc.aio.EOF:
                heard = True
                self._stream.on_message(self.number, message)
        except (grpc.RpcError, asyncio.CancelledError):
            pass  # the status says why
        code = await self.call.code()
        if code is not grpc.StatusCode.OK:
            error = from_rpc(code, await self.call.details(), await self.call.trailing_metadata(), self._address)
            if not heard:
                error = await asyncio.to_thread(explained, error, self._address, self._stream.tls)
        self._stream.on_closed(self.number, error)
