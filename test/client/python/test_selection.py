# SPDX-License-Identifier: Apache-2.0
"""Selection by places, against brute force. test/e2e compares it with the server."""
import itertools
import unittest

import numpy as np

import segserve
from segserve import result_message, selection
from test_result import good


def random_tree(leaves, random):
    nodes, left, right = list(range(leaves)), [], []
    for row in range(leaves - 1):
        a, b = sorted(int(nodes.pop(random.integers(len(nodes)))) for _ in range(2))
        left.append(a), right.append(b), nodes.append(leaves + row)
    merged = int(random.integers(leaves))
    weight = np.sort(random.random(leaves - 1))
    weight[merged:] = 1
    return segserve.MergeTree(random.integers(1, 9, leaves).astype(np.uint32), np.array(left, np.uint32),
                              np.array(right, np.uint32), weight, merged)


def leaf_sets(tree):
    sets = [frozenset([leaf]) for leaf in range(tree.leaf_count)]
    for a, b in zip(tree.left, tree.right):
        sets.append(sets[a] | sets[b])
    return sets


class Selecting(unittest.TestCase):
    def test_takes_the_fewest_nodes(self):
        random = np.random.default_rng(1)
        for _ in range(300):
            tree = random_tree(int(random.integers(2, 7)), random)
            leaves = random.permutation(tree.leaf_count)
            split = int(random.integers(1, tree.leaf_count + 1))
            include, exclude = leaves[:split][:3], leaves[split:][:3]
            found = selection.select(tree, [int(leaf) + 1 for leaf in include], [int(leaf) + 1 for leaf in exclude])
            sets = leaf_sets(tree)
            clean = [node for node, below in enumerate(sets) if not below & set(exclude)]
            fewest = next(count for count in itertools.count(1) for nodes in itertools.combinations(clean, count)
                          if set(include) <= frozenset().union(*(sets[node] for node in nodes)))
            before = frozenset()
            for candidate in range(len(found)):
                nodes = found.nodes(candidate)
                held = frozenset().union(*(sets[node] for node in nodes))
                self.assertEqual(len(nodes), fewest)
                self.assertTrue(set(include) <= held and not held & set(exclude) and before <= held)
                self.assertEqual(set(np.flatnonzero(selection.leaves_below(tree, nodes))), held)
                before = held

    def test_one_place_gives_the_segment_of_the_cut(self):
        random = np.random.default_rng(2)
        for _ in range(100):
            tree = random_tree(int(random.integers(2, 9)), random)
            cut = {"threshold": float(random.random())} if random.random() < 0.5 else {"regions": int(random.integers(1, 9))}
            leaf = int(random.integers(tree.leaf_count))
            found = selection.select(tree, [leaf + 1])
            cut_both = {"threshold": None, "regions": None} | cut
            below = selection.leaves_below(tree, found.nodes(selection.candidate_of_cut(tree, found, **cut_both)))
            segments = tree.cut(**cut)
            np.testing.assert_array_equal(below, segments == segments[leaf])

    def test_results_select_by_pixels_and_positions(self):
        found = result_message.decode(good(), (2, 3), ("labels", "supervoxels", "tree"))
        by_pixel = found.select([(0, 0)], exclude=[(0, 1)])
        np.testing.assert_array_equal(by_pixel.mask, found.labels == 1)
        points = np.arange(18, dtype=np.float32).reshape(2, 3, 3)
        by_position = found.select([points[0, 0] + 0.25], exclude=[points[1, 0]], points=points)
        np.testing.assert_array_equal(by_position.mask, by_pixel.mask)
        self.assertAlmostEqual(by_position.include[0].distance, 0.25 * 3**0.5)
        self.assertEqual((by_pixel.thresholds, by_pixel.stability), ((0.25, 1.0), 0.75))
        self.assertTrue(found.select([(0, 0)], larger=9).mask[1, 1])
        for places, text in (([(9, 0)], "outside"), ([(2, 1)], "no segmented point"), ([(0.5, 0)], "neither"),
                             ([(0, 0, 0)], "needs points="), ([], "nothing is included")):
            with self.assertRaisesRegex(ValueError, text):
                found.select(places)

    def test_prompts_are_checked(self):
        message = segserve.Prompts([(1, 2), (0.5, 0, -1)], [(3, 4)], larger=-1).message()
        self.assertEqual((message.include[0].pixel.row, message.include[1].position.z, message.larger), (2, -1, -1))
        for places in ([], [(1, )], [(-1, 0)], [(0, 0, float("nan"))]):
            with self.assertRaises(ValueError):
                segserve.Prompts(places)

    def test_a_selection_that_lies_is_noticed(self):
        for change in (lambda s: s.smallest.append(9), lambda s: setattr(s, "candidate", 5),
                       lambda s: s.step_groups.append(0), lambda s: setattr(s.thresholds, "upper", 2),
                       lambda s: setattr(s.include[0], "supervoxel", 4)):
            message = good()
            chosen = message.selection
            chosen.smallest.append(3)
            chosen.thresholds.lower, chosen.thresholds.upper = 0.25, 1
            chosen.include.add(point=0, supervoxel=1)
            self.assertEqual(result_message.decode(message, (6,), ()).selection.nodes.tolist(), [3])
            change(chosen)
            with self.assertRaises(segserve.Internal):
                result_message.decode(message, (6,), ())
