# SPDX-License-Identifier: Apache-2.0
"""A cloud as it goes over the wire."""
from __future__ import annotations

import functools
import zlib
from dataclasses import dataclass
from typing import Union

from segserve import zstd
from segserve.v1 import block_pb2, cloud_pb2

Bytes = Union[bytes, memoryview]


@dataclass(frozen=True, eq=False)
class Payload:
    """A cloud that is encoded once and sent any number of times. `segserve.encode` and its sisters make payloads.

    The arrays that it was made of may change afterwards.
    """

    #: The cloud without the bytes of its blocks.
    header: cloud_pb2.Cloud
    #: The bytes of the blocks, in the order in which cloud.proto declares them.
    blocks: tuple[Bytes, ...]
    #: The shape of the labels; None if only the server knows the number of points.
    shape: tuple[int, ...] | None
    #: The number of points; 0 if only the server knows it.
    points: int = 0
    #: The size of the cloud after decompression, bytes; 0 if only the server knows it.
    decoded_bytes: int = 0
    #: Whether the answer may be compressed, too.
    compressed: bool = False

    @functools.cached_property
    def size(self) -> int:
        """The size of all blocks, bytes."""
        return sum(len(block) for block in self.blocks)

    @functools.cached_property
    def crc32(self) -> int:
        """The CRC-32 of all blocks, one after the other."""
        crc = 0
        for block in self.blocks:
            crc = zlib.crc32(block, crc)
        return crc

    def message(self) -> cloud_pb2.Cloud:
        """The cloud with the bytes of its blocks."""
        message = cloud_pb2.Cloud()
        message.CopyFrom(self.header)
        for block, data in zip(blocks_of(message), self.blocks):
            block.data = bytes(data)
        return message


#: The blocks of each kind of payload, in the order in which they are sent.
_BLOCKS = {"planar": ("x", "y", "z", "rgb"), "pcd_file": ("file",), "strided": ("data",), "quantised": ("data",),
           "rgbd": ("depth", "color")}


def blocks_of(message: cloud_pb2.Cloud) -> list[block_pb2.Block]:
    """The blocks that a cloud has."""
    kind = message.WhichOneof("payload")
    payload = getattr(message, kind)
    return [getattr(payload, name) for name in _BLOCKS[kind] if payload.HasField(name)]


def announce(block: block_pb2.Block, data: Bytes, compress: bool = False) -> Bytes:
    """Writes sizes and compression to a block whose bytes will follow. Returns these bytes."""
    block.compression = block_pb2.COMPRESSION_NONE
    block.decoded_bytes = len(data)
    if compress:
        compressed = zstd.compress(data)
        if len(compressed) < len(data):
            block.compression = block_pb2.COMPRESSION_ZSTD
            data = compressed
    block.encoded_bytes = len(data)
    return data
