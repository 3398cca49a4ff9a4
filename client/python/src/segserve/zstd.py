# SPDX-License-Identifier: Apache-2.0
"""Zstandard, which is optional: Debian's python3-zstandard, or `pip install segserve[zstd]`."""
from __future__ import annotations

from typing import Any

zstandard: Any
try:
    import zstandard
except ImportError:
    zstandard = None

_LEVEL = 1  # saves time on links of 100 Mbit/s and below


def is_there() -> bool:
    return zstandard is not None


def need(what: str) -> None:
    """ImportError, which says what needs it, if it is not installed."""
    if zstandard is None:
        raise ImportError(f"{what} needs the package zstandard (Debian: python3-zstandard; pip: segserve[zstd])")


def compress(data: Any) -> bytes:
    return bytes(zstandard.ZstdCompressor(level=_LEVEL).compress(data))


def decompress(data: bytes, size: int) -> bytes:
    """The `size` bytes of one frame. ValueError if it is none, or has another size."""
    try:
        declared = zstandard.frame_content_size(data)
        if declared not in (-1, size):
            raise ValueError(f"the frame declares {declared} bytes, not the claimed {size}")
        decoded = zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
    except zstandard.ZstdError as error:
        raise ValueError(str(error)) from None
    if len(decoded) != size:
        raise ValueError(f"the frame decodes to {len(decoded)} bytes, not the claimed {size}")
    return bytes(decoded)
