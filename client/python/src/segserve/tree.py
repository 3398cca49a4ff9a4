# SPDX-License-Identifier: Apache-2.0
"""The merge tree of a scene, and cuts of it in numpy."""
from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, eq=False)
class MergeTree:
    """The merge tree (dendrogram) of m supervoxels: m leaves, of which leaf s - 1 is supervoxel s, and m - 1 rows.

    Row r merges the nodes left[r] < right[r] to node m + r, as SciPy's linkage matrix has it. The first `merged_rows`
    rows are merges of neighbors. The others join regions that do not touch, at weight 1, so that there is one tree:
    without them it is a forest.
    """

    leaf_points: npt.NDArray[np.uint32]  # (m,): input points of each supervoxel
    left: npt.NDArray[np.uint32]  # (m - 1,)
    right: npt.NDArray[np.uint32]  # (m - 1,)
    weight: npt.NDArray[np.float64]  # (m - 1,): dissimilarity of the two regions, in [0, 1]
    merged_rows: int

    def __post_init__(self) -> None:
        """ValueError, naming the first wrong row, unless the columns describe a tree."""
        leaves = len(self.leaf_points)
        rows = max(leaves - 1, 0)
        for name in ("left", "right", "weight"):
            if len(getattr(self, name)) != rows:
                raise ValueError(
                    f"merge tree: {leaves} leaves take {rows} rows, but {name} has {len(getattr(self, name))}")
        if not 0 <= self.merged_rows <= rows:
            raise ValueError(f"merge tree: {self.merged_rows} of {rows} rows are MERGED")
        row = np.arange(rows, dtype=np.int64)
        left, right = self.left.astype(np.int64), self.right.astype(np.int64)
        self._refuse((left >= right) | (right >= leaves + row), "left and right are not two earlier nodes in order")
        nodes = np.concatenate([left, right])
        _, first = np.unique(nodes, return_index=True)
        is_first = np.zeros(len(nodes), bool)
        is_first[first] = True
        self._refuse(~(is_first[:rows] & is_first[rows:]), "a node is merged twice")
        self._refuse(~((self.weight >= 0) & (self.weight <= 1)), "the weight is not in [0, 1]")
        self._refuse((row >= self.merged_rows) & (self.weight != 1), "it is JOINED, but its weight is not 1")

    @staticmethod
    def _refuse(is_wrong: npt.NDArray[np.bool_], what: str) -> None:
        if is_wrong.any():
            raise ValueError(f"merge tree, row {int(np.argmax(is_wrong))}: {what}")

    @property
    def leaf_count(self) -> int:
        """The number of supervoxels, m."""
        return len(self.leaf_points)

    @functools.cached_property
    def height(self) -> npt.NDArray[np.float64]:
        """(m - 1,): the maximum weight of the rows 0 to r."""
        return np.maximum.accumulate(self.weight) if len(self.weight) else np.empty(0)

    @functools.cached_property
    def points(self) -> npt.NDArray[np.int64]:
        """(2 m - 1,): the input points below each node."""
        return self._sums(self.leaf_points)

    @functools.cached_property
    def leaves(self) -> npt.NDArray[np.int64]:
        """(2 m - 1,): the supervoxels below each node."""
        return self._sums(np.ones(self.leaf_count, np.uint32))

    def _sums(self, of_leaves: npt.NDArray[np.uint32]) -> npt.NDArray[np.int64]:
        sums: list[int] = of_leaves.tolist()
        for a, b in zip(self.left.tolist(), self.right.tolist()):
            sums.append(sums[a] + sums[b])
        return np.array(sums, np.int64)

    def applied_rows(self, *, regions: int | None = None, threshold: float | None = None) -> int:
        """How many rows a cut applies. ValueError unless exactly one of the two is given, and in its range."""
        if (regions is None) == (threshold is None):
            raise ValueError("cut: give either regions or threshold")
        if regions is not None:
            if regions != int(regions) or regions < 1:
                raise ValueError(f"regions: {regions} is not a whole number above 0")
            return max(self.leaf_count - int(regions), 0)
        assert threshold is not None
        if not 0 <= threshold <= 1:
            raise ValueError(f"threshold: {threshold} is not in [0, 1]")
        return min(self.merged_rows, int(np.searchsorted(self.height, threshold, "left")))

    def roots(self, rows: int) -> npt.NDArray[np.int64]:
        """(m,): the node to which each leaf belongs after the first `rows` rows."""
        parent = np.arange(self.leaf_count + rows)
        made = np.arange(self.leaf_count, self.leaf_count + rows)
        parent[self.left[:rows]] = made
        parent[self.right[:rows]] = made
        while True:  # Each turn doubles the steps up the tree.
            above = parent[parent]
            if np.array_equal(above, parent):
                return above[:self.leaf_count]
            parent = above

    def cut(self, *, regions: int | None = None, threshold: float | None = None) -> npt.NDArray[np.uint32]:
        """(m,): the segment of each supervoxel, at a number of regions or at a threshold in [0, 1].

        Segments are numbered from 1 by descending number of points, and by their smallest supervoxel if these are
        equal, as those of the server.
        """
        roots = self.roots(self.applied_rows(regions=regions, threshold=threshold))
        _, smallest, member = np.unique(roots, return_index=True, return_inverse=True)
        points = np.bincount(member, weights=self.leaf_points, minlength=len(smallest)).astype(np.int64)
        number = np.empty(len(smallest), np.uint32)
        number[np.lexsort((smallest, -points))] = np.arange(1, len(smallest) + 1, dtype=np.uint32)
        return number[member]

    def components(self) -> npt.NDArray[np.uint32]:
        """(m,): the component of each supervoxel, from 1, by descending number of points. Components do not touch."""
        return self.cut(regions=max(self.leaf_count -
                                    self.merged_rows, 1)) if self.leaf_count else np.empty(0, np.uint32)

    def linkage(self, component: int | None = None) -> npt.NDArray[np.float64]:
        """SciPy's linkage matrix (m - 1, 4) of the whole tree: two nodes, height, number of supervoxels.

        The rows from `merged_rows` on have the height 1 and join components that do not touch. With `component`, the
        matrix of that component alone, whose leaves are `numpy.flatnonzero(tree.components() == component)`. Note that
        SciPy's fcluster applies rows with height <= t, and cut() those with height < t.
        """
        matrix = np.column_stack([self.left, self.right, self.height, self.leaves[self.leaf_count:]]).astype(np.float64)
        if component is None:
            return matrix
        is_member = self.components() == component
        if not is_member.any():
            raise ValueError(f"component: there is none of number {component}")
        rows = matrix[:self.merged_rows]
        is_inside = np.concatenate([is_member, np.zeros(self.merged_rows, bool)])
        for row, left in enumerate(self.left[:self.merged_rows].tolist()):
            is_inside[self.leaf_count + row] = is_inside[left]
        number = np.cumsum(is_inside) - 1
        inside = rows[is_inside[self.leaf_count:]].copy()
        inside[:, :2] = number[inside[:, :2].astype(np.int64)]
        return inside

    def dendrogram(self, **arguments: Any) -> dict[str, Any]:
        """scipy.cluster.hierarchy.dendrogram of the tree, with its arguments. It needs SciPy, and Matplotlib to
        draw."""
        from scipy.cluster import hierarchy

        if self.leaf_count < 2:
            raise ValueError("dendrogram: the tree has less than two supervoxels")
        return dict(hierarchy.dendrogram(self.linkage(), **arguments))
