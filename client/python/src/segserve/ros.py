# SPDX-License-Identifier: Apache-2.0
"""Messages of ROS, in and out, by their fields: PointCloud2, Image and CameraInfo of ROS 1 and ROS 2.

This package needs no ROS. A message is recognized by what it has.
"""
from __future__ import annotations

import sys
from typing import Any

import numpy as np
import numpy.typing as npt

from segserve.cloud import Cloud, as_cloud
from segserve.codecs import encode_cloud
from segserve.payload import Payload, announce
from segserve.result import Result
from segserve.rgbd import Intrinsics
from segserve.v1 import cloud_pb2
from segserve.view import View, view_message

_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
_UINT32 = 6
_LABEL = "label"
#: The encodings of images: type and number of channels.
_ENCODINGS = {
    "mono8": ("u1", 1),
    "8UC1": ("u1", 1),
    "mono16": ("u2", 1),
    "16UC1": ("u2", 1),
    "32FC1": ("f4", 1),
    "32SC1": ("i4", 1),
    "rgb8": ("u1", 3),
    "bgr8": ("u1", 3),
    "rgba8": ("u1", 4),
    "bgra8": ("u1", 4),
    "8UC3": ("u1", 3)
}


def is_point_cloud2(message: Any) -> bool:
    return all(
        hasattr(message, name)
        for name in ("fields", "point_step", "row_step", "is_bigendian", "data", "width", "height"))


def is_image(message: Any) -> bool:
    return all(hasattr(message, name) for name in ("encoding", "step", "is_bigendian", "data", "width", "height"))


def is_camera_info(message: Any) -> bool:
    return hasattr(message, "k") or hasattr(message, "K")


def _dtype(message: Any) -> np.dtype[Any]:
    """The type of one point of a PointCloud2. ValueError if its fields make none."""
    order = ">" if message.is_bigendian else "<"
    names, formats, offsets = [], [], []
    for entry in message.fields:
        if entry.datatype not in _TYPES:
            raise ValueError(f"PointCloud2: the field {entry.name} has the unknown type {entry.datatype}")
        count = max(int(entry.count), 1)
        kind = np.dtype(order + _TYPES[entry.datatype])
        if entry.offset + count * kind.itemsize > message.point_step:
            raise ValueError(f"PointCloud2: the field {entry.name} reaches beyond point_step, {message.point_step}")
        names.append(entry.name)
        formats.append(kind if count == 1 else (kind, (count,)))
        offsets.append(entry.offset)
    spec: Any = {"names": names, "formats": formats, "offsets": offsets, "itemsize": message.point_step}
    return np.dtype(spec)


def _row_step(message: Any) -> int:
    """The bytes of a row. No row follows a single one, whose row_step may be 0."""
    least = message.width * message.point_step
    return max(int(message.row_step), least) if message.height == 1 else int(message.row_step)


def _rows(message: Any) -> npt.NDArray[np.uint8]:
    """The points of a PointCloud2, (H, W, point_step). ValueError if there are too few bytes."""
    data = np.frombuffer(bytes(message.data), np.uint8)
    height, width, step = message.height, message.width, message.point_step
    row_step = _row_step(message)
    if row_step < width * step or len(data) < height * row_step:
        raise ValueError(f"PointCloud2: {len(data)} bytes with row_step {message.row_step} are too few for "
                         f"{height} x {width} points of {step} bytes")
    return data[:height * row_step].reshape(height, row_step)[:, :width * step].reshape(height, width, step)


def structured_array(message: Any) -> npt.NDArray[np.void]:
    """The points of a PointCloud2 as a structured array with its fields: (H, W), or (N,) if the height is 1."""
    points = np.ascontiguousarray(_rows(message)).view(_dtype(message))[..., 0]
    return points[0] if message.height == 1 else points


def cloud_of(message: Any) -> Cloud:
    """The cloud of a PointCloud2."""
    return as_cloud(structured_array(message))


def encode_point_cloud2(message: Any, view: View | None, codec: str | None, error_bound: float, unit: str) -> Payload:
    """Encodes a PointCloud2; without a codec, its data are sent as they are if the view is given."""
    if codec is not None or view is None:
        return encode_cloud(cloud_of(message), view, codec, error_bound, unit)
    _dtype(message)
    _rows(message)
    header = cloud_pb2.Cloud(width=message.width, height=message.height, view=view_message(view))
    strided = header.strided
    for entry in message.fields:
        strided.fields.add(name=entry.name, offset=entry.offset, datatype=entry.datatype, count=entry.count)
    strided.point_step, strided.row_step = message.point_step, _row_step(message)
    strided.is_bigendian = bool(message.is_bigendian)
    data = bytes(message.data)[:message.height * _row_step(message)]
    points = message.width * message.height
    shape = (points,) if message.height == 1 else (message.height, message.width)
    return Payload(header, (announce(strided.data, data),), shape, points, points * 15)


def image_array(message: Any) -> npt.NDArray[Any]:
    """The pixels of an Image: (H, W), or (H, W, 3) as RGB. ValueError for encodings that are not listed above."""
    if message.encoding not in _ENCODINGS:
        raise ValueError(f"Image: the encoding '{message.encoding}' is not known; known are {', '.join(_ENCODINGS)}")
    kind, channels = _ENCODINGS[message.encoding]
    pixel = np.dtype((">" if message.is_bigendian else "<") + kind)
    data = np.frombuffer(bytes(message.data), np.uint8)
    row_bytes = message.width * channels * pixel.itemsize
    if message.step < row_bytes or len(data) < message.height * message.step:
        raise ValueError(
            f"Image: {len(data)} bytes with step {message.step} are too few for {message.height} x {message.width} "
            f"pixels of {message.encoding}")
    rows = data[:message.height * message.step].reshape(message.height, message.step)[:, :row_bytes]
    pixels = np.ascontiguousarray(rows).view(pixel).astype(pixel.newbyteorder("="))
    if channels == 1:
        return pixels
    pixels = pixels.reshape(message.height, message.width, channels)[..., :3]
    return pixels[..., ::-1] if message.encoding.startswith("bgr") else pixels


def intrinsics(message: Any) -> Intrinsics:
    """The pinhole camera of a CameraInfo. Its distortion is not used: give rectified images."""
    k = message.k if hasattr(message, "k") else message.K
    return Intrinsics(float(k[0]), float(k[4]), float(k[2]), float(k[5]))


def label_point_cloud2(message: Any, result: Result) -> Any:
    """A PointCloud2 of the same class and header, with the labels as a field `label` (UINT32) after the other
    fields."""
    labels = _labels(result, message)
    if any(entry.name == _LABEL for entry in message.fields):
        raise ValueError(f"PointCloud2: there is a field '{_LABEL}' already")
    points = _rows(message)
    order = ">" if message.is_bigendian else "<"
    column = labels.astype(f"{order}u4").reshape(message.height, message.width, 1).view(np.uint8)
    labeled = type(message)()
    labeled.header = message.header
    labeled.height, labeled.width = message.height, message.width
    labeled.is_bigendian, labeled.is_dense = message.is_bigendian, message.is_dense
    entry = type(message.fields[0])()
    entry.name, entry.offset, entry.datatype, entry.count = _LABEL, message.point_step, _UINT32, 1
    labeled.fields = [*message.fields, entry]
    labeled.point_step = message.point_step + 4
    labeled.row_step = labeled.point_step * message.width
    labeled.data = np.concatenate([points, column], axis=2).tobytes()
    return labeled


def label_image(message: Any, result: Result) -> Any:
    """An Image of the same class and header, whose pixels are the labels: mono16, or 32SC1 if there are more than
    65535."""
    labels = _labels(result, message)
    is_small = labels.size == 0 or int(labels.max()) <= 0xFFFF
    kind = np.uint16 if is_small else np.int32
    image = type(message)()
    image.header = message.header
    image.height, image.width = message.height, message.width
    image.encoding = "mono16" if is_small else "32SC1"
    image.is_bigendian = int(sys.byteorder == "big")
    image.step = message.width * np.dtype(kind).itemsize
    image.data = labels.astype(kind).tobytes()
    return image


def _labels(result: Result, message: Any) -> npt.NDArray[np.uint32]:
    if result.labels is None:
        raise ValueError("labels: the output 'labels' is needed, which was not asked for")
    if result.labels.size != message.width * message.height:
        raise ValueError(
            f"labels: the result has {result.labels.size} points, but the message {message.width * message.height}")
    return result.labels
