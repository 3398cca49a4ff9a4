# SPDX-License-Identifier: Apache-2.0
"""The result of one cloud."""
from __future__ import annotations

import datetime
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from segserve import options
from segserve import selection as selecting
from segserve.selection import Place, Selection
from segserve.tracking import Tracks
from segserve.tree import MergeTree
from segserve.v1 import result_pb2, segment_pb2
from segserve.view import View, view_of

#: A record of Result.segments. Numbers that a segment does not have are NaN.
SEGMENT = np.dtype([("label", "<u4"), ("points", "<u4"), ("centroid", "<f8", 3), ("box_center", "<f8", 3),
                    ("box_axes", "<f8", (3, 3)), ("box_half_extents", "<f8", 3), ("color", "<f8", 3),
                    ("normal", "<f8", 3), ("thresholds", "<f8", 2), ("stability", "<f8")])


class Resolution(NamedTuple):
    """How large voxels and supervoxels were, and why. For a camera and a sweep, lengths are those at 1 m distance."""

    voxel: float  # meters
    seed: float  # meters
    reason: str  # "given", "dense", "spacing", "noise", "extent" or "sweep"
    noise_depth: float | None  # meters


class ResultWarning(NamedTuple):
    """Something that the owner of a cloud should know although it was segmented."""

    reason: str  # for programs, such as "TOO_SPARSE"
    message: str


class SupportPlane(NamedTuple):
    """The plane that was removed: the points p with normal . p = offset."""

    points: int  # 0 if no plane was large enough
    normal: tuple[float, float, float]
    offset: float


class Placement(NamedTuple):
    """From the coordinates of the payload to those that were segmented: scale * (payload - offset)."""

    scale: tuple[float, float, float]
    offset: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Result:
    """What the server found in one cloud."""

    #: The segment of every point, in the shape of the input, from 1 by descending size. 0: not segmented. None: not
    #: asked for.
    labels: npt.NDArray[np.uint32] | None
    #: The supervoxel of every point, from 1; 0: not segmented. None: not asked for.
    supervoxels: npt.NDArray[np.uint32] | None
    #: The merge tree; None: not asked for.
    tree: MergeTree | None
    #: A record of the type SEGMENT for each segment, the largest 10,000 at most; None: not asked for.
    segments: npt.NDArray[np.void] | None
    #: The summary as the server sent it.
    summary: result_pb2.ResultSummary = field(repr=False)
    #: What the prompts of the request select; None without prompts.
    selection: Selection | None = None
    #: The ids of the segments over time; None: not asked for.
    tracks: Tracks | None = None
    #: These three repeat those of the request.
    request_id: str = ""
    frame_id: str = ""
    stamp: datetime.datetime | None = None
    #: The shapes of the clouds of several cameras, as they were given; () if that is not known.
    camera_shapes: tuple[tuple[int, ...], ...] = field(default=(), repr=False)

    def by_camera(self, values: npt.NDArray[Any] | None = None) -> list[npt.NDArray[Any]]:
        """The labels of each camera, in the shape of its input, or what else is given with one value for each point,
        such as a cut. ValueError if there are no cameras, or other numbers of values."""
        values = self.labels if values is None else np.asarray(values)
        cameras = self.view.cameras
        if values is None or not cameras:
            raise ValueError("the result has no labels" if cameras else "the cloud is not that of several cameras")
        if values.size != self.points:
            raise ValueError(f"{values.size} values for {self.points} points: there must be one for each point")
        ends = np.cumsum([camera.points for camera in cameras])
        shapes = self.camera_shapes or tuple((camera.points, ) for camera in cameras)
        return [part.reshape(shape) for part, shape in zip(np.split(values.reshape(-1), ends[:-1]), shapes)]

    @property
    def points(self) -> int:
        """Points of the cloud, finite or not."""
        return int(self.summary.points)

    @property
    def finite_points(self) -> int:
        return int(self.summary.finite_points)

    @property
    def segmented_points(self) -> int:
        """The points with a segment."""
        return int(self.summary.segmented_points)

    @property
    def voxels(self) -> int:
        return int(self.summary.voxels)

    @property
    def supervoxel_count(self) -> int:
        return int(self.summary.supervoxels)

    @property
    def segment_count(self) -> int:
        return int(self.summary.segments)

    @property
    def method(self) -> str:
        return options.method_name(self.summary.method)

    @property
    def threshold(self) -> float | None:
        """The threshold of the cut; None if the caller asked for a number of regions."""
        return float(self.summary.threshold) if self.summary.HasField("threshold") else None

    @property
    def regions(self) -> int | None:
        """The number of regions that was asked for."""
        return int(self.summary.regions) if self.summary.HasField("regions") else None

    @property
    def view(self) -> View:
        """The view that was used."""
        return view_of(self.summary.view)

    @property
    def view_rule(self) -> str:
        """By which rule the view was chosen, for people."""
        return str(self.summary.view_rule)

    @property
    def resolution(self) -> Resolution:
        used = self.summary.resolution
        noise = used.noise_depth if used.HasField("noise_depth") else None
        return Resolution(used.voxel_resolution, used.seed_resolution, used.reason, noise)

    @property
    def timings(self) -> dict[str, float]:
        """The wall time of each stage on the server, milliseconds, such as "merging". "total" holds all of them."""
        timings = self.summary.timings
        names = [entry.name for entry in timings.DESCRIPTOR.fields]
        return {name[:-len("_ms")]: getattr(timings, name)
                for name in names if name != "tracking_ms" or self.tracks is not None}

    @property
    def warnings(self) -> list[ResultWarning]:
        """Which parts of the cloud were not used, and what is probably wrong."""
        return [ResultWarning(warning.reason, warning.message) for warning in self.summary.warnings]

    @property
    def support_plane(self) -> SupportPlane | None:
        if not self.summary.HasField("support_plane"):
            return None
        plane = self.summary.support_plane
        return SupportPlane(plane.points, (plane.normal_x, plane.normal_y, plane.normal_z), plane.offset)

    @property
    def placement(self) -> Placement | None:
        """Set if the cloud was moved, scaled or turned before it was segmented."""
        if not self.summary.HasField("placement"):
            return None
        placement = self.summary.placement
        return Placement(vector_of(placement.scale), vector_of(placement.offset))

    @property
    def server_version(self) -> str:
        return str(self.summary.server_version)

    @property
    def options_hash(self) -> str:
        """Equal clouds with equal hashes have equal labels on every replica of one version."""
        return str(self.summary.options_hash)

    def cut(self, *, regions: int | None = None, threshold: float | None = None) -> npt.NDArray[np.uint32]:
        """The segment of every point in another cut of the tree, in the shape of the input, without asking the server.

        ValueError unless exactly one of the two is given, and unless the result has supervoxels and tree.
        """
        if self.tree is None or self.supervoxels is None:
            raise ValueError("cut: the outputs 'supervoxels' and 'tree' are needed, which were not asked for")
        of_leaf = self.tree.cut(regions=regions, threshold=threshold)
        return np.concatenate([np.zeros(1, np.uint32), of_leaf])[self.supervoxels]

    def select(self,
               include: Sequence[Place],
               exclude: Sequence[Place] = (),
               *,
               points: npt.NDArray[Any] | None = None,
               larger: int = 0,
               regions: int | None = None,
               threshold: float | None = None) -> Selection:
        """Selects by places on an object and beside it, as `segctl pick` does, without asking the server.

        A place is a pixel (u, v) of an organized cloud, or a position (x, y, z), for which `points` must be the cloud
        that was segmented. The choice is the one that the cut of the result makes, or a cut at `regions` or `threshold`,
        or one that is larger by so many steps; below 0 it is smaller. ValueError if a place stands for no point, or the
        result lacks supervoxels and tree.
        """
        if self.tree is None or self.supervoxels is None:
            raise ValueError("select: the outputs 'supervoxels' and 'tree' are needed, which were not asked for")
        included = [selecting.find_point(place, self.supervoxels, points) for place in include]
        excluded = [selecting.find_point(place, self.supervoxels, points) for place in exclude]
        candidates = selecting.select(self.tree, [point.supervoxel for point in included],
                                      [point.supervoxel for point in excluded])
        if regions is None and threshold is None:
            regions, threshold = self.regions, self.threshold
        usual = selecting.candidate_of_cut(self.tree, candidates, regions=regions, threshold=threshold)
        candidate = min(max(usual + larger, 0), len(candidates) - 1)
        below = selecting.leaves_below(self.tree, candidates.nodes(candidate))
        return Selection(mask=np.concatenate([np.zeros(1, bool), below])[self.supervoxels], candidates=candidates,
                         candidate=candidate, thresholds=selecting.thresholds_of(self.tree, candidates, candidate),
                         include=included, exclude=excluded)

    def dendrogram(self, **arguments: Any) -> dict[str, Any]:
        """SciPy's dendrogram of the tree; see MergeTree.dendrogram."""
        if self.tree is None:
            raise ValueError("dendrogram: the output 'tree' is needed, which was not asked for")
        return self.tree.dendrogram(**arguments)

    def save(self, path: str | os.PathLike[str], points: Any = None, rgb: Any = None) -> None:
        """Writes the file that `segctl cut` reads. With the cloud, `segctl cut --cloud` notices a wrong one later.

        ValueError unless the result has labels, supervoxels and tree.
        """
        from segserve import result_file

        content = result_file.encode(self, points, rgb)
        with open(path, "wb") as file:
            file.write(content)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Result:
        """Reads a file of save() or of `segctl segment --result`. Its arrays have the shape (N,). ValueError if it is
        broken."""
        from segserve import result_file

        with open(path, "rb") as file:
            return result_file.decode(file.read())


def vector_of(message: segment_pb2.Vector3) -> tuple[float, float, float]:
    return (message.x, message.y, message.z)
