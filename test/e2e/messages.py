# SPDX-License-Identifier: Apache-2.0
"""Messages of protobuf by hand, as only a hostile client writes them."""

import struct

MIB = 1 << 20
OPEN = b"\x0a\x00"  # SegmentStreamRequest.open, an empty StreamOpen
UNKNOWN = b"\xa0\x06\x01"  # field 100, which no message has, is 1


def varint(value):
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes(out + bytes([value]))


def delimited(number, content):
    return varint(number << 3 | 2) + varint(len(content)) + content


def zstd_of_repeated(byte, count):
    """A frame of zstd (RFC 8878) that is four bytes for each 128 KiB of this byte."""
    blocks, block = [], 128 << 10
    for begin in range(0, count, block):
        size, is_last = min(block, count - begin), begin + block >= count
        blocks.append((size << 3 | 1 << 1 | is_last).to_bytes(3, "little") + byte)
    return b"\x28\xb5\x2f\xfd\xc0\x38" + struct.pack("<Q", count) + b"".join(blocks)


def file_request(content, decoded_bytes=None):
    """A SegmentRequest with a cloud in a PCD file, which is compressed by zstd if the size before that is given."""
    block = delimited(3, content)
    if decoded_bytes is not None:
        block = b"\x08\x02\x10" + varint(decoded_bytes) + block
    return delimited(16, delimited(17, delimited(1, block)))
