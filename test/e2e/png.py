# SPDX-License-Identifier: Apache-2.0
"""Writes and reads the PNG images that the tests need."""
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


def read_rgb8(content):
    """Width, height and rows of (red, green, blue) of an image with 8 bits a channel and no transparency."""
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    width, height, depth, color_type = struct.unpack(">IIBB", content[16:26])
    assert (depth, color_type) == (8, 2)
    at, packed = 8, b""
    while at < len(content):
        length, kind = struct.unpack(">I4s", content[at:at + 8])
        if kind == b"IDAT":
            packed += content[at + 8:at + 8 + length]
        at += 12 + length
    data, rows, above = zlib.decompress(packed), [], bytearray(3 * width)
    for y in range(height):
        line = data[y * (3 * width + 1):(y + 1) * (3 * width + 1)]
        above = _unfilter(line[0], bytearray(line[1:]), above)
        rows.append([tuple(above[3 * x:3 * x + 3]) for x in range(width)])
    return width, height, rows


def _unfilter(kind, row, above):
    """A row of 3 bytes a pixel as it was before PNG's filter of this kind."""
    for i, value in enumerate(row):
        a, b, c = (row[i - 3], above[i], above[i - 3]) if i >= 3 else (0, above[i], 0)
        nearest = min((a, b, c), key=lambda v: abs(a + b - c - v))
        row[i] = (value + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
    return row
