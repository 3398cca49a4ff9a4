# SPDX-License-Identifier: Apache-2.0
"""Encodes the images of an RGB-D camera."""
from __future__ import annotations

import re
import struct
import zlib
from typing import Any, NamedTuple, Union

import numpy as np
import numpy.typing as npt

from segserve.payload import Bytes, Payload, announce
from segserve.v1 import cloud_pb2
from segserve.view import View, view_message

_MILLIMETER = 0.001


class Intrinsics(NamedTuple):
    """A pinhole camera without distortion, pixels. The center of the first pixel is (0, 0)."""

    fx: float
    fy: float
    cx: float
    cy: float


#: An image as an array, or the bytes of a file.
Image = Union["npt.NDArray[Any]", bytes]


def as_intrinsics(intrinsics: Any) -> Intrinsics:
    """Takes Intrinsics, four numbers fx, fy, cx, cy, or a camera matrix (3, 3). ValueError if it is none of them."""
    numbers = np.asarray(intrinsics, dtype=np.float64)
    if numbers.shape == (3, 3):
        numbers = np.array([numbers[0, 0], numbers[1, 1], numbers[0, 2], numbers[1, 2]])
    if numbers.shape != (4,):
        raise ValueError(f"intrinsics: fx, fy, cx, cy or a 3 x 3 matrix is needed, not the shape {numbers.shape}")
    found = Intrinsics(*numbers.tolist())
    if not np.isfinite(numbers).all() or found.fx <= 0 or found.fy <= 0:
        raise ValueError(f"intrinsics: {found} are not finite with fx and fy above 0")
    return found


def encode_rgbd(depth: Image, color: Image | None, intrinsics: Any, *, depth_scale: float | None = None,
                color_intrinsics: Any = None, images: str = "raw") -> Payload:
    """Encodes the images of an RGB-D camera, which make a cloud of the depth's rows and columns in the view of a
    camera.

    depth: (H, W), uint16 or float; or the bytes of a PNG, PGM or PFM file. 0, 65535 and NaN mean "no depth".
    depth_scale: meters per unit of depth, at most 1; by default 0.001 for integers, and 1 for floats.
    color: (H, W, 3) or gray (H, W), uint8, seen from the place of the depth; or the bytes of a PNG, JPEG, PPM or PGM
    file. Its size may be another than that of the depth.
    color_intrinsics: those of the color, if both images do not show the same part of the scene.
    images: how arrays are sent: "raw", or "png", which takes less of the network and more time.
    """
    if images not in ("raw", "png"):
        raise ValueError(f"images: '{images}' is neither 'raw' nor 'png'")
    camera = as_intrinsics(intrinsics)
    depth_file, default_scale = _depth_file(depth, images == "png")
    shape = _shape_of_file(depth_file)
    header = cloud_pb2.Cloud(view=view_message(View("camera")))
    if shape is not None:
        header.height, header.width = shape
    blocks: list[Bytes] = [announce(header.rgbd.depth, depth_file)]
    if color is not None:
        blocks.append(announce(header.rgbd.color, _color_file(color, images == "png")))
    header.rgbd.depth_scale = default_scale if depth_scale is None else depth_scale
    header.rgbd.fx, header.rgbd.fy, header.rgbd.cx, header.rgbd.cy = camera
    if color_intrinsics is not None:
        into = header.rgbd.color_intrinsics
        into.fx, into.fy, into.cx, into.cy = as_intrinsics(color_intrinsics)
    return Payload(header, tuple(blocks), shape, shape[0] * shape[1] if shape else 0)


def _depth_file(depth: Image, as_png: bool) -> tuple[bytes, float]:
    """The file of a depth image, and its usual meters per unit."""
    if isinstance(depth, (bytes, bytearray, memoryview)):
        content = bytes(depth)
        return content, 1.0 if content.startswith(b"Pf") else _MILLIMETER
    pixels = np.asarray(depth)
    if pixels.ndim != 2 or pixels.size == 0:
        raise ValueError(f"depth: the shape is {pixels.shape}, but must be (H, W)")
    if pixels.dtype == np.uint16:
        return (_png(pixels) if as_png else _pnm(pixels)), _MILLIMETER
    if pixels.dtype in (np.float32, np.float64):  # PFM has the last row first.
        head = f"Pf\n{pixels.shape[1]} {pixels.shape[0]}\n-1.0\n".encode()
        return head + np.ascontiguousarray(pixels[::-1], dtype="<f4").tobytes(), 1.0
    raise TypeError(f"depth: the type is {pixels.dtype}, but must be uint16 or a float")


def _color_file(color: Image, as_png: bool) -> bytes:
    if isinstance(color, (bytes, bytearray, memoryview)):
        return bytes(color)
    pixels = np.asarray(color)
    if pixels.dtype != np.uint8:
        raise TypeError(f"color: the type is {pixels.dtype}, but must be uint8")
    if pixels.size == 0 or not (pixels.ndim == 2 or (pixels.ndim == 3 and pixels.shape[2] == 3)):
        raise ValueError(f"color: the shape is {pixels.shape}, but must be (H, W, 3), or (H, W) for gray")
    return _png(pixels) if as_png else _pnm(pixels)


def _pnm(pixels: npt.NDArray[Any]) -> bytes:
    """A PGM or PPM file."""
    kind = "P6" if pixels.ndim == 3 else "P5"
    head = f"{kind}\n{pixels.shape[1]} {pixels.shape[0]}\n{np.iinfo(pixels.dtype).max}\n".encode()
    return head + pixels.astype(pixels.dtype.newbyteorder(">")).tobytes()


def _png(pixels: npt.NDArray[Any]) -> bytes:
    """A PNG file: gray with 16 or 8 bits, or RGB. Every row is stored as its difference from the row above."""
    height, width = pixels.shape[:2]
    rows = pixels.astype(pixels.dtype.newbyteorder(">")).reshape(height, -1).view(np.uint8)
    filtered = np.empty((height, rows.shape[1] + 1), np.uint8)
    filtered[:, 0] = 2  # the filter "up"
    filtered[0, 1:] = rows[0]
    filtered[1:, 1:] = rows[1:] - rows[:-1]

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", width, height, 8 * pixels.dtype.itemsize, 2 if pixels.ndim == 3 else 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(filtered.tobytes(), 1)) +
            chunk(b"IEND", b""))


def _shape_of_file(content: bytes) -> tuple[int, int] | None:
    """Rows and columns by the header of a PNG, PGM or PFM file; None if they are not plain to see."""
    if content.startswith(b"\x89PNG") and content[12:16] == b"IHDR" and len(content) >= 24:
        width, height = struct.unpack(">II", content[16:24])
        return height, width
    found = re.match(rb"P[25f]\s+(?:#[^\n]*\n\s*)*(\d{1,9})\s+(\d{1,9})\s", content)
    return (int(found[2]), int(found[1])) if found else None
