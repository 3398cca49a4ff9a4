# SPDX-License-Identifier: Apache-2.0
"""Writes the PNG images that the tests need."""
import struct
import zlib


def _chunk(kind, content):
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def _file(width, height, depth, color_type, rows):
    header = struct.pack(">IIBBBBB", width, height, depth, color_type, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) +
            _chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows))) + _chunk(b"IEND", b""))


def gray16(width, height, values):
    rows = [struct.pack(f">{width}H", *values[row * width:(row + 1) * width]) for row in range(height)]
    return _file(width, height, 16, 0, rows)


def rgb8(width, height, colors):
    """Colors as 0xRRGGBB."""
    rows = [b"".join(color.to_bytes(3, "big") for color in colors[row * width:(row + 1) * width]) for row in range(height)]
    return _file(width, height, 8, 2, rows)
