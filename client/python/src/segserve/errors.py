# SPDX-License-Identifier: Apache-2.0
"""The errors of calls and frames: one class for each status code, with the details that the server gave."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import grpc
from google.protobuf.message import DecodeError

from segserve.rpc import error_details_pb2, status_pb2


class FieldViolation(NamedTuple):
    """A wrong field of a request."""

    field: str  # its path, such as "options.lambda"
    description: str


class Error(Exception):
    """A call or a frame failed. The subclass tells the status code.

    Wrong arguments that this package itself notices are ValueError or TypeError, before anything is sent.
    """

    code: grpc.StatusCode = grpc.StatusCode.UNKNOWN

    def __init__(self, message: str, *, reason: str = "", metadata: Mapping[str, str] | None = None,
                 field_violations: Iterable[FieldViolation] = (), retry_delay: float | None = None) -> None:
        super().__init__(message)
        self.message = message
        #: Why it failed, as segserve.v1.ErrorReason names it, such as "QUEUE_FULL". Empty if no server said so.
        self.reason = reason
        #: Further facts by name, such as "limit", "allowed" and "actual".
        self.metadata = dict(metadata or {})
        #: Every wrong field of the request.
        self.field_violations = list(field_violations)
        #: How long to wait before the next attempt, seconds. None unless the server suggests it.
        self.retry_delay = retry_delay


class Cancelled(Error):
    """The caller cancelled it."""

    code = grpc.StatusCode.CANCELLED


class Unknown(Error):
    """The server gave no usable status."""

    code = grpc.StatusCode.UNKNOWN


class InvalidArgument(Error, ValueError):
    """The request, its payload or its cloud is wrong, or over a limit. `reason` and `field_violations` tell what."""

    code = grpc.StatusCode.INVALID_ARGUMENT


class DeadlineExceeded(Error):
    """The time was over."""

    code = grpc.StatusCode.DEADLINE_EXCEEDED


class NotFound(Error):
    """The server does not know what was asked for."""

    code = grpc.StatusCode.NOT_FOUND


class AlreadyExists(Error):
    code = grpc.StatusCode.ALREADY_EXISTS


class PermissionDenied(Error):
    """The token or certificate does not allow it."""

    code = grpc.StatusCode.PERMISSION_DENIED


class ResourceExhausted(Error):
    """The server is full or the frame too large for it, or too many frames wait here."""

    code = grpc.StatusCode.RESOURCE_EXHAUSTED


class FailedPrecondition(Error):
    """The call does not fit the state, such as send() after finish()."""

    code = grpc.StatusCode.FAILED_PRECONDITION


class Aborted(Error):
    """Bytes arrived damaged."""

    code = grpc.StatusCode.ABORTED


class OutOfRange(Error):
    code = grpc.StatusCode.OUT_OF_RANGE


class Unimplemented(Error):
    """The server does not have this call."""

    code = grpc.StatusCode.UNIMPLEMENTED


class Internal(Error):
    """The server has a fault, or its answer is broken."""

    code = grpc.StatusCode.INTERNAL


class Unavailable(Error):
    """No server is in reach, or it is about to stop."""

    code = grpc.StatusCode.UNAVAILABLE


class OutageError(Unavailable):
    """No server has been in reach for the `longest_outage` of a stream."""


class TlsError(Unavailable):
    """A certificate is not believed, or one side does not speak TLS. Asking the same server again is in vain."""


class DataLoss(Error):
    code = grpc.StatusCode.DATA_LOSS


class Unauthenticated(Error):
    """The token or certificate is missing, wrong or expired."""

    code = grpc.StatusCode.UNAUTHENTICATED


_CLASSES: dict[grpc.StatusCode, type[Error]] = {
    kind.code: kind for kind in (Cancelled, Unknown, InvalidArgument, DeadlineExceeded, NotFound, AlreadyExists,
                                 PermissionDenied, ResourceExhausted, FailedPrecondition, Aborted, OutOfRange,
                                 Unimplemented, Internal, Unavailable, DataLoss, Unauthenticated)
}
_CODES = {code.value[0]: code for code in grpc.StatusCode}
_LONGEST_DELAY = 86400.0  # seconds; a server that asks for more is not believed


def _details(status: status_pb2.Status) -> dict[str, Any]:
    """The arguments of Error that the details of a google.rpc.Status give. Damaged and unknown details are skipped."""
    found: dict[str, Any] = {}
    for entry in status.details:
        name = entry.type_url.rpartition("/")[2]
        try:
            if name == "google.rpc.ErrorInfo":
                info = error_details_pb2.ErrorInfo.FromString(entry.value)
                found["reason"], found["metadata"] = info.reason, dict(info.metadata)
            elif name == "google.rpc.BadRequest":
                faults = error_details_pb2.BadRequest.FromString(entry.value).field_violations
                found["field_violations"] = [FieldViolation(fault.field, fault.description) for fault in faults]
            elif name == "google.rpc.RetryInfo":
                delay = error_details_pb2.RetryInfo.FromString(entry.value).retry_delay
                seconds = delay.seconds + delay.nanos / 1e9
                if 0 <= seconds <= _LONGEST_DELAY:
                    found["retry_delay"] = seconds
        except DecodeError:
            continue
    return found


def _readable(message: str, details: dict[str, Any]) -> str:
    """The message with every wrong field, and the time to wait, for people."""
    for fault in details.get("field_violations", ()):
        if fault.field not in message:
            message += f"; {fault.field}: {fault.description}"
    if "retry_delay" in details:
        message += f" (try again in {details['retry_delay'] * 1000:.0f} ms)"
    return message


def from_status(status: status_pb2.Status) -> Error:
    """The error that a google.rpc.Status tells."""
    details = _details(status)
    kind = _CLASSES.get(_CODES.get(status.code, grpc.StatusCode.UNKNOWN), Unknown)
    return kind(_readable(status.message, details), **details)


def from_rpc(code: grpc.StatusCode, message: str | None, trailers: Any, address: str) -> Error:
    """The error of a call to `address` that ended with `code`."""
    status = status_pb2.Status(code=code.value[0], message=message or "")
    for key, value in trailers or ():
        if key == "grpc-status-details-bin":
            try:
                status.details.extend(status_pb2.Status.FromString(value).details)
            except DecodeError:
                break
    details = _details(status)
    text = status.message
    if code in (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.DEADLINE_EXCEEDED) and not details.get("reason"):
        text = f"no answer from {address}: {_cause(text)}"
        if code is grpc.StatusCode.UNAVAILABLE:
            text += "; is segserve running there?"
    return _CLASSES.get(code, Unknown)(_readable(text, details), **details)


def _cause(message: str) -> str:
    """The cause of a failed connection, without the names of gRPC's parts around it."""
    wordy = ("connections to all backends failing", "failed to connect to all addresses", "DNS resolution failed")
    return message.rpartition(": ")[2] if message.startswith(wordy) else message


def of_rpc_error(error: Any, address: str) -> Error:
    """The error that gRPC raised during a call to `address`."""
    return from_rpc(error.code(), error.details(), error.trailing_metadata(), address)


def is_retryable(error: Error) -> bool:
    """Whether another try may succeed. CANCELLED counts, because servers that shut down end calls so."""
    if isinstance(error, ResourceExhausted):
        return error.reason != "LIMIT_EXCEEDED"  # a frame beyond a limit never fits
    if isinstance(error, DeadlineExceeded):
        return error.reason == "UPLOAD_STALLED"
    return isinstance(error, (Unavailable, Aborted, Cancelled))


def is_worth_reconnecting(error: Error) -> bool:
    """Whether a stream that ended so may do better on another connection. False for errors that every server would
    repeat."""
    return not isinstance(error,
                          (InvalidArgument, FailedPrecondition, Unimplemented, Unauthenticated, PermissionDenied))


def unavailable_if_cancelled(error: Error) -> Error:
    """Replaces CANCELLED, with which servers that shut down end calls, for calls that this client did not cancel."""
    return Unavailable("the server ended the call") if isinstance(error, Cancelled) else error
