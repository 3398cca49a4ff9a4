# SPDX-License-Identifier: Apache-2.0
"""Where the sensor is relative to the points of a cloud."""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Union

from segserve.v1 import cloud_pb2


#: The most cameras that a view may have.
MOST_CAMERAS = 64


@dataclass(frozen=True)
class CameraPoints:
    """The points that one of several cameras saw. They follow one another in the cloud."""

    points: int  # their number, at least 1
    sensor: tuple[float, float, float]  # position of the camera in the frame of the cloud, meters

    def __post_init__(self) -> None:
        if self.points < 1:
            raise ValueError("view: a camera has no points")
        _check_position(self.sensor)


def _check_position(position: tuple[float, float, float]) -> None:
    if len(position) != 3 or not all(math.isfinite(value) for value in position):
        raise ValueError(f"view: {position} is not a position of three finite numbers")


@dataclass(frozen=True)
class View:
    """The frame of a cloud's points.

    "camera": z points forward, the sensor is at the origin, and every finite point has z > 0. Voxels grow with the
    distance. "world": any other frame. Voxels are equally large everywhere, and normals are turned toward `sensor` if
    it is known.
    """

    kind: str
    #: The position of the sensor in the frame of the cloud, meters. Only a "world" may have one.
    sensor: tuple[float, float, float] | None = None
    #: The cameras of a "world" that several of them saw at once, in the order of their points, instead of `sensor`.
    #: Each normal is turned to the camera that saw the surface. merge_cameras() makes such a cloud.
    cameras: tuple[CameraPoints, ...] = ()

    def __post_init__(self) -> None:
        if self.kind not in ("camera", "world"):
            raise ValueError(f"view: '{self.kind}' is neither 'camera' nor 'world'")
        if self.cameras and (self.kind == "camera" or self.sensor is not None):
            raise ValueError("view: only a 'world' without a sensor may have cameras")
        if len(self.cameras) > MOST_CAMERAS:
            raise ValueError(f"view: there are {len(self.cameras)} cameras, but at most {MOST_CAMERAS} are possible")
        if self.sensor is None:
            return
        if self.kind == "camera":
            raise ValueError("view: the sensor of a camera is at the origin; only 'world' has a position")
        _check_position(self.sensor)

    @staticmethod
    def camera() -> View:
        return View("camera")

    @staticmethod
    def world(x: float | None = None, y: float | None = None, z: float | None = None) -> View:
        """A world frame, with the position of the sensor if all three coordinates are given, meters."""
        if x is None and y is None and z is None:
            return View("world")
        if x is None or y is None or z is None:
            raise ValueError("view: a position has three coordinates")
        return View("world", (float(x), float(y), float(z)))

    def __str__(self) -> str:
        if self.cameras:
            return f"world of {len(self.cameras)} cameras"
        return self.kind if self.sensor is None else "world:{:g},{:g},{:g}".format(*self.sensor)


#: What functions take as a view: a View, or "camera", "world" or "world:X,Y,Z" as segctl does. None leaves the choice
#: to the server, which judges by the points, as for a file; Result.view and Result.view_rule then tell what it chose.
ViewLike = Union[View, str, None]


def as_view(view: ViewLike) -> View | None:
    """The view that is meant. ValueError if it is none."""
    if view is None or isinstance(view, View):
        return view
    if not isinstance(view, str):
        raise TypeError(f"view: a View or a text is needed, not {type(view).__name__}")
    kind, _, position = view.partition(":")
    if not position:
        return View(kind)
    try:
        x, y, z = (float(word) for word in position.split(","))
    except ValueError:
        raise ValueError(f"view: '{view}' is not camera, world or world:X,Y,Z") from None
    return View(kind, (x, y, z))


def view_message(view: View) -> cloud_pb2.View:
    if view.kind == "camera":
        return cloud_pb2.View(kind=cloud_pb2.VIEW_KIND_CAMERA)
    message = cloud_pb2.View(kind=cloud_pb2.VIEW_KIND_WORLD)
    if view.sensor is not None:
        message.sensor.x, message.sensor.y, message.sensor.z = view.sensor
    for camera in view.cameras:
        x, y, z = camera.sensor
        message.cameras.add(points=camera.points, sensor=cloud_pb2.Position(x=x, y=y, z=z))
    return message


def view_of(message: cloud_pb2.View) -> View:
    """The view of a result. ValueError if the message tells none."""
    if message.kind == cloud_pb2.VIEW_KIND_CAMERA:
        return View("camera")
    if message.kind != cloud_pb2.VIEW_KIND_WORLD:
        raise ValueError("the result does not say which view was used")
    sensor = message.sensor
    cameras = tuple(
        CameraPoints(camera.points, (camera.sensor.x, camera.sensor.y, camera.sensor.z)) for camera in message.cameras)
    return View("world", (sensor.x, sensor.y, sensor.z) if message.HasField("sensor") else None, cameras)
