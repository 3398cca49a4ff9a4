# SPDX-License-Identifier: Apache-2.0
"""The file in which segctl keeps a result: client/include/segserve/client/result_file.hpp documents it."""
from __future__ import annotations

import re
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt
from google.protobuf.message import DecodeError

from segserve import zstd
from segserve.cloud import Cloud, as_cloud
from segserve.payload import announce
from segserve.result import Result
from segserve.result_message import read
from segserve.v1 import block_pb2, result_pb2, segmentation_service_pb2

_LINE = re.compile(rb"segserve-result (?:2 (\d+) ([0-9a-f]{8})|3 (\d+) ([0-9a-f]{8}) [0-9a-f]{8} [0-9a-f]{8})\n")
_LONGEST_LINE = 64


def fingerprint(cloud: Cloud) -> tuple[int, int]:
    """The CRC-32 of the coordinates and of the colors of a cloud, by which segctl knows it again."""
    words = cloud.xyz.astype("<f4").view("<u4")
    finite = np.isfinite(cloud.xyz).all(axis=1)
    words[~finite] = 0x7FC00000
    colors = 0 if cloud.rgb is None else zlib.crc32(cloud.packed_rgb.astype("<u4").tobytes())
    return zlib.crc32(words.tobytes()), colors


def encode(result: Result, points: Any = None, rgb: Any = None) -> bytes:
    """The bytes of the file. ValueError unless the result has labels, supervoxels and tree."""
    if result.labels is None or result.supervoxels is None or result.tree is None:
        raise ValueError("save: the outputs 'labels', 'supervoxels' and 'tree' are needed, which were not asked for")
    response = segmentation_service_pb2.SegmentResponse()
    message = response.result
    message.summary.CopyFrom(result.summary)
    _write(message.labels, result.labels)
    _write(message.supervoxels, result.supervoxels)
    _write(message.tree.leaf_points, result.tree.leaf_points)
    _write(message.tree.left, result.tree.left)
    _write(message.tree.right, result.tree.right)
    _write_block(message.tree.weight, result.tree.weight.astype("<f8").tobytes())
    message.tree.merged_rows = result.tree.merged_rows
    rows: Any = () if result.segments is None else result.segments
    for row in rows:
        _write_segment(message.segments.add(), row)
    payload = response.SerializeToString()
    head = f"{len(payload)} {zlib.crc32(payload):08x}"
    if points is None:
        return f"segserve-result 2 {head}\n".encode() + payload
    coordinates, colors = fingerprint(as_cloud(points, rgb))
    return f"segserve-result 3 {head} {coordinates:08x} {colors:08x}\n".encode() + payload


def decode(content: bytes) -> Result:
    """The result in such a file. ValueError if it is foreign, truncated or damaged."""
    if not content.startswith(b"segserve-result "):
        raise ValueError("this is not a result that segctl saved")
    line = _LINE.match(content[:_LONGEST_LINE])
    if line is None:
        raise ValueError("the first line of the saved result is damaged, or of another version")
    payload = content[line.end():]
    if len(payload) != int(line[1] or line[3]):
        raise ValueError(
            f"the saved result has {len(payload)} bytes after its first line instead of {int(line[1] or line[3])}")
    if zlib.crc32(payload) != int(line[2] or line[4], 16):
        raise ValueError("the saved result is damaged: its checksum differs")
    try:
        response = segmentation_service_pb2.SegmentResponse.FromString(payload)
    except DecodeError:
        raise ValueError("the saved result is damaged: it does not hold a SegmentResponse") from None
    try:
        return read(response.result, None, ("supervoxels", "tree"))
    except ValueError as error:
        raise ValueError(f"the saved result is damaged: {error}") from None


def _write(message: result_pb2.IntegerArray, values: npt.NDArray[np.uint32]) -> None:
    largest = int(values.max()) if values.size else 0
    message.count = values.size
    message.bytes_per_value = 1 if largest < 1 << 8 else 2 if largest < 1 << 16 else 4
    _write_block(message.data, values.astype(f"<u{message.bytes_per_value}").tobytes())


def _write_block(block: block_pb2.Block, data: bytes) -> None:
    block.data = bytes(announce(block, data, compress=zstd.is_there()))


def _write_segment(message: Any, row: Any) -> None:
    def put(vector: Any, values: Any) -> None:
        vector.x, vector.y, vector.z = values.tolist()

    message.points = int(row["points"])
    put(message.centroid, row["centroid"])
    put(message.box.center, row["box_center"])
    for axis in row["box_axes"]:
        put(message.box.axes.add(), axis)
    put(message.box.half_extents, row["box_half_extents"])
    if not np.isnan(row["color"]).any():
        message.color.red, message.color.green, message.color.blue = row["color"].tolist()
    if not np.isnan(row["normal"]).any():
        put(message.normal, row["normal"])
    if not np.isnan(row["thresholds"]).any():
        message.thresholds.lower, message.thresholds.upper = row["thresholds"].tolist()
