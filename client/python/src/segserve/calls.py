# SPDX-License-Identifier: Apache-2.0
"""What the clients of both kinds, blocking and asyncio, have in common: everything but the waiting."""
from __future__ import annotations

import datetime
import itertools
import json
import os
import re
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any, NamedTuple

from segserve import result_message
from segserve.errors import Error, TlsError, is_retryable
from segserve.options import outputs_message
from segserve.payload import Payload
from segserve.result import Result
from segserve.rpc import health_pb2
from segserve.selection import Prompts
from segserve.tls import Tls, Token
from segserve.tracking import Tracking
from segserve.v1 import options_pb2, segmentation_service_pb2, stream_pb2
from segserve._stream.address_book import AddressBook, Retry, is_loopback, parse_addresses
from segserve._stream.frame import Order, StreamOptions, WhenBehind
from segserve._stream.messages import timestamp

#: The largest size of a serialized request, bytes. Larger clouds go by a stream.
MOST_REQUEST_BYTES = 8 << 20
_MOST_RECEIVED_BYTES = 64 << 20
_FLOW_CONTROL_BYTES = 4 << 20
_TRACEPARENT = re.compile(r"[0-9a-f]{2}-[0-9a-f]{32}-[0-9a-f]{16}-[0-9a-f]{2}")


class Method(NamedTuple):
    """A call: its path, and how its messages become bytes and back."""

    path: str
    serialize: Any
    parse: Any


_SERVICE = "/segserve.v1.SegmentationService/"
SEGMENT = Method(_SERVICE + "Segment", segmentation_service_pb2.SegmentRequest.SerializeToString,
                 segmentation_service_pb2.SegmentResponse.FromString)
SERVER_INFO = Method(_SERVICE + "GetServerInfo", segmentation_service_pb2.GetServerInfoRequest.SerializeToString,
                     segmentation_service_pb2.GetServerInfoResponse.FromString)
HEALTH = Method("/grpc.health.v1.Health/Check", health_pb2.HealthCheckRequest.SerializeToString,
                health_pb2.HealthCheckResponse.FromString)
#: Its requests are serialized already.
STREAM = Method(_SERVICE + "SegmentStream", None, stream_pb2.SegmentStreamResponse.FromString)


class Settings:
    """Where the servers are, and how they are reached."""

    def __init__(self, address: str, *, token: str | None, token_file: str | os.PathLike[str] | None, tls: Tls | None,
                 timeout: float, wait_for_server: bool, retry: Retry | None, use_proxy: bool,
                 unprotected_token: bool) -> None:
        """ValueError for settings that make no sense. OSError if a file cannot be read."""
        self.addresses = parse_addresses(address)
        self.timeout = checked_timeout(timeout)
        self.wait_for_server = wait_for_server
        self.retry = retry or Retry()
        self.tls = tls
        self._use_proxy = use_proxy
        self._token = Token(token, token_file)
        self._starts = itertools.count()
        if tls is not None:
            tls.credentials()  # so that files that cannot be read are noticed here
        elif self._token and not unprotected_token:
            for name in self.addresses:
                if not is_loopback(name):
                    raise ValueError(f"token: it would cross the network to {name} for everyone to read; use tls, or "
                                     "unprotected_token=True if the network itself is trusted")

    def next_start(self) -> int:
        """The address at which the next call or stream begins."""
        return next(self._starts)

    def metadata(self, traceparent: str | None = None) -> list[tuple[str, str]]:
        """The metadata of a call. ValueError if `traceparent` is none of the W3C's."""
        entries = self._token.metadata()
        if traceparent is not None:
            if not _TRACEPARENT.fullmatch(traceparent):
                raise ValueError(
                    f"traceparent: '{traceparent}' is not VERSION-TRACE-PARENT-FLAGS in hexadecimal digits")
            entries.append(("traceparent", traceparent))
        return entries

    def channel_options(self, address: str) -> list[tuple[str, Any]]:
        """The arguments of a channel of gRPC. Calls are repeated by this package, which must not wait for a backoff of
        gRPC's."""
        options: list[tuple[str, Any]] = [
            ("grpc.enable_http_proxy", int(self._use_proxy and not is_loopback(address))),
            ("grpc.max_receive_message_length", _MOST_RECEIVED_BYTES),
            ("grpc.max_send_message_length", -1),
            ("grpc.use_local_subchannel_pool", 1),
            ("grpc.http2.bdp_probe", 0),
            ("grpc.http2.lookahead_bytes", _FLOW_CONTROL_BYTES),
            ("grpc.initial_reconnect_backoff_ms", 100),
            ("grpc.min_reconnect_backoff_ms", 2000),
            ("grpc.max_reconnect_backoff_ms", 2000),
            ("grpc.service_config", json.dumps({"loadBalancingConfig": [{"round_robin": {}}]}))]
        if self.tls is not None and self.tls.server_name is not None:
            options.append(("grpc.ssl_target_name_override", self.tls.server_name))
        return options


def checked_timeout(timeout: float) -> float:
    if not timeout > 0:
        raise ValueError(f"timeout: {timeout} s is not above 0")
    return timeout


class Attempt(NamedTuple):
    address: int
    not_before: float


class Repetition:
    """Decides where and when a unary call is tried next. Knows no clock: times are handed in, seconds."""

    def __init__(self, settings: Settings, deadline: float, seed: int | None = None) -> None:
        self._settings = settings
        self._book = AddressBook(len(settings.addresses), settings.next_start(), settings.retry, seed)
        self._deadline = deadline
        self._tries = 0
        self._error: Error | None = None

    def next(self, now: float) -> Attempt:
        """The next attempt. Raises the last error if there is none."""
        if self._error is not None and not self._is_worth_another(self._error):
            raise self._error
        choice = self._book.choose(now)
        if self._error is not None and choice.not_before >= self._deadline:
            raise self._error
        self._tries += 1
        return Attempt(choice.address, choice.not_before)

    def failed(self, attempt: Attempt, error: Error, now: float) -> None:
        self._error = error
        self._book.failed(attempt.address, now, error.retry_delay)

    def _is_worth_another(self, error: Error) -> bool:
        if not is_retryable(error):
            return False
        if isinstance(error, TlsError):
            return not self._book.nobody_in_reach()
        if error.reason:  # a server said so
            return self._tries < self._settings.retry.max_attempts
        return self._settings.wait_for_server or not self._book.nobody_in_reach()


@dataclass(frozen=True)
class SegmentCall:
    """A cloud with everything that belongs to its segmentation."""

    payload: Payload
    options: options_pb2.SegmentOptions
    outputs: Collection[str]
    prompts: Prompts | None = None
    request_id: str = ""
    frame_id: str = ""
    stamp: datetime.datetime | None = None
    tracking: Tracking | None = None

    def request(self) -> segmentation_service_pb2.SegmentRequest | None:
        """The request; None if it is too large for one message."""
        if self.payload.size > MOST_REQUEST_BYTES:
            return None
        request = segmentation_service_pb2.SegmentRequest(
            request_id=self.request_id, frame_id=self.frame_id, cloud=self.payload.message(), options=self.options,
            outputs=outputs_message(self.outputs, self.payload.compressed))
        if self.prompts is not None:
            request.prompts.CopyFrom(self.prompts.message())
        if self.stamp is not None:
            request.stamp.CopyFrom(timestamp(self.stamp))
        if self.tracking is not None:
            request.tracking.CopyFrom(self.tracking.message())
        return request if request.ByteSize() <= MOST_REQUEST_BYTES else None

    def result(self, response: segmentation_service_pb2.SegmentResponse) -> Result:
        """The result in an answer. Internal if it is broken."""
        return result_message.decode(response.result, self.payload.shape, self.outputs, self.request_id, self.frame_id,
                             self.stamp, wants_tracks=self.tracking is not None)

    def stream_options(self, settings: Settings, timeout: float) -> StreamOptions:
        """The rules of a stream for this cloud alone."""
        return StreamOptions(options=self.options,
                             outputs=self.outputs,
                             tracking=self.tracking,
                             max_in_flight=1,
                             wanted_bytes=self.payload.size,
                             frame_timeout=timeout,
                             retry=settings.retry,
                             wait_for_server=settings.wait_for_server)


def stream_rules(options: options_pb2.SegmentOptions, rules: dict[str, Any]) -> StreamOptions:
    """The rules of a stream by the names of StreamOptions. Enums may be given by their values. ValueError,
    TypeError."""
    given = dict(rules)
    for name, kind in (("order", Order), ("when_behind", WhenBehind)):
        if isinstance(given.get(name), str):
            given[name] = _enum(kind, name, given[name])
    if isinstance(given.get("outputs"), str):
        given["outputs"] = (given["outputs"],)
    if "outputs" in given:
        outputs_message(given["outputs"], False)  # so that wrong names are noticed here
    return StreamOptions(options=options, **given)


def _enum(kind: Any, name: str, value: str) -> Any:
    try:
        return kind(value.lower())
    except ValueError:
        raise ValueError(
            f"{name}: there is no '{value}'; there are {', '.join(entry.value for entry in kind)}") from None
