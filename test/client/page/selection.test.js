// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {nodesOf, select, sizeAfter, thresholdsOf} from '../../../client/page/src/selection.js';
import {randomNumbers, randomTree} from './random_trees.js';

const holds = (tree, node, leaf) => tree.leavesBelow(node).includes(leaf);

/** All sets of disjoint nodes that hold the positives and no negative, each node with a positive of its own. */
function* validSets(tree, positives, negatives) {
  const clean = [...Array(tree.nodes).keys()].filter(
      (node) => positives.some((leaf) => holds(tree, node, leaf)) && !negatives.some((leaf) => holds(tree, node, leaf)));
  function* extend(chosen, missing) {
    if (missing.length === 0) return yield chosen;
    for (const node of clean.filter((n) => holds(tree, n, missing[0]))) {
      const rest = missing.filter((leaf) => !holds(tree, node, leaf));
      yield* extend([...chosen, node], rest);
    }
  }
  yield* extend([], positives);
}

const pointsOf = (tree, nodes) => nodes.reduce((sum, node) => sum + tree.points[node], 0);

test('the nodes are the fewest that hold the positives and no negative, from the smallest to the largest', () => {
  const random = randomNumbers(6);
  for (let round = 0; round < 2000; ++round) {
    const tree = randomTree(1 + Math.floor(random() * 9), random);
    const positives = [], negatives = [];
    for (let leaf = 0; leaf < tree.leaves; ++leaf) {
      const kind = random();
      if (kind < 0.3) positives.push(leaf); else if (kind < 0.5) negatives.push(leaf);
    }
    if (positives.length === 0) continue;
    const selection = select(tree, positives, negatives);
    const sets = [...validSets(tree, positives, negatives)];
    const fewest = Math.min(...sets.map((set) => set.length));
    const sizes = sets.filter((set) => set.length === fewest).map((set) => pointsOf(tree, set));
    assert.equal(selection.smallest.length, fewest);
    assert.equal(pointsOf(tree, selection.smallest), Math.min(...sizes));
    assert.equal(pointsOf(tree, nodesOf(selection, selection.steps.length)), Math.max(...sizes));
    for (let size = 0; size <= selection.steps.length; ++size) {
      const nodes = nodesOf(selection, size);
      for (const leaf of positives) assert.equal(nodes.filter((node) => holds(tree, node, leaf)).length, 1);
      for (const leaf of negatives) assert.ok(!nodes.some((node) => holds(tree, node, leaf)));
    }
  }
});

test('what is included and excluded cannot be selected', () => {
  const tree = randomTree(5, randomNumbers(7));
  assert.equal(select(tree, [1, 2], [2]), undefined);
});

test('a click alone chooses the segment of the cut', () => {
  const random = randomNumbers(8);
  const tree = randomTree(40, random);
  for (let rows = 0; rows <= tree.rows; ++rows) {
    const cut = tree.cut(rows), leaf = Math.floor(random() * 40);
    const selection = select(tree, [leaf], []);
    assert.deepEqual(nodesOf(selection, sizeAfter(tree, selection, rows)), [cut.nodes[cut.segmentOfLeaf[leaf] - 1]]);
  }
});

test('the thresholds of a single node are those of the node', () => {
  const random = randomNumbers(9);
  const tree = randomTree(40, random);
  const selection = select(tree, [7], []);
  for (let size = 0; size <= selection.steps.length; ++size) {
    assert.deepEqual(thresholdsOf(tree, selection, size), tree.thresholds(nodesOf(selection, size)[0]));
  }
});
