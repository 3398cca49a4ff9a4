# SPDX-License-Identifier: Apache-2.0
"""Objects that someone points at: places on an object, and what they select of a merge tree."""
from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from segserve.tree import MergeTree
from segserve.v1 import prompts_pb2

#: A position (x, y, z) in the coordinates of the cloud, or a pixel (u, v): column and row from the upper left, from 0.
Place = Sequence[float]


@dataclass(frozen=True)
class Prompts:
    """Places on an object, and places beside it.

    The server answers with the choice that its cut makes, or one that is larger by so many steps; below 0 it is smaller.
    """

    include: Sequence[Place]
    exclude: Sequence[Place] = ()
    larger: int = 0

    def __post_init__(self) -> None:
        """ValueError for places that are none."""
        if len(self.include) == 0:
            raise ValueError("prompts: nothing is included")
        for place in (*self.include, *self.exclude):
            checked_place(place)

    def message(self) -> prompts_pb2.Prompts:
        """The prompts as the API has them."""
        message = prompts_pb2.Prompts(larger=self.larger)
        for places, messages in ((self.include, message.include), (self.exclude, message.exclude)):
            for place in places:
                numbers = checked_place(place)
                if len(numbers) == 2:
                    pixel = messages.add().pixel
                    pixel.SetInParent()
                    pixel.column, pixel.row = (int(number) for number in numbers)
                else:
                    position = messages.add().position
                    position.SetInParent()
                    position.x, position.y, position.z = numbers
        return message


def checked_place(place: Place) -> tuple[float, ...]:
    """Two whole numbers, or three finite ones. ValueError otherwise."""
    numbers = tuple(float(number) for number in place)
    is_pixel = len(numbers) == 2 and all(number >= 0 and number == int(number) for number in numbers)
    if not is_pixel and not (len(numbers) == 3 and all(math.isfinite(number) for number in numbers)):
        raise ValueError(f"{tuple(place)} is neither a position (x, y, z) nor a pixel (u, v)")
    return numbers


class PromptedPoint(NamedTuple):
    """The segmented point that a place stands for."""

    point: int  # its index in the cloud
    supervoxel: int  # from 1
    distance: float  # from the position that was asked for; 0 for a pixel


@dataclass(frozen=True, eq=False)
class Candidates:
    """The choices of nodes of a merge tree that hold some supervoxels and exclude others, from small to large.

    Candidate 0 has the nodes `smallest`, one for each group of supervoxels that can be held together. Candidate k + 1 is
    candidate k with step_nodes[k] as the node of the group step_groups[k].
    """

    smallest: npt.NDArray[np.uint32]
    step_groups: npt.NDArray[np.uint32]
    step_nodes: npt.NDArray[np.uint32]

    def __len__(self) -> int:
        return len(self.step_nodes) + 1

    def nodes(self, candidate: int) -> npt.NDArray[np.uint32]:
        """The nodes of a candidate, one for each group."""
        if not 0 <= candidate < len(self):
            raise ValueError(f"candidate: {candidate} is not from 0 to {len(self) - 1}")
        nodes = self.smallest.copy()
        for group, node in zip(self.step_groups[:candidate].tolist(), self.step_nodes[:candidate].tolist()):
            nodes[group] = node
        return nodes


@dataclass(frozen=True, eq=False)
class Selection:
    """What prompts select."""

    #: For every point, in the shape of the input, whether it is selected. None: labels were not asked for.
    mask: npt.NDArray[np.bool_] | None
    candidates: Candidates = field(repr=False)
    #: The number of the candidate that was taken.
    candidate: int
    #: The thresholds from which and to which a cut makes this candidate.
    thresholds: tuple[float, float]
    include: list[PromptedPoint]
    exclude: list[PromptedPoint]
    #: A record of the type segserve.result.SEGMENT, without a normal. None: segments were not asked for.
    segment: Any = None

    @property
    def nodes(self) -> npt.NDArray[np.uint32]:
        """The nodes of the merge tree that were taken."""
        return self.candidates.nodes(self.candidate)

    @property
    def stability(self) -> float:
        """How long the candidate stays as it is while the threshold moves, in [0, 1]."""
        return self.thresholds[1] - self.thresholds[0]


def select(tree: MergeTree, include: Sequence[int], exclude: Sequence[int] = ()) -> Candidates:
    """Selects by supervoxels, from 1, as the server and `segctl pick` do. ValueError if that cannot be done."""
    if len(include) == 0:
        raise ValueError("select: nothing is included")
    for supervoxel in (*include, *exclude):
        if not 1 <= supervoxel <= tree.leaf_count:
            raise ValueError(f"select: there is no supervoxel {supervoxel}; there are {tree.leaf_count}")
    both = set(include) & set(exclude)
    if both:
        raise ValueError(f"select: supervoxel {min(both)} is both included and excluded")
    left, right, leaves = tree.left.tolist(), tree.right.tolist(), tree.leaf_count
    nodes = leaves + len(left)
    held, is_negative = [0] * nodes, [False] * nodes
    for supervoxel in include:
        held[supervoxel - 1] = 1
    for supervoxel in exclude:
        is_negative[supervoxel - 1] = True
    for row, (a, b) in enumerate(zip(left, right)):
        held[leaves + row] = held[a] + held[b]
        is_negative[leaves + row] = is_negative[a] or is_negative[b]
    top = list(range(nodes))  # the topmost node without negatives above each one
    for row in range(len(left) - 1, -1, -1):
        node = leaves + row
        if not is_negative[node]:
            top[left[row]] = top[right[row]] = top[node]

    smallest: list[int] = []
    steps: list[tuple[int, int]] = []
    done = set()
    for leaf in range(leaves):
        node = top[leaf]
        if not held[leaf] or node in done:
            continue
        done.add(node)
        wanted = held[node]
        while node >= leaves:
            a, b = left[node - leaves], right[node - leaves]
            if held[a] != wanted and held[b] != wanted:
                break
            steps.append((node, len(smallest)))
            node = a if held[a] == wanted else b
        smallest.append(node)
    steps.sort()
    return Candidates(np.array(smallest, np.uint32), np.array([group for _, group in steps], np.uint32),
                      np.array([node for node, _ in steps], np.uint32))


def candidate_of_cut(tree: MergeTree, candidates: Candidates, *, regions: int | None, threshold: float | None) -> int:
    """The candidate that a cut makes."""
    made = tree.leaf_count + tree.applied_rows(regions=regions, threshold=threshold)
    return int(np.searchsorted(candidates.step_nodes, made, "left"))


def thresholds_of(tree: MergeTree, candidates: Candidates, candidate: int) -> tuple[float, float]:
    """The thresholds at which a cut makes the candidate."""

    def height(step: int) -> float:
        row = int(candidates.step_nodes[step]) - tree.leaf_count
        return float(tree.height[row]) if row < tree.merged_rows else 1.0

    steps = len(candidates) - 1
    return (0.0 if candidate == 0 else height(candidate - 1), height(candidate) if candidate < steps else 1.0)


def leaves_below(tree: MergeTree, nodes: npt.NDArray[np.uint32]) -> npt.NDArray[np.bool_]:
    """(m,): whether each leaf is below one of the nodes."""
    below = [False] * (tree.leaf_count + len(tree.left))
    for node in nodes.tolist():
        below[node] = True
    left, right = tree.left.tolist(), tree.right.tolist()
    for row in range(len(left) - 1, -1, -1):
        if below[tree.leaf_count + row]:
            below[left[row]] = below[right[row]] = True
    return np.array(below[:tree.leaf_count], bool)


def find_point(place: Place, supervoxels: npt.NDArray[np.uint32], points: npt.NDArray[Any] | None) -> PromptedPoint:
    """The segmented point that a place stands for: that of the pixel, or the one nearest to the position. ValueError."""
    numbers = checked_place(place)
    flat = supervoxels.reshape(-1)
    if len(numbers) == 2:
        column, row = (int(number) for number in numbers)
        if supervoxels.ndim != 2:
            raise ValueError(f"pixel {column},{row}: the cloud is no image; tell a position (x, y, z)")
        height, width = supervoxels.shape
        if column >= width or row >= height:
            raise ValueError(f"pixel {column},{row} is outside the image of {width} x {height} pixels")
        if supervoxels[row, column] == 0:
            raise ValueError(f"pixel {column},{row} has no segmented point")
        return PromptedPoint(row * width + column, int(supervoxels[row, column]), 0.0)
    if points is None:
        raise ValueError("select: a position (x, y, z) needs points=, the cloud that was segmented")
    xyz = np.asarray(points).reshape(-1, 3)
    if len(xyz) != len(flat):
        raise ValueError(f"select: points has {len(xyz)} points, but the result has {len(flat)}")
    segmented = np.flatnonzero(flat)
    if not len(segmented):
        raise ValueError("the cloud has no segmented point")
    squares = ((xyz[segmented].astype(np.float64) - numbers)**2).sum(axis=1)
    nearest = int(np.argmin(squares))
    point = int(segmented[nearest])
    return PromptedPoint(point, int(flat[point]), float(np.sqrt(squares[nearest])))
