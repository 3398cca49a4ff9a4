# SPDX-License-Identifier: Apache-2.0
"""Clouds of the caller's arrays: what is accepted, and checked before anything is sent."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

#: A coordinate beyond this has a float32 whose last bit is above 0.06 mm, so that float64 coordinates stay as they are.
FAR = 512.0  # meters
_MOST_POINTS = 0x7FFFFFFF


@dataclass(frozen=True)
class Cloud:
    """N points, checked."""

    xyz: npt.NDArray[Any]  # (N, 3), float32; float64 if a coordinate is so far from 0 that float32 is too coarse
    rgb: npt.NDArray[np.uint8] | None  # (N, 3)
    shape: tuple[int, ...]  # of the input without its last axis, and of the labels
    width: int
    height: int  # 1 for a cloud that is not organized, else the rows of an image

    @property
    def packed_rgb(self) -> npt.NDArray[np.uint32]:
        """0x00RRGGBB of every point. There must be colors."""
        assert self.rgb is not None
        channels = self.rgb.astype(np.uint32)
        return (channels[:, 0] << 16 | channels[:, 1] << 8 | channels[:, 2]).astype(np.uint32, copy=False)


def as_cloud(points: Any, rgb: Any = None) -> Cloud:
    """The cloud of arrays, or of an object that has them:

    - xyz (N, 3), or organized (H, W, 3) with the rows of an image; float32 or float64; meters. NaN marks missing
      points. rgb has the same shape: uint8, or floats from 0 to 1. The colors may be left out.
    - a structured array (N,) or (H, W) with the fields x, y and z and, as PCL has it, `rgb` or `rgba` (packed), or r, g
      and b.
    - a Cloud that this function has made.
    - a point cloud of Open3D, or whatever has `points` and `colors`, or `point["positions"]` and `point["colors"]`.

    ValueError or TypeError tells what does not fit.
    """
    has_colors_itself = True
    if isinstance(points, Cloud):
        cloud = points
    elif isinstance(points, np.ndarray) and points.dtype.names:
        cloud = _structured(points)
    elif hasattr(points, "points") or hasattr(points, "point"):
        cloud = _of_object(points)
    else:
        has_colors_itself = False
        cloud = _of_arrays(points, rgb)
    if has_colors_itself and rgb is not None:
        raise ValueError(f"rgb: a {type(points).__name__} brings its own colors")
    return cloud


def _of_arrays(points: Any, rgb: Any) -> Cloud:
    xyz = np.asarray(points)
    if xyz.dtype not in (np.float32, np.float64):
        raise TypeError(f"xyz: the type is {xyz.dtype}, but must be float32 or float64 (meters)")
    if xyz.ndim not in (2, 3) or xyz.shape[-1] != 3:
        raise ValueError(f"xyz: the shape is {xyz.shape}, but must be (N, 3), or (H, W, 3) for an organized cloud")
    shape = xyz.shape[:-1]
    count = math.prod(shape)
    if count == 0:
        raise ValueError("xyz: there is no point")
    if count > _MOST_POINTS:
        raise ValueError(f"xyz: {count} points are more than the {_MOST_POINTS} that are possible")
    height, width = shape if len(shape) == 2 else (1, count)
    colors = None if rgb is None else _colors(np.asarray(rgb), shape)
    return Cloud(_coordinates(xyz.reshape(count, 3)), colors, shape, width, height)


def _coordinates(xyz: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if xyz.dtype == np.float64:
        with np.errstate(invalid="ignore", over="ignore"):
            finite = np.where(np.isfinite(xyz), xyz, 0)
            is_near = max(-finite.min(), finite.max()) <= FAR
            return xyz.astype("<f4") if is_near else xyz.astype("<f8", copy=False)
    return xyz.astype("<f4", copy=False)


def _colors(rgb: npt.NDArray[Any], shape: tuple[int, ...]) -> npt.NDArray[np.uint8]:
    if rgb.shape != (*shape, 3):
        raise ValueError(f"rgb: the shape is {rgb.shape}, but must be {(*shape, 3)} as that of xyz")
    rgb = rgb.reshape(-1, 3)
    if rgb.dtype == np.uint8:
        return rgb
    if rgb.dtype not in (np.float32, np.float64):
        raise TypeError(f"rgb: the type is {rgb.dtype}, but must be uint8 (0 to 255) or a float (0 to 1)")
    rgb = np.nan_to_num(rgb, copy=True, nan=0.0)
    if rgb.size and (rgb.min() < 0 or rgb.max() > 1):
        raise ValueError(f"rgb: floats must be from 0 to 1, but there are {rgb.min():g} to {rgb.max():g}; "
                         "give numbers from 0 to 255 as uint8")
    return np.rint(rgb * 255).astype(np.uint8)


def _structured(points: npt.NDArray[Any]) -> Cloud:
    names = points.dtype.names or ()
    missing = [name for name in "xyz" if name not in names]
    if missing:
        raise ValueError(f"xyz: the structured array lacks {', '.join(missing)}; it has {', '.join(names)}")
    for name in "xyz":
        if points[name].dtype.kind != "f" or points[name].shape != points.shape:
            raise TypeError(f"xyz: the field {name} is {points.dtype[name]}, but must be one float")
    xyz = np.stack([points[name] for name in "xyz"], axis=-1)
    if xyz.dtype not in (np.float32, np.float64):
        xyz = xyz.astype(np.float64 if xyz.dtype.itemsize > 4 else np.float32)
    return _of_arrays(xyz, _structured_colors(points))


def _structured_colors(points: npt.NDArray[Any]) -> npt.NDArray[np.uint8] | None:
    names = points.dtype.names or ()
    for name in ("rgb", "rgba"):
        if name in names:
            column = np.ascontiguousarray(points[name])
            if column.shape == (*points.shape, 3) and column.dtype == np.uint8:
                return column
            if column.shape != points.shape or column.dtype.itemsize != 4:
                raise TypeError(f"rgb: the field {name} is {points.dtype[name]}, but must be four bytes 0xAARRGGBB")
            # The bits of a packed float are the color; its value is not.
            packed = column.view(column.dtype.newbyteorder("=").str.replace("f", "u").replace("i", "u"))
            if column.dtype.byteorder not in ("=", "|") and not column.dtype.isnative:
                packed = packed.byteswap()
            return np.stack([packed >> shift & 255 for shift in (16, 8, 0)], axis=-1).astype(np.uint8)
    for red, green, blue in (("r", "g", "b"), ("red", "green", "blue")):
        if {red, green, blue} <= set(names):
            channels = [points[name] for name in (red, green, blue)]
            if any(channel.dtype != np.uint8 for channel in channels):
                raise TypeError(f"rgb: the fields {red}, {green} and {blue} must be uint8")
            return np.stack(channels, axis=-1)
    return None


def _of_object(cloud: Any) -> Cloud:
    if hasattr(cloud, "points"):  # open3d.geometry.PointCloud
        xyz, rgb = np.asarray(cloud.points), np.asarray(getattr(cloud, "colors", ()))
    else:  # open3d.t.geometry.PointCloud, whose tensors are mappings of names
        xyz, rgb = _tensor(cloud.point, "positions"), _tensor(cloud.point, "colors")
    if xyz.size == 0:
        raise ValueError("xyz: there is no point")
    return _of_arrays(xyz, rgb if rgb.size else None)


def _tensor(attributes: Any, name: str) -> npt.NDArray[Any]:
    if name not in attributes:
        return np.empty((0, 3))
    tensor = attributes[name]
    return np.asarray(tensor.numpy() if hasattr(tensor, "numpy") else tensor)
