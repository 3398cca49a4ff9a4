# SPDX-License-Identifier: Apache-2.0
"""Several cameras that see one scene at the same time: their clouds become one cloud with one merge tree, in which each
normal is turned to the camera that saw the surface."""
from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from segserve import ros
from segserve.cloud import Cloud, as_cloud
from segserve.result import Result
from segserve.view import MOST_CAMERAS, CameraPoints, View, ViewLike, as_view

_TOLERANCE = 1e-3  # of rotations, because calibrations are written with few digits


@dataclass(frozen=True, eq=False)
class Camera:
    """The cloud of one of several cameras.

    points, rgb: as in Client.segment(), in the frame of the camera, meters; arrays, a structured array, a cloud of
    Open3D or a PointCloud2.
    pose: (4, 4), from the frame of the cloud to the frame that all cameras share: the extrinsics of the camera, meters.
    view: "camera", or "world:X,Y,Z" with the position of the sensor in the frame of the cloud.
    """

    points: Any
    rgb: Any = None
    pose: Any = None
    view: ViewLike = "camera"


class MergedCameras(NamedTuple):
    """The clouds of several cameras as one, in the frame that they share."""

    cloud: Cloud  # the points of the first camera come first, in their order, then those of the second, and so on
    view: View  # with View.cameras
    shapes: tuple[tuple[int, ...], ...]  # of the points of each camera, without the last axis

    def restore(self, result: Result) -> Result:
        """The result of the merged cloud, whose Result.by_camera() gives arrays of the shapes of the input."""
        return dataclasses.replace(result, camera_shapes=self.shapes)


def merge_cameras(cameras: Sequence[Camera]) -> MergedCameras:
    """Merges clouds as merge_cameras of the C++ library does, bit for bit. Points at (0, 0, 0) of a camera's frame,
    which are pixels without depth, become NaN.

    For streams: `stream.send(merged.cloud, view=merged.view)`, and `merged.restore(outcome.get())`. ValueError names the
    camera that is wrong by its index.
    """
    cameras = list(cameras)
    if not cameras:
        raise ValueError("cameras: there is none")
    if len(cameras) > MOST_CAMERAS:
        raise ValueError(f"cameras: there are {len(cameras)}, but at most {MOST_CAMERAS} are possible")
    moved, colors, seen, shapes = [], [], [], []
    for index, camera in enumerate(cameras):
        try:
            cloud = ros.cloud_of(camera.points) if ros.is_point_cloud2(camera.points) else as_cloud(
                camera.points, camera.rgb)
            xyz, sensor = _moved(cloud, _pose(camera.pose), as_view(camera.view))
        except (TypeError, ValueError) as error:
            raise type(error)(f"camera {index}: {error}") from None
        moved.append(xyz)
        colors.append(cloud.rgb)
        seen.append(CameraPoints(len(xyz), sensor))
        shapes.append(cloud.shape)
        if (cloud.rgb is None) != (colors[0] is None):
            raise ValueError(f"camera {index}: either all clouds have color, or none has")
    rgb = None if colors[0] is None else np.concatenate([color for color in colors if color is not None])
    merged = as_cloud(np.concatenate(moved), rgb)
    return MergedCameras(merged, View("world", cameras=tuple(seen)), tuple(shapes))


def _pose(pose: Any) -> npt.NDArray[np.float64]:
    """The matrix of a pose; None is the identity."""
    matrix = np.eye(4) if pose is None else np.asarray(pose, np.float64)
    if matrix.shape != (4, 4):
        raise ValueError(f"pose: the shape is {matrix.shape}, but must be (4, 4)")
    if not np.isfinite(matrix).all() or (matrix[3] != (0, 0, 0, 1)).any():
        raise ValueError("pose: the matrix must be finite, with the last row 0, 0, 0, 1")
    rotation = matrix[:3, :3]
    if np.abs(rotation.T @ rotation - np.eye(3)).max() > _TOLERANCE:
        raise ValueError("pose: the rotation is not orthonormal")
    if np.linalg.det(rotation) < 0:
        raise ValueError("pose: the rotation is left-handed, a mirror image")
    return matrix


def _transformed(pose: npt.NDArray[np.float64], xyz: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """The points (N, 3) in the shared frame, computed in the order of the C++ library."""
    x, y, z = xyz.T
    return np.stack([row[0] * x + row[1] * y + row[2] * z + row[3] for row in pose[:3]], axis=-1).astype(np.float32)


def _moved(cloud: Cloud, pose: npt.NDArray[np.float64],
           view: View | None) -> tuple[npt.NDArray[np.float32], tuple[float, float, float]]:
    """The points and the position of the sensor in the shared frame."""
    if view is None or view.cameras or (view.kind == "world" and view.sensor is None):
        raise ValueError("view: 'camera', or 'world:X,Y,Z' with the position of the sensor, is needed")
    xyz = cloud.xyz.astype(np.float64)
    missing = ~np.isfinite(xyz).all(axis=1)
    if view.kind == "camera":
        missing |= (xyz == 0).all(axis=1)
    xyz[missing] = math.nan
    sensor = _transformed(pose, np.array([view.sensor or (0, 0, 0)], np.float32).astype(np.float64))[0]
    return _transformed(pose, xyz), (float(sensor[0]), float(sensor[1]), float(sensor[2]))
