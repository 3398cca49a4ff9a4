# SPDX-License-Identifier: Apache-2.0
"""The client for asyncio."""
from __future__ import annotations

import asyncio
import datetime
import os
import time
import weakref
from collections.abc import Collection, Mapping, Sequence
from types import TracebackType
from typing import Any

import grpc
import grpc.aio

from segserve import calls
from segserve.aio.stream import Stream
from segserve.calls import Method, Repetition, SegmentCall, Settings
from segserve.cameras import Camera, merge_cameras
from segserve.codecs import DEFAULT_ERROR_BOUND
from segserve.encoding import Encoding, file_payload, rgbd_payload
from segserve.errors import FailedPrecondition, of_rpc_error, unavailable_if_cancelled
from segserve.handshake import explained
from segserve.info import ServerInfo, server_info
from segserve.options import DEFAULT_OUTPUTS, options_message
from segserve.result import Result
from segserve.rpc import health_pb2
from segserve.selection import Prompts
from segserve.tls import Tls
from segserve.tracking import Tracking
from segserve.v1 import segmentation_service_pb2
from segserve.view import ViewLike
from segserve._stream.address_book import Retry


class Channels:
    """A channel of gRPC to each address, made when it is needed first."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self._channels: list[grpc.aio.Channel | None] = [None] * len(settings.addresses)
        self._closed = False
        self.streams: weakref.WeakSet[Stream] = weakref.WeakSet()  # which end with the channels

    def get(self, address: int) -> grpc.aio.Channel:
        """FailedPrecondition after close(). OSError if a file of TLS cannot be read."""
        if self._closed:
            raise FailedPrecondition("the client was closed")
        channel = self._channels[address]
        if channel is None:
            name = self.settings.addresses[address]
            options = self.settings.channel_options(name)
            if self.settings.tls is None:
                channel = grpc.aio.insecure_channel(name, options)
            else:
                channel = grpc.aio.secure_channel(name, self.settings.tls.credentials(), options)
            self._channels[address] = channel
        return channel

    def renew(self, address: int, cut: grpc.aio.Channel) -> None:
        """A channel is cut, or shall be used no more: the next call makes a new one, and calls on it go on."""
        if self._channels[address] is cut:
            self._channels[address] = None

    async def close(self) -> None:
        self._closed = True
        for stream in list(self.streams):
            await stream.close()
        for channel in self._channels:
            if channel is not None:
                await channel.close()


class Client:
    """Connections to one or more servers, for the tasks of one event loop. segserve.Client describes arguments, results
    and errors.

    Clouds are encoded and results decoded on threads, so that they do not hold up the event loop.
    """

    def __init__(self, address: str = "127.0.0.1:50051", *, token: str | None = None,
                 token_file: str | os.PathLike[str] | None = None, tls: Tls | None = None, timeout: float = 30.0,
                 wait_for_server: bool = False, retry: Retry | None = None, use_proxy: bool = False,
                 unprotected_token: bool = False) -> None:
        """The arguments are those of segserve.Client."""
        self._settings = Settings(address, token=token, token_file=token_file, tls=tls, timeout=timeout,
                                  wait_for_server=wait_for_server, retry=retry, use_proxy=use_proxy,
                                  unprotected_token=unprotected_token)
        self._channels = Channels(self._settings)

    async def segment(self,
                      points: Any,
                      rgb: Any = None,
                      *,
                      view: ViewLike = None,
                      method: str | None = None,
                      threshold: float | None = None,
                      regions: int | None = None,
                      options: Mapping[str, float | str] | None = None,
                      codec: str | None = None,
                      error_bound: float = DEFAULT_ERROR_BOUND,
                      unit: str = "m",
                      outputs: Collection[str] = DEFAULT_OUTPUTS,
                      prompts: Prompts | None = None,
                      timeout: float | None = None,
                      request_id: str = "",
                      frame_id: str = "",
                      stamp: datetime.datetime | None = None,
                      traceparent: str | None = None,
                      tracking: Tracking | None = None) -> Result:
        """Segments a cloud; see segserve.Client.segment."""
        payload = await asyncio.to_thread(Encoding(view, codec, error_bound, unit).payload, points, rgb)
        call = SegmentCall(payload, options_message(method, threshold, regions, options), outputs, prompts, request_id,
                           frame_id, stamp, tracking)
        request = await asyncio.to_thread(call.request)
        if request is None:
            return await self._stream_one(call, timeout)
        return await asyncio.to_thread(call.result, await self._call(calls.SEGMENT, request, timeout, traceparent))

    async def segment_rgbd(self, depth: Any, color: Any, intrinsics: Any, *, depth_scale: float | None = None,
                           color_intrinsics: Any = None, images: str = "raw", **call: Any) -> Result:
        """Segments the images of an RGB-D camera; see segserve.Client.segment_rgbd."""
        payload = await asyncio.to_thread(rgbd_payload, depth, color, intrinsics, depth_scale=depth_scale,
                                          color_intrinsics=color_intrinsics, images=images)
        return await self.segment(payload, **call)

    async def segment_cameras(self, cameras: Sequence[Camera], **call: Any) -> Result:
        """Segments what several cameras see as one cloud; see segserve.Client.segment_cameras."""
        merged = await asyncio.to_thread(merge_cameras, cameras)
        return merged.restore(await self.segment(merged.cloud, view=merged.view, **call))

    async def segment_file(self,
                           path: str | os.PathLike[str],
                           *,
                           view: ViewLike = None,
                           unit: str = "m",
                           **call: Any) -> Result:
        """Segments a PCD file; see segserve.Client.segment_file."""
        return await self.segment(await asyncio.to_thread(file_payload, path, view, unit), **call)

    def stream(self, *, view: ViewLike = None, codec: str | None = None, error_bound: float = DEFAULT_ERROR_BOUND,
               unit: str = "m", method: str | None = None, threshold: float | None = None, regions: int | None = None,
               options: Mapping[str, float | str] | None = None, **rules: Any) -> Stream:
        """Opens a stream of frames, in a running event loop; see segserve.Client.stream."""
        return Stream(self._channels, calls.stream_rules(options_message(method, threshold, regions, options), rules),
                      Encoding(view, codec, error_bound, unit))

    async def info(self, timeout: float | None = None) -> ServerInfo:
        """What the server can do: version, codecs, limits, methods and options."""
        return server_info(await self._call(calls.SERVER_INFO, segmentation_service_pb2.GetServerInfoRequest(),
                                            timeout))

    async def health(self, service: str = "", timeout: float | None = None) -> bool:
        """Whether the server says SERVING; see segserve.Client.health."""
        response = await self._call(calls.HEALTH, health_pb2.HealthCheckRequest(service=service), timeout)
        return bool(response.status == health_pb2.HealthCheckResponse.SERVING)

    async def close(self) -> None:
        """Closes the streams, whose unfinished frames end as CANCELLED, and the connections with all calls."""
        await self._channels.close()

    async def __aenter__(self) -> Client:
        return self

    async def __aexit__(self, kind: type[BaseException] | None, error: BaseException | None,
                        trace: TracebackType | None) -> None:
        await self.close()

    async def _stream_one(self, call: SegmentCall, timeout: float | None) -> Result:
        limit = calls.checked_timeout(self._settings.timeout if timeout is None else timeout)
        async with Stream(self._channels, call.stream_options(self._settings, limit), Encoding()) as stream:
            await stream.send(call.payload, prompts=call.prompts, request_id=call.request_id, frame_id=call.frame_id,
                              stamp=call.stamp)
            outcome = await stream.next()
            assert outcome is not None
            return outcome.get()

    async def _call(self, method: Method, request: Any, timeout: float | None, traceparent: str | None = None) -> Any:
        """Makes a unary call, again and elsewhere while that may help."""
        deadline = time.monotonic() + calls.checked_timeout(self._settings.timeout if timeout is None else timeout)
        metadata = self._settings.metadata(traceparent)
        repetition = Repetition(self._settings, deadline)
        while True:
            attempt = repetition.next(time.monotonic())
            await asyncio.sleep(max(0.0, attempt.not_before - time.monotonic()))
            call = self._channels.get(attempt.address).unary_unary(method.path, method.serialize, method.parse)
            try:
                return await call(request, timeout=deadline - time.monotonic(), metadata=metadata)
            except grpc.aio.AioRpcError as error:
                address = self._settings.addresses[attempt.address]
                known = unavailable_if_cancelled(of_rpc_error(error, address))
                known = await asyncio.to_thread(explained, known, address, self._settings.tls)
                repetition.failed(attempt, known, time.monotonic())
