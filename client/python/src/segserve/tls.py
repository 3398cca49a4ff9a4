# SPDX-License-Identifier: Apache-2.0
"""Who the server is, and who the client is: TLS and bearer tokens."""
from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import grpc


@dataclass(frozen=True)
class Tls:
    """Connects by TLS. All files are PEM, and are read when a connection is made for the first time.

    `Tls()` believes the certificate authorities of this machine.
    """

    #: The certificates that are believed; None: those of this machine.
    ca: str | os.PathLike[str] | None = None
    #: The client's certificate, and its key, if the server asks for one (mutual TLS).
    cert: str | os.PathLike[str] | None = None
    key: str | os.PathLike[str] | None = None
    #: The name in the server's certificate, if it is not the one in the address.
    server_name: str | None = None

    def __post_init__(self) -> None:
        if (self.cert is None) != (self.key is None):
            raise ValueError("tls: cert and key go together")

    def credentials(self) -> Any:
        """gRPC's credentials. OSError if a file cannot be read."""
        return grpc.ssl_channel_credentials(root_certificates=_content(self.ca), private_key=_content(self.key),
                                            certificate_chain=_content(self.cert))


def _content(path: str | os.PathLike[str] | None) -> bytes | None:
    if path is None:
        return None
    with open(path, "rb") as file:
        return file.read()


class Token:
    """A bearer token, by itself or in a file that is read again when it changes."""

    def __init__(self, token: str | None, token_file: str | os.PathLike[str] | None) -> None:
        """ValueError if both are given, or the token is no line of visible ASCII. OSError if the file cannot be
        read."""
        if token is not None and token_file is not None:
            raise ValueError("token, token_file: one of them is enough")
        self._file = token_file
        self._stamp: tuple[int, int, int] | None = None
        self._token = None if token is None else _checked(token)
        self._read()

    def __bool__(self) -> bool:
        return self._token is not None

    def metadata(self) -> list[tuple[str, str]]:
        """The metadata of a call."""
        self._read()
        return [] if self._token is None else [("authorization", f"Bearer {self._token}")]

    def _read(self) -> None:
        if self._file is None:
            return
        try:
            state = os.stat(self._file)
            stamp = (state.st_mtime_ns, state.st_size, state.st_ino)
            if stamp == self._stamp:
                return
            with open(self._file, encoding="ascii") as file:
                self._token = _checked(file.read().strip())
            self._stamp = stamp
        except (OSError, ValueError):
            if self._token is None:
                raise
            # The file is being replaced: the token before it is good until the new one is there.


def _checked(token: str) -> str:
    if not token or not all("!" <= character <= "~" for character in token):
        raise ValueError("token: it must be one line of visible ASCII characters")  # which does not tell the token
    return token
