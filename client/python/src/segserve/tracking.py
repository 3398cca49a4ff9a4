# SPDX-License-Identifier: Apache-2.0
"""Objects that keep their ids from frame to frame."""
from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from segserve.v1 import tracking_pb2

_MOST_STATE_BYTES = 96 * 1024
_KIND = "TRACK_EVENT_KIND_"


class TrackEvent(NamedTuple):
    """What became of an object."""

    kind: str  # "born", "split", "lost", "merged", "recovered" or "ended"
    track: int  # its id
    other: int  # of "split" and "merged" the other object; else 0


@dataclass(frozen=True)
class Tracking:
    """Asks for ids that objects keep from cloud to cloud. ValueError if a value makes no sense."""

    #: Tracks.state of the cloud before; empty: all objects are new. A stream hands it on by itself.
    state: bytes = b""
    #: A 4 x 4 or 3 x 4 matrix that leads from the frame of the cloud, in meters, to one that is fixed to the world. None:
    #: the motion of the view is estimated. Stream.send() has it for each frame of a stream.
    pose: Any = None
    #: When the cloud was captured, seconds since any moment. A stream takes the stamp of the frame, or else `captured`.
    time: float | None = None
    #: The highest speed of an object, m/s. None: the server's default, as for the rest.
    max_speed: float | None = None
    #: For so many frames an object that is out of sight keeps its id.
    keep_lost: int | None = None
    #: Segments of fewer points are not followed.
    min_points: int | None = None

    def __post_init__(self) -> None:
        if self.pose is not None:
            pose_message(self.pose)

    def message(self) -> tracking_pb2.TrackRequest:
        """The request as the API has it."""
        request = tracking_pb2.TrackRequest(state=self.state, time=self.time, max_speed=self.max_speed,
                                            keep_lost=self.keep_lost, min_points=self.min_points)
        if self.pose is not None:
            request.pose.CopyFrom(pose_message(self.pose))
        return request

    def of_frame(self, pose: Any, time: float) -> Tracking:
        """The same for one frame of a stream, whose state is set when it is sent."""
        return dataclasses.replace(self, state=b"", pose=self.pose if pose is None else pose,
                                   time=time if self.time is None else self.time)


class Tracks(NamedTuple):
    """The ids of the segments of one cloud."""

    state: bytes  # for Tracking.state of the next cloud
    ids: npt.NDArray[np.uint64]  # entry k - 1 is the id of segment k; 0: it is not followed
    events: list[TrackEvent]

    def of_points(self, labels: npt.NDArray[np.uint32]) -> npt.NDArray[np.uint64]:
        """The id of every point, in the shape of the labels; 0: none."""
        return np.concatenate([np.zeros(1, np.uint64), self.ids])[labels]


def pose_message(pose: Any) -> tracking_pb2.RigidTransform:
    """ValueError unless the pose is a 4 x 4 or 3 x 4 matrix."""
    matrix = np.asarray(pose, dtype=np.float64)
    if matrix.shape not in ((4, 4), (3, 4)):
        raise ValueError(f"pose: a 4 x 4 or 3 x 4 matrix is needed, not one of the shape {matrix.shape}")
    message = tracking_pb2.RigidTransform(rotation=matrix[:3, :3].ravel().tolist())
    message.translation.x, message.translation.y, message.translation.z = matrix[:3, 3].tolist()
    return message


def read(message: tracking_pb2.TrackResult, segments: int) -> Tracks:
    """The ids in a message. ValueError if they do not fit so many segments."""
    ids = np.array(message.track_ids, dtype=np.uint64)
    if len(ids) != segments:
        raise ValueError(f"the result has ids of {len(ids)} segments, but {segments} segments")
    given = ids[ids > 0]
    if len(np.unique(given)) != len(given):
        raise ValueError("two segments of the result have the same id")
    if len(message.state) > _MOST_STATE_BYTES:
        raise ValueError("the track state of the result is too large")
    kinds = tracking_pb2.TrackEventKind.DESCRIPTOR.values_by_number
    # A later server may tell of more.
    events = [TrackEvent(kinds[event.kind].name[len(_KIND):].lower(), event.track, event.other)
              for event in message.events if event.kind in kinds]
    return Tracks(message.state, ids, events)
