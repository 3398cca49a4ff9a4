# SPDX-License-Identifier: Apache-2.0
"""Merge trees and their cuts, compared with a cut that is made row by row."""
import unittest

import numpy as np

from segserve import MergeTree

try:
    from scipy.cluster import hierarchy
except ImportError:
    hierarchy = None


def random_tree(leaves, joined, seed):
    """A tree whose last `joined` rows are JOINED. Weights are not monotone, and many numbers of points are equal."""
    rng = np.random.default_rng(seed)
    alive, left, right = list(range(leaves)), [], []
    for row in range(leaves - 1):
        a, b = sorted(rng.choice(len(alive), 2, replace=False))
        left.append(min(alive[a], alive[b]))
        right.append(max(alive[a], alive[b]))
        del alive[b], alive[a]
        alive.append(leaves + row)
    weight = rng.integers(0, 50, leaves - 1) / 50
    weight[len(weight) - joined:] = 1
    columns = [np.array(column, np.uint32) for column in (rng.integers(1, 4, leaves), left, right)]
    return MergeTree(*columns, weight, leaves - 1 - joined)


def naive_cut(tree, rows):
    members = {leaf: [leaf] for leaf in range(tree.leaf_count)}
    for row in range(rows):
        members[tree.leaf_count + row] = members.pop(int(tree.left[row])) + members.pop(int(tree.right[row]))
    order = sorted(members.values(),
                   key=lambda leaves: (-sum(int(tree.leaf_points[leaf]) for leaf in leaves), min(leaves)))
    segment = np.zeros(tree.leaf_count, int)
    for number, leaves in enumerate(order, start=1):
        segment[leaves] = number
    return segment.tolist()


class Cuts(unittest.TestCase):
    def test_equal_those_made_row_by_row(self):
        for seed in range(8):
            tree = random_tree(40, 3 * (seed % 3), seed)
            for regions in (1, 2, 7, 39, 40, 41, 1000):
                self.assertEqual(tree.cut(regions=regions).tolist(), naive_cut(tree, max(40 - regions, 0)))
            for threshold in (0, 0.02, 0.5, tree.weight[3], 1):
                rows = sum(height < threshold for height in np.maximum.accumulate(tree.weight[:tree.merged_rows]))
                self.assertEqual(tree.cut(threshold=threshold).tolist(), naive_cut(tree, rows))

    def test_of_a_long_chain(self):
        count = 3000
        chain = MergeTree(np.ones(count, np.uint32), np.array([0, *range(2, count)], np.uint32),
                          np.array([1, *range(count, 2 * count - 2)], np.uint32), np.zeros(count - 1), count - 1)
        self.assertEqual(chain.cut(threshold=1).tolist(), [1] * count)
        self.assertEqual(chain.cut(regions=2).tolist(), [1] * (count - 1) + [2])

    def test_of_trees_without_rows(self):
        none = np.empty(0, np.uint32)
        for leaves in (0, 1):
            tree = MergeTree(np.ones(leaves, np.uint32), none, none, np.empty(0), 0)
            self.assertEqual(tree.cut(regions=3).tolist(), [1] * leaves)
            self.assertEqual(tree.cut(threshold=0.5).tolist(), [1] * leaves)
            self.assertEqual((tree.linkage().shape, tree.components().tolist()), ((0, 4), [1] * leaves))

    def test_that_make_no_sense_are_refused(self):
        tree = random_tree(5, 0, 1)
        for wrong in ({}, {"regions": 2, "threshold": 0.1}, {"regions": 0}, {"regions": 1.5}, {"threshold": -0.1},
                      {"threshold": 1.1}, {"threshold": float("nan")}):
            with self.subTest(wrong), self.assertRaises(ValueError):
                tree.cut(**wrong)


class Trees(unittest.TestCase):
    def test_that_are_none_are_refused_by_row(self):
        good = random_tree(6, 1, 1)

        def changed(**columns):
            return MergeTree(*(columns.get(name, getattr(good, name))
                               for name in ("leaf_points", "left", "right", "weight", "merged_rows")))

        def column(values, row, value):
            values = values.copy()
            values[row] = value
            return values

        changed()
        for wrong, message in (({"right": good.right[1:]}, "5 rows"), ({"merged_rows": 6}, "MERGED"),
                               ({"left": column(good.left, 2, 99)}, "row 2: left and right"),
                               ({"right": column(good.right, 0, 6)}, "row 0: left and right"),
                               ({"left": column(good.left, 4, good.left[1])}, "row 4: a node is merged twice"),
                               ({"weight": column(good.weight, 1, np.nan)}, "row 1: the weight"),
                               ({"weight": column(good.weight, 4, 0.5)}, "row 4: it is JOINED")):
            with self.subTest(wrong), self.assertRaisesRegex(ValueError, message):
                changed(**wrong)

    def test_sums(self):
        tree = random_tree(20, 0, 3)
        self.assertEqual(tree.points[-1], tree.leaf_points.sum())
        self.assertEqual(tree.leaves[-1], 20)

    @unittest.skipIf(hierarchy is None, "there is no SciPy")
    def test_fit_scipy(self):
        tree = random_tree(40, 4, 5)
        linkage = tree.linkage()
        self.assertTrue(hierarchy.is_valid_linkage(linkage) and hierarchy.is_monotonic(linkage))
        theirs = hierarchy.fcluster(linkage, 5, "maxclust")
        ours = tree.cut(regions=5)
        self.assertEqual(len(set(zip(theirs.tolist(), ours.tolist()))), 5)
        self.assertEqual(sorted(tree.dendrogram(no_plot=True)["leaves"]), list(range(40)))

    @unittest.skipIf(hierarchy is None, "there is no SciPy")
    def test_each_component_is_a_linkage(self):
        tree = random_tree(40, 4, 5)
        components = tree.components()
        self.assertEqual(components.max(), 5)
        for component in range(1, 6):
            leaves = np.flatnonzero(components == component)
            linkage = tree.linkage(component)
            self.assertEqual(linkage.shape, (len(leaves) - 1, 4))
            if len(leaves) < 2:
                continue
            self.assertTrue(hierarchy.is_valid_linkage(linkage))
            self.assertEqual(linkage[-1, 3], len(leaves))
            merged = tree.cut(threshold=0.5)[leaves]
            theirs = hierarchy.fcluster(linkage, 0.5 - 1e-9, "distance")
            self.assertEqual(len(set(zip(merged.tolist(), theirs.tolist()))), len(set(merged.tolist())))
        with self.assertRaises(ValueError):
            tree.linkage(6)


if __name__ == "__main__":
    unittest.main()
