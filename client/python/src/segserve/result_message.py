# SPDX-License-Identifier: Apache-2.0
"""Reads results from messages, and believes none of their numbers."""
from __future__ import annotations

import dataclasses
import datetime
import math
from collections.abc import Collection
from typing import Any

import numpy as np
import numpy.typing as npt

from segserve import codecs, tracking
from segserve.errors import Internal, Unimplemented
from segserve.result import SEGMENT, Result, vector_of
from segserve.selection import Candidates, PromptedPoint, Selection
from segserve.tree import MergeTree
from segserve.v1 import prompts_pb2, result_pb2, segment_pb2
from segserve.view import view_of

_MOST_DESCRIBED_SEGMENTS = 10_000
_MOST_POINTS = 100_000_000  # that are believed if only the server knows how many there are


def decode(message: result_pb2.SegmentationResult, shape: tuple[int, ...] | None, wanted: Collection[str],
           request_id: str = "", frame_id: str = "", stamp: datetime.datetime | None = None,
           wants_tracks: bool = False, **arrays: npt.NDArray[np.uint32] | None) -> Result:
    """The result in an answer. Internal if the answer is broken, or lacks what was wanted. Unimplemented if the server
    is too old to follow objects.

    `arrays`: labels and supervoxels that are at hand already, in the shape of the input.
    """
    if isinstance(wanted, str):
        wanted = (wanted,)
    if wants_tracks and not message.HasField("tracking"):
        raise Unimplemented(f"the server, version {message.summary.server_version}, does not follow objects over time")
    try:
        return dataclasses.replace(read(message, shape, wanted, request_id, frame_id, stamp), **arrays)
    except ValueError as error:
        raise Internal(f"the answer is broken: {error}") from None


def read(message: result_pb2.SegmentationResult, shape: tuple[int, ...] | None, wanted: Collection[str],
         request_id: str = "", frame_id: str = "", stamp: datetime.datetime | None = None) -> Result:
    """The result in a message, each number of which is checked. ValueError if they do not fit each other."""
    summary = message.summary
    if shape is None:
        if summary.points > _MOST_POINTS:
            raise ValueError(f"it claims {summary.points} points, and at most {_MOST_POINTS} are accepted")
        shape = (summary.points,)
    _check_summary(summary, math.prod(shape))
    result = Result(
        labels=integers(message.labels, summary.points, summary.segments, "labels").reshape(shape)
        if message.HasField("labels") else None,
        supervoxels=integers(message.supervoxels, summary.points, summary.supervoxels, "supervoxels").reshape(shape)
        if message.HasField("supervoxels") else None,
        tree=_tree(message.tree, summary) if message.HasField("tree") else None,
        segments=_segments(message.segments, summary) if message.segments or "segments" in wanted else None,
        selection=_selection(message, shape) if message.HasField("selection") else None,
        tracks=tracking.read(message.tracking, summary.segments) if message.HasField("tracking") else None,
        summary=summary, request_id=request_id, frame_id=frame_id, stamp=stamp)
    missing = [name for name in wanted if getattr(result, name) is None]
    if missing:
        raise ValueError(f"it lacks {', '.join(missing)}")
    return result


def _check_summary(summary: result_pb2.ResultSummary, points: int) -> None:
    if summary.points != points:
        raise ValueError(f"the result has {summary.points} points, but the cloud has {points}")
    if not summary.segments <= summary.supervoxels <= summary.segmented_points <= summary.finite_points <= points:
        raise ValueError(
            f"the numbers of the summary contradict each other: {points} points, {summary.finite_points} finite "
            f"points, {summary.segmented_points} segmented points, {summary.supervoxels} supervoxels, "
            f"{summary.segments} segments")
    cameras = view_of(summary.view).cameras
    if cameras and sum(camera.points for camera in cameras) != points:
        raise ValueError(f"the cameras of the view do not have {points} points together")


def integers(message: result_pb2.IntegerArray, count: int, largest: int, name: str) -> npt.NDArray[np.uint32]:
    """The values of an array from a server. ValueError unless there are `count`, none above `largest`."""
    width = message.bytes_per_value
    if message.count != count:
        raise ValueError(f"{name}: has {message.count} values, but must have {count}")
    if width not in (1, 2, 4):
        raise ValueError(f"{name}: has {width} bytes per value, but must have 1, 2 or 4")
    values = np.frombuffer(codecs.block_bytes(message.data, count * width, name), f"<u{width}")
    if count and values.max() > largest:
        raise ValueError(f"{name}: holds {values.max()}, but the largest allowed value is {largest}")
    return values.astype(np.uint32)


def _tree(message: result_pb2.MergeTree, summary: result_pb2.ResultSummary) -> MergeTree:
    leaves, any_value = summary.supervoxels, 2**32 - 1
    rows = max(leaves - 1, 0)
    weight = np.frombuffer(codecs.block_bytes(message.weight, 8 * rows, "tree.weight"), "<f8")
    tree = MergeTree(leaf_points=integers(message.leaf_points, leaves, any_value, "tree.leaf_points"),
                     left=integers(message.left, rows, any_value, "tree.left"),
                     right=integers(message.right, rows, any_value, "tree.right"),
                     weight=weight, merged_rows=message.merged_rows)
    points = int(tree.leaf_points.sum(dtype=np.uint64))
    if points != summary.segmented_points:
        raise ValueError(f"tree.leaf_points: the sum is {points} points, but must be {summary.segmented_points}")
    return tree


def _segments(messages: Collection[segment_pb2.Segment], summary: result_pb2.ResultSummary) -> npt.NDArray[np.void]:
    expected = min(summary.segments, _MOST_DESCRIBED_SEGMENTS)
    if len(messages) != expected:
        raise ValueError(f"segments: has {len(messages)} entries, but must have {expected}")
    table = np.array([_segment_row(segment, label) for label, segment in enumerate(messages, start=1)], SEGMENT)
    if (np.diff(table["points"].astype(np.int64)) > 0).any() or int(table["points"].sum()) > summary.segmented_points:
        raise ValueError("segments: their numbers of points do not fit the summary")
    return table


def _segment_row(segment: segment_pb2.Segment, label: int) -> tuple[Any, ...]:
    if len(segment.box.axes) != 3:
        raise ValueError(f"segment {label}: box.axes: has {len(segment.box.axes)} axes, but must have 3")
    nothing = (math.nan,) * 3
    color, thresholds = segment.color, (math.nan, math.nan)
    if segment.HasField("thresholds"):
        thresholds = _thresholds(segment.thresholds, f"segment {label}")
    return (label, segment.points, vector_of(segment.centroid), vector_of(segment.box.center),
            [vector_of(axis) for axis in segment.box.axes], vector_of(segment.box.half_extents),
            (color.red, color.green, color.blue) if segment.HasField("color") else nothing,
            vector_of(segment.normal) if segment.HasField("normal") else nothing, thresholds,
            thresholds[1] - thresholds[0])


def _thresholds(message: segment_pb2.ThresholdRange, name: str) -> tuple[float, float]:
    if not 0 <= message.lower <= message.upper <= 1:
        raise ValueError(f"{name}: thresholds: must be ascending in [0, 1]")
    return (message.lower, message.upper)


def _selection(message: result_pb2.SegmentationResult, shape: tuple[int, ...]) -> Selection:
    found, summary = message.selection, message.summary
    nodes = max(2 * summary.supervoxels - 1, 0)
    candidates = Candidates(np.array(found.smallest, np.uint32), np.array(found.step_groups, np.uint32),
                            np.array(found.step_nodes, np.uint32))
    is_good = (len(candidates.smallest) > 0 and (candidates.smallest < nodes).all() and
               (candidates.step_nodes < nodes).all() and len(candidates.step_groups) == len(candidates.step_nodes) and
               (candidates.step_groups < len(candidates.smallest)).all() and found.candidate < len(candidates))
    if not is_good:
        raise ValueError("selection: its candidates are none of the tree")
    return Selection(
        mask=integers(message.selected, summary.points, 1, "selected").astype(bool).reshape(shape)
        if message.HasField("selected") else None, candidates=candidates, candidate=found.candidate,
        thresholds=_thresholds(found.thresholds, "selection"), include=_points(found.include, summary),
        exclude=_points(found.exclude, summary),
        segment=np.array([_segment_row(found.segment, 1)], SEGMENT)[0] if found.HasField("segment") else None)


def _points(messages: Collection[prompts_pb2.PromptedPoint], summary: result_pb2.ResultSummary) -> list[PromptedPoint]:
    points = [PromptedPoint(message.point, message.supervoxel, message.distance) for message in messages]
    for point in points:
        if point.point >= summary.points or not 1 <= point.supervoxel <= summary.supervoxels or not point.distance >= 0:
            raise ValueError(f"selection: point {point.point} is none of the cloud")
    return points
