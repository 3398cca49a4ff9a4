# SPDX-License-Identifier: Apache-2.0
"""Finds out why a connection failed that has to do with TLS, which gRPC hardly tells."""
from __future__ import annotations

import re
import socket
import ssl

from segserve.errors import Error, TlsError, Unavailable
from segserve.tls import Tls

_PATIENCE = 2.0  # seconds for one handshake
_ADDRESS = re.compile(r"(?:\[(?P<ipv6>[^\]]+)\]|(?P<host>[^:/]+)):(?P<port>\d+)")
_NOT_TLS = ("WRONG_VERSION_NUMBER", "RECORD_LAYER_FAILURE", "UNEXPECTED_EOF_WHILE_READING", "PACKET_LENGTH_TOO_LONG",
            "HTTP_REQUEST")


def explained(error: Error, address: str, tls: Tls | None) -> Error:
    """The error of a call to `address`, or a TlsError that tells the cause, if TLS is the cause. Takes some seconds at
    most."""
    if not isinstance(error, Unavailable) or error.reason or "refused" in error.message:
        return error
    found = _ADDRESS.fullmatch(address)
    if found is None:
        return error
    host, port = found["ipv6"] or found["host"], int(found["port"])
    fault = _speaks_tls(host, port) if tls is None else _handshake_fault(host, port, tls)
    return error if fault is None else TlsError(f"{address}: {fault}")


def _handshake_fault(host: str, port: int, tls: Tls) -> str | None:
    """What is wrong with a handshake as gRPC makes it; None if it succeeds or nobody listens."""
    try:
        context = ssl.create_default_context(cafile=tls.ca)
        if tls.cert is not None:
            context.load_cert_chain(tls.cert, tls.key)
    except (OSError, ssl.SSLError) as error:
        return f"the files of TLS cannot be used: {error}"
    refusal = "it asks for a certificate" if tls.cert is None else "it does not believe the client's certificate"
    try:
        is_over = _shake_hands(host, port, context, tls.server_name or host)
    except ssl.SSLCertVerificationError as error:
        return f"the certificate of the server is not believed: {error.verify_message}"
    except ssl.SSLError as error:
        if error.reason in _NOT_TLS:
            return "the server does not speak TLS"
        if "CERTIFICATE" in (error.reason or "") or "CA" in (error.reason or "").split("_"):
            return f"the server refuses the client: {refusal}"
        return f"the server refuses the handshake: {(error.reason or str(error)).lower().replace('_', ' ')}"
    except OSError:
        return None
    return f"the server refuses the client: {refusal}" if is_over else None


def _speaks_tls(host: str, port: int) -> str | None:
    context = ssl.create_default_context()
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    try:
        _shake_hands(host, port, context, host)
    except ssl.SSLError as error:
        if error.reason in _NOT_TLS:
            return None  # and an alert, such as one that asks for a certificate, is TLS, too
    except OSError:
        return None
    return "the server speaks TLS, and the client does not: use tls=segserve.Tls(..)"


def _shake_hands(host: str, port: int, context: ssl.SSLContext, server_name: str) -> bool:
    """Whether the server ended the connection at once after the handshake, as one of gRPC does that refuses a client of
    TLS 1.3."""
    context.set_alpn_protocols(["h2"])
    with socket.create_connection((host, port), timeout=_PATIENCE) as plain:
        with context.wrap_socket(plain, server_hostname=server_name) as connection:
            return connection.recv(1) == b""  # A server that is content begins with its settings.
