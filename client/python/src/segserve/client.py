# SPDX-License-Identifier: Apache-2.0
"""The client that blocks."""
from __future__ import annotations

import datetime
import os
import threading
import time
import weakref
from collections.abc import Collection, Mapping, Sequence
from types import TracebackType
from typing import Any

import grpc

from segserve import calls
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
from segserve.stream import Stream
from segserve.tls import Tls
from segserve.tracking import Tracking
from segserve.v1 import segmentation_service_pb2
from segserve.view import ViewLike
from segserve._stream.address_book import Retry


class Channels:
    """A channel of gRPC to each address, made when it is needed first."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self._lock = threading.Lock()
        self._channels: list[grpc.Channel | None] = [None] * len(settings.addresses)
        self._closed = False
        self.streams: weakref.WeakSet[Stream] = weakref.WeakSet()  # which end with the channels

    def get(self, address: int) -> grpc.Channel:
        """FailedPrecondition after close(). OSError if a file of TLS cannot be read."""
        with self._lock:
            if self._closed:
                raise FailedPrecondition("the client was closed")
            channel = self._channels[address]
            if channel is None:
                name = self.settings.addresses[address]
                options = self.settings.channel_options(name)
                if self.settings.tls is None:
                    channel = grpc.insecure_channel(name, options)
                else:
                    channel = grpc.secure_channel(name, self.settings.tls.credentials(), options)
                self._channels[address] = channel
            return channel

    def renew(self, address: int, cut: grpc.Channel) -> None:
        """A channel is cut, or shall be used no more: the next call makes a new one, and calls on it go on."""
        with self._lock:
            if self._channels[address] is cut:
                self._channels[address] = None

    def close(self) -> None:
        with self._lock:
            self._closed = True
        for stream in list(self.streams):
            stream.close()
        for channel in self._channels:
            if channel is not None:
                channel.close()


class Client:
    """Connections to one or more servers. Any number of threads may use it at the same time; its calls block.

        with segserve.Client("robot-a:50051,robot-b:50051") as client:
            result = client.segment(xyz, rgb, view="camera")
            print(result.labels)

    A failed call raises a subclass of segserve.Error: those of the server, Unavailable (no server is in reach),
    DeadlineExceeded, or Internal (the answer is broken). Wrong arguments raise ValueError or TypeError before anything
    is sent.
    """

    def __init__(self, address: str = "127.0.0.1:50051", *, token: str | None = None,
                 token_file: str | os.PathLike[str] | None = None, tls: Tls | None = None, timeout: float = 30.0,
                 wait_for_server: bool = False, retry: Retry | None = None, use_proxy: bool = False,
                 unprotected_token: bool = False) -> None:
        """Does not wait for a server: health() does.

        address: HOST:PORT (without a port: 50051), or any other name that gRPC resolves. Several are separated by
        commas.
        token, token_file: a bearer token, or a file with one, which is read again when it changes. It is sent over TLS
        or to this machine only, unless `unprotected_token` is true.
        timeout: of a call with all its repetitions, if it sets none itself, seconds.
        wait_for_server: when no address is in reach, a call waits for one until its timeout instead of raising
        Unavailable.
        use_proxy: connections beyond this machine go through the proxy that the environment names.

        ValueError for settings that make no sense. OSError if a file cannot be read.
        """
        self._settings = Settings(address, token=token, token_file=token_file, tls=tls, timeout=timeout,
                                  wait_for_server=wait_for_server, retry=retry, use_proxy=use_proxy,
                                  unprotected_token=unprotected_token)
        self._channels = Channels(self._settings)

    def segment(self, points: Any, rgb: Any = None, *, view: ViewLike = None, method: str | None = None,
                threshold: float | None = None, regions: int | None = None, options: Mapping[str, float | str] | None = None,
                codec: str | None = None, error_bound: float = DEFAULT_ERROR_BOUND, unit: str = "m",
                outputs: Collection[str] = DEFAULT_OUTPUTS, prompts: Prompts | None = None,
                timeout: float | None = None, request_id: str = "",
                frame_id: str = "", stamp: datetime.datetime | None = None, traceparent: str | None = None,
                tracking: Tracking | None = None) -> Result:
        """Segments a cloud. One that is too large for a message goes by a stream, in chunks.

        points, rgb: xyz (N, 3) or organized (H, W, 3) in meters, float32 or float64, NaN where there is no point;
        colors of the same shape, uint8 or floats from 0 to 1. Or a structured array, a cloud of Open3D, a PointCloud2
        of ROS, or a Payload of encode().
        view: "camera" (z forward, the sensor at the origin), "world" or "world:X,Y,Z" (the position of the sensor).
        None: the server chooses by the points, which Result.view tells.
        method, threshold, regions, options: how it is segmented. info() tells names, ranges and defaults. options
            may also hold "preset", what kind of cloud it is: auto, tabletop, room, lidar or scan.
        codec, error_bound, unit: see encode().
        outputs: which of labels, supervoxels, tree and segments the result holds.
        prompts: places on an object and beside it, of which Result.selection tells what they select.
        request_id, frame_id, stamp: come back with the result. traceparent: that of the W3C, for tracing.
        tracking: asks for ids that objects keep, Result.tracks; its state is that of the cloud before.
        """
        payload = Encoding(view, codec, error_bound, unit).payload(points, rgb)
        call = SegmentCall(payload, options_message(method, threshold, regions, options), outputs, prompts, request_id,
                           frame_id, stamp, tracking)
        request = call.request()
        if request is None:
            return self._stream_one(call, timeout)
        return call.result(self._call(calls.SEGMENT, request, timeout, traceparent))

    def segment_rgbd(self, depth: Any, color: Any, intrinsics: Any, *, depth_scale: float | None = None,
                     color_intrinsics: Any = None, images: str = "raw", **call: Any) -> Result:
        """Segments the images of an RGB-D camera; encode_rgbd() says how they are given. Messages of ROS (Image,
        CameraInfo) fit, too.

        The other arguments are those of segment(). The labels have the rows and columns of the depth.
        """
        return self.segment(
            rgbd_payload(depth,
                         color,
                         intrinsics,
                         depth_scale=depth_scale,
                         color_intrinsics=color_intrinsics,
                         images=images), **call)

    def segment_cameras(self, cameras: Sequence[Camera], **call: Any) -> Result:
        """Segments what several cameras see at the same time as one cloud: an object that several of them see is one
        segment. Camera tells what each of them brings, and its pose.

        The other arguments are those of segment() but for rgb and view. Result.labels has the points of all cameras one
        after the other, and Result.by_camera() the labels of each camera in the shape of its input.
        """
        merged = merge_cameras(cameras)
        return merged.restore(self.segment(merged.cloud, view=merged.view, **call))

    def segment_file(self,
                     path: str | os.PathLike[str],
                     *,
                     view: ViewLike = None,
                     unit: str = "m",
                     **call: Any) -> Result:
        """Segments a PCD file, whose bytes are sent as they are. The labels have the shape (N,).

        `view` overrides that of the file. The other arguments are those of segment().
        """
        return self.segment(file_payload(path, view, unit), **call)

    def stream(self, *, view: ViewLike = None, codec: str | None = None, error_bound: float = DEFAULT_ERROR_BOUND,
               unit: str = "m", method: str | None = None, threshold: float | None = None, regions: int | None = None,
               options: Mapping[str, float | str] | None = None, **rules: Any) -> Stream:
        """Opens a stream of frames. Does not wait for a server.

        The named arguments are those of segment(), for frames that have none of their own. `rules` are the members of
        StreamOptions, such as max_in_flight=2 or when_behind="drop_oldest".
        """
        return Stream(self._channels, calls.stream_rules(options_message(method, threshold, regions, options), rules),
                      Encoding(view, codec, error_bound, unit))

    def info(self, timeout: float | None = None) -> ServerInfo:
        """What the server can do: version, codecs, limits, methods and options."""
        return server_info(self._call(calls.SERVER_INFO, segmentation_service_pb2.GetServerInfoRequest(), timeout))

    def health(self, service: str = "", timeout: float | None = None) -> bool:
        """Whether the server says SERVING (grpc.health.v1). Unavailable if no server answers, NotFound for an unknown
        service."""
        response = self._call(calls.HEALTH, health_pb2.HealthCheckRequest(service=service), timeout)
        return bool(response.status == health_pb2.HealthCheckResponse.SERVING)

    def close(self) -> None:
        """Closes the streams, whose unfinished frames end as CANCELLED, and the connections with all calls."""
        self._channels.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self.close()

    def _stream_one(self, call: SegmentCall, timeout: float | None) -> Result:
        limit = calls.checked_timeout(self._settings.timeout if timeout is None else timeout)
        with Stream(self._channels, call.stream_options(self._settings, limit), Encoding()) as stream:
            stream.send(call.payload, prompts=call.prompts, request_id=call.request_id, frame_id=call.frame_id,
                        stamp=call.stamp)
            outcome = stream.next()
            assert outcome is not None
            return outcome.get()

    def _call(self, method: Method, request: Any, timeout: float | None, traceparent: str | None = None) -> Any:
        """Makes a unary call, again and elsewhere while that may help."""
        deadline = time.monotonic() + calls.checked_timeout(self._settings.timeout if timeout is None else timeout)
        metadata = self._settings.metadata(traceparent)
        repetition = Repetition(self._settings, deadline)
        while True:
            attempt = repetition.next(time.monotonic())
            time.sleep(max(0.0, attempt.not_before - time.monotonic()))
            call = self._channels.get(attempt.address).unary_unary(method.path, method.serialize, method.parse)
            try:
                return call(request, timeout=deadline - time.monotonic(), metadata=metadata)
            except grpc.RpcError as error:
                address = self._settings.addresses[attempt.address]
                known = explained(unavailable_if_cancelled(of_rpc_error(error, address)), address, self._settings.tls)
                repetition.failed(attempt, known, time.monotonic())
