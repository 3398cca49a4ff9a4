# SPDX-License-Identifier: Apache-2.0
"""Payloads of whatever callers have: arrays, clouds, messages of ROS, images, files."""
from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from segserve import ros
from segserve.codecs import DEFAULT_ERROR_BOUND, encode, pcd_file
from segserve.payload import Payload
from segserve.rgbd import encode_rgbd
from segserve.view import ViewLike, as_view


@dataclass(frozen=True)
class Encoding:
    """How clouds are sent, unless a frame says otherwise."""

    view: ViewLike = None
    codec: str | None = None
    error_bound: float = DEFAULT_ERROR_BOUND
    unit: str = "m"

    def payload(self, points: Any, rgb: Any = None, view: ViewLike = None) -> Payload:
        """Encodes arrays or a message; a Payload stays as it is. `view`: of this cloud, if it is not the usual one."""
        if isinstance(points, Payload):
            if rgb is not None:
                raise ValueError("rgb: a Payload brings its own colors")
            return points
        chosen = self.view if view is None else view
        if ros.is_point_cloud2(points):
            if rgb is not None:
                raise ValueError("rgb: a PointCloud2 brings its own colors")
            return ros.encode_point_cloud2(points, as_view(chosen), self.codec, self.error_bound, self.unit)
        return encode(points, rgb, view=chosen, codec=self.codec, error_bound=self.error_bound, unit=self.unit)


def rgbd_payload(depth: Any, color: Any, intrinsics: Any, **how: Any) -> Payload:
    """encode_rgbd for arrays, bytes, and messages Image and CameraInfo of ROS."""
    depth, color = (ros.image_array(image) if ros.is_image(image) else image for image in (depth, color))
    if ros.is_camera_info(intrinsics):
        intrinsics = ros.intrinsics(intrinsics)
    return encode_rgbd(depth, color, intrinsics, **how)


def file_payload(path: str | os.PathLike[str], view: ViewLike, unit: str) -> Payload:
    """The bytes of a PCD file. ValueError if it is none."""
    with open(path, "rb") as file:
        content = file.read()
    if b"DATA" not in content[:1 << 20]:
        raise ValueError(f"{os.fspath(path)}: this is no PCD file; `segctl segment` reads other formats")
    return pcd_file(content, view=view, unit=unit)
