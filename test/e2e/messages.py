# SPDX-License-Identifier: Apache-2.0
"""Messages of protobuf by hand, as only a hostile client writes them."""

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
