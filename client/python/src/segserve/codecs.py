# SPDX-License-Identifier: Apache-2.0
"""Encodes clouds: the codecs of core/codec/README.md that numpy can write."""
from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from segserve import zstd
from segserve.cloud import Cloud, as_cloud
from segserve.payload import Bytes, Payload, announce
from segserve.v1 import block_pb2, cloud_pb2
from segserve.view import View, ViewLike, as_view, view_message

UNITS = {
    "m": cloud_pb2.LENGTH_UNIT_METER,
    "cm": cloud_pb2.LENGTH_UNIT_CENTIMETER,
    "mm": cloud_pb2.LENGTH_UNIT_MILLIMETER,
    "in": cloud_pb2.LENGTH_UNIT_INCH,
    "ft": cloud_pb2.LENGTH_UNIT_FOOT,
    "auto": cloud_pb2.LENGTH_UNIT_AUTO
}
DEFAULT_ERROR_BOUND = 0.001  # meters
_ERROR_BOUNDS = (0.0001, 0.01)  # meters


def encode(points: Any, rgb: Any = None, *, view: ViewLike = None, codec: str | None = None,
           error_bound: float = DEFAULT_ERROR_BOUND, unit: str = "m") -> Payload:
    """Encodes a cloud of arrays; as_cloud says which are accepted.

    codec: "planar" or "planar-zstd" (a plane a coordinate), "strided" or "strided-zstd" (point by point), "pcd" (a PCD
    file), all of them lossless, or "quantised" (coordinates within `error_bound` meters, 0.0001 to 0.01; smallest).
    None takes "planar" if the view is given, and "pcd" if not, because the server chooses the view of a PCD file by its
    points. float64 coordinates far from 0 are sent as they are, which "strided" and "pcd" can.

    unit: of the coordinates: m, cm, mm, in, ft, or auto, which leaves it to the server.

    ValueError, TypeError: the arrays do not fit, or the codec cannot encode them. ImportError: Zstandard is missing.
    """
    return encode_cloud(as_cloud(points, rgb), as_view(view), codec, error_bound, unit)


def encode_cloud(cloud: Cloud, view: View | None, codec: str | None, error_bound: float = DEFAULT_ERROR_BOUND,
                 unit: str = "m") -> Payload:
    """Encodes a cloud that was checked."""
    is_far = cloud.xyz.dtype == np.float64
    if codec is None:
        codec = "pcd" if view is None else "strided" if is_far else "planar"
    encoder = _encoder(codec)
    if unit not in UNITS:
        raise ValueError(f"unit: there is no '{unit}'; there are {', '.join(UNITS)}")
    if view is None and codec != "pcd":
        raise ValueError(f"view: the codec '{codec}' needs it: 'camera', 'world' or 'world:X,Y,Z'; "
                         "without a codec, the server chooses the view")
    if is_far and codec in ("planar", "planar-zstd", "quantised"):
        raise ValueError(f"codec: '{codec}' has float32 coordinates, which are too coarse so far from 0; "
                         "'strided' and 'pcd' send float64")
    header = cloud_pb2.Cloud(width=cloud.width, height=cloud.height)
    if view is not None:
        header.view.CopyFrom(view_message(view))
    if unit != "m":
        header.unit = UNITS[unit]
    compress = codec.endswith("-zstd")
    if compress or codec == "quantised":
        zstd.need(f"the codec '{codec}'")
    blocks = encoder(cloud, header, compress, error_bound)
    points = cloud.width * cloud.height
    return Payload(header, tuple(blocks), cloud.shape, points, points * (12 if cloud.rgb is None else 15),
                   compress or codec == "quantised")


def pcd_file(content: bytes, *, view: ViewLike = None, unit: str = "m") -> Payload:
    """Sends the bytes of a PCD file as they are. `view` overrides that of the file. The server says if it is broken."""
    header = cloud_pb2.Cloud()
    chosen = as_view(view)
    if chosen is not None:
        header.view.CopyFrom(view_message(chosen))
    if unit not in UNITS:
        raise ValueError(f"unit: there is no '{unit}'; there are {', '.join(UNITS)}")
    if unit != "m":
        header.unit = UNITS[unit]
    return Payload(header, (announce(header.pcd_file.file, content),), None)


def _raw(array: npt.NDArray[Any]) -> memoryview:
    """The bytes of a contiguous array, without a copy."""
    return array.reshape(-1).view(np.uint8).data


def _planar(cloud: Cloud, header: cloud_pb2.Cloud, compress: bool, _: float) -> list[Bytes]:
    planar = header.planar
    planes = [(planar.x, cloud.xyz[:, 0]), (planar.y, cloud.xyz[:, 1]), (planar.z, cloud.xyz[:, 2])]
    blocks = [announce(block, _raw(plane.astype("<f4")), compress) for block, plane in planes]
    if cloud.rgb is not None:
        blocks.append(announce(header.planar.rgb, _raw(cloud.rgb.copy(order="C")), compress))
    return blocks


def _rows(cloud: Cloud) -> npt.NDArray[Any]:
    """The points as records of x, y, z and, if there are colors, rgb."""
    fields: list[tuple[str, str]] = [(name, cloud.xyz.dtype.str) for name in "xyz"]
    if cloud.rgb is not None:
        fields.append(("rgb", "<u4"))
    rows = np.empty(len(cloud.xyz), fields)
    for axis, name in enumerate("xyz"):
        rows[name] = cloud.xyz[:, axis]
    if cloud.rgb is not None:
        rows["rgb"] = cloud.packed_rgb
    return rows


def _strided(cloud: Cloud, header: cloud_pb2.Cloud, compress: bool, _: float) -> list[Bytes]:
    rows, strided = _rows(cloud), header.strided
    kind = cloud_pb2.POINT_DATATYPE_FLOAT32 if cloud.xyz.dtype == np.float32 else cloud_pb2.POINT_DATATYPE_FLOAT64
    offset = 0
    for name in rows.dtype.names or ():
        strided.fields.add(name=name, offset=offset, count=1,
                           datatype=cloud_pb2.POINT_DATATYPE_FLOAT32 if name == "rgb" else kind)
        offset += rows.dtype[name].itemsize
    strided.point_step = rows.dtype.itemsize
    strided.row_step = cloud.width * rows.dtype.itemsize
    return [announce(strided.data, _raw(rows), compress)]


def _pcd(cloud: Cloud, header: cloud_pb2.Cloud, _: bool, __: float) -> list[Bytes]:
    rows = _rows(cloud)
    names = rows.dtype.names or ()
    sizes = [str(rows.dtype[name].itemsize) for name in names]
    # PCL has the bits of a color in a float.
    text = (
        f"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {' '.join(names)}\nSIZE {' '.join(sizes)}\n"
        f"TYPE {' '.join('F' for _ in names)}\nCOUNT {' '.join('1' for _ in names)}\nWIDTH {cloud.width}\n"
        f"HEIGHT {cloud.height}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(rows)}\nDATA binary\n")
    return [announce(header.pcd_file.file, b"".join((text.encode(), _raw(rows))))]


def _quantised(cloud: Cloud, header: cloud_pb2.Cloud, _: bool, error_bound: float) -> list[Bytes]:
    low, high = _ERROR_BOUNDS
    if not low <= error_bound <= high:
        raise ValueError(f"error_bound: {error_bound} m is not in [{low}, {high}] m")
    header.error_bound = error_bound
    return [announce(header.quantised.data, quantised_bytes(cloud, error_bound))]


def quantised_bytes(cloud: Cloud, error_bound: float) -> bytes:
    """A cloud in the format of core/codec/quantised/FORMAT.md, with the cells that the C++ encoder chooses."""
    is_finite = np.isfinite(cloud.xyz).all(axis=1)
    xyz = cloud.xyz if is_finite.all() else cloud.xyz[is_finite]
    largest = float(np.abs(xyz).max()) if len(xyz) else 0.0
    rounding = (largest + error_bound) * 2.0**-23
    if rounding > error_bound / 2:
        raise ValueError(f"error_bound: coordinates of {largest:g} m cannot be kept within {error_bound} m as float32")
    step = 2 * (error_bound - rounding)
    body: list[Any] = [] if len(xyz) == len(is_finite) else [np.packbits(is_finite, bitorder="little")]
    plane_counts = [0, 0, 0]
    for axis in range(3 if len(xyz) else 0):
        cells = np.floor(xyz[:, axis].astype(np.float64) * (1 / step)).astype(np.int32)
        difference = np.diff(cells, prepend=np.int32(0))
        zigzag = (difference << 1 ^ difference >> 31).view(np.uint32)
        plane_counts[axis] = max(1, (int(np.bitwise_or.reduce(zigzag)).bit_length() + 7) // 8)
        body += [(zigzag >> 8 * plane).astype(np.uint8) for plane in range(plane_counts[axis])]
    if cloud.rgb is not None:
        rgb = cloud.rgb[is_finite]
        body += [np.diff(rgb[:, channel], prepend=np.uint8(0)) for channel in range(3)]
    head = struct.pack("<4sHBBIII4Bdd", b"SEGQ", 1, cloud.rgb is not None, 0, cloud.width, cloud.height, len(xyz),
                       *plane_counts, 0, step, error_bound)
    return head + zstd.compress(b"".join(plane.tobytes() for plane in body))


_Encoder = Callable[[Cloud, cloud_pb2.Cloud, bool, float], "list[Bytes]"]
_ENCODERS: dict[str, _Encoder] = {
    "planar": _planar,
    "planar-zstd": _planar,
    "strided": _strided,
    "strided-zstd": _strided,
    "pcd": _pcd,
    "quantised": _quantised
}
#: The names of the codecs.
CODECS = tuple(_ENCODERS)


def _encoder(codec: str) -> _Encoder:
    if codec == "rgbd":
        raise ValueError("codec: 'rgbd' is what segment_rgbd and encode_rgbd send")
    if codec not in _ENCODERS:
        raise ValueError(f"codec: there is no '{codec}'; there are {', '.join(CODECS)}")
    return _ENCODERS[codec]


def block_bytes(block: block_pb2.Block, expected: int, name: str) -> bytes:
    """The `expected` bytes of a block that came from a server. ValueError if it has others."""
    if block.encoded_bytes not in (0, len(block.data)):
        raise ValueError(f"{name}: claims {block.encoded_bytes} encoded bytes, but has {len(block.data)}")
    is_compressed = block.compression == block_pb2.COMPRESSION_ZSTD
    if (is_compressed or block.decoded_bytes) and block.decoded_bytes != expected:
        raise ValueError(f"{name}: claims {block.decoded_bytes} bytes, but must have {expected}")
    if is_compressed:
        zstd.need(f"{name}, which is compressed,")
        try:
            return zstd.decompress(block.data, expected)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    if block.compression not in (block_pb2.COMPRESSION_UNSPECIFIED, block_pb2.COMPRESSION_NONE):
        raise ValueError(f"{name}: compression {block.compression} is unknown")
    if len(block.data) != expected:
        raise ValueError(f"{name}: has {len(block.data)} bytes, but must have {expected}")
    return bytes(block.data)
