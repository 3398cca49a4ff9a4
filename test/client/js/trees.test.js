// SPDX-License-Identifier: Apache-2.0
// Merge trees: their cuts, and what clicks choose, compared with plain searches.
import assert from 'node:assert/strict';
import {describe, it} from 'node:test';
import {randomColumns, randomNumbers} from '../page/random_trees.js';
import {ours} from './package.js';

const {MergeTree, NO_NODE} = await ours('tree');
const {leavesBelow, Selection} = await ours('selection');

/** The leaves below each node that is left after so many rows. */
function membersAfter(tree, rows) {
  const members = new Map(Array.from({length: tree.leafCount}, (_, leaf) => [leaf, [leaf]]));
  for (let row = 0; row < rows; ++row) {
    const [a, b] = [tree.left[row], tree.right[row]];
    members.set(tree.leafCount + row, [...members.get(a), ...members.get(b)]);
    members.delete(a);
    members.delete(b);
  }
  return members;
}

function cutRowByRow(tree, rows) {
  const points = (leaves) => leaves.reduce((sum, leaf) => sum + tree.leafPoints[leaf], 0);
  const order = [...membersAfter(tree, rows).values()].sort((a, b) => points(b) - points(a) || Math.min(...a) - Math.min(...b));
  const segments = new Uint32Array(tree.leafCount);
  order.forEach((leaves, i) => leaves.forEach((leaf) => { segments[leaf] = i + 1; }));
  return segments;
}

const trees = Array.from({length: 12}, (_, seed) => {
  const random = randomNumbers(seed);
  return {random, tree: new MergeTree(randomColumns(1 + Math.floor(random() * 40), random))};
});

describe('a cut', () => {
  it('is the one that is made row by row', () => {
    for (const {tree} of trees) {
      const {leafCount, mergedRows, height} = tree;
      for (const regions of [1, 2, 7, leafCount, leafCount + 1, 1000]) {
        assert.deepEqual(tree.cut({regions}), cutRowByRow(tree, Math.max(leafCount - regions, 0)));
      }
      for (const threshold of [0, 0.1, 0.55, 1, ...height]) {
        const rows = height.slice(0, mergedRows).filter((each) => each < threshold).length;
        assert.deepEqual(tree.cut({threshold}), cutRowByRow(tree, rows));
      }
    }
  });

  it('of an empty tree is empty', () => {
    const none = new Uint32Array(0);
    const tree = new MergeTree({leafPoints: none, left: none, right: none, weight: new Float64Array(0), mergedRows: 0});
    assert.deepEqual([tree.cut({regions: 1}), tree.cut({threshold: 1})], [none, none]);
  });

  it('that makes no sense is refused', () => {
    const [{tree}] = trees;
    for (const wrong of [{}, {regions: 1, threshold: 0}, {regions: 0}, {regions: 1.5}, {threshold: -0.1}, {threshold: NaN}]) {
      assert.throws(() => tree.cut(wrong), RangeError);
    }
  });
});

describe('a tree', () => {
  it('is refused if its columns describe none', () => {
    const columns = {leafPoints: Uint32Array.of(3, 2, 1), left: Uint32Array.of(0, 2), right: Uint32Array.of(1, 3),
                     weight: Float64Array.of(0.5, 1), mergedRows: 1};
    assert.deepEqual(new MergeTree(columns).points, Float64Array.of(3, 2, 1, 5, 6));
    for (const [wrong, why] of [
      [{left: Uint32Array.of(0)}, /3 leaves take 2 rows, but left has 1/], [{mergedRows: 3}, /3 of 2 rows are MERGED/],
      [{right: Uint32Array.of(1, 4)}, /row 1: left and right are not two earlier nodes/],
      [{left: Uint32Array.of(1, 2)}, /row 0: left and right/], [{left: Uint32Array.of(0, 1)}, /row 1: a node is merged twice/],
      [{weight: Float64Array.of(NaN, 1)}, /row 0: the weight is not in/], [{weight: Float64Array.of(0.5, 0.9)}, /row 1: it is JOINED/],
    ]) {
      assert.throws(() => new MergeTree({...columns, ...wrong}), why);
    }
  });
});

describe('a selection', () => {
  /** The nodes of a cut that hold positives and no negative, if these are as few as possible: by looking at all nodes. */
  function cleanNodes(tree, negatives) {
    const members = Array.from({length: tree.parent.length}, (_, node) => leavesBelow(tree, [node]));
    return members.map((below) => !negatives.some((leaf) => below[leaf]));
  }

  it('has the fewest nodes that hold all positives and no negative', () => {
    for (const {random, tree} of trees) {
      const anyLeaf = () => Math.floor(random() * tree.leafCount);
      for (let turn = 0; turn < 20; ++turn) {
        const positives = Array.from({length: 1 + turn % 4}, anyLeaf);
        const negatives = Array.from({length: turn % 3}, anyLeaf).filter((leaf) => !positives.includes(leaf));
        const isClean = cleanNodes(tree, negatives);
        const topOf = (leaf) => {
          let top = leaf;
          while (tree.parent[top] !== NO_NODE && isClean[tree.parent[top]]) top = tree.parent[top];
          return top;
        };
        const least = new Set(positives.map(topOf)).size;
        const candidates = new Selection(tree, positives, negatives).candidates();
        for (const {nodes, points} of candidates) {
          assert.equal(nodes.length, least);
          assert.ok(nodes.every((node) => isClean[node]));
          const below = leavesBelow(tree, nodes);
          assert.ok(positives.every((leaf) => below[leaf]));
          assert.equal(points, tree.leafPoints.reduce((sum, count, leaf) => sum + (below[leaf] ? count : 0), 0));
        }
        assert.deepEqual(new Set(candidates.at(-1).nodes), new Set(positives.map(topOf)));
        assert.deepEqual(candidates.map((each) => each.points), candidates.map((each) => each.points).sort((a, b) => a - b));
      }
    }
  });

  it('of one positive is the segment of the cut', () => {
    for (const {tree} of trees) {
      for (const cut of [{regions: 3}, {threshold: 0.5}, {regions: 1}, {threshold: 0}]) {
        const segments = tree.cut(cut);
        const selection = new Selection(tree, [0], []);
        const below = leavesBelow(tree, selection.candidates()[selection.at(cut)].nodes);
        assert.deepEqual([...below], [...segments].map((segment) => Number(segment === segments[0])));
      }
    }
  });

  it('that contradicts itself is refused', () => {
    const [{tree}] = trees;
    assert.throws(() => new Selection(tree, [], []), /nothing is included/);
    assert.throws(() => new Selection(tree, [0], [0]), /supervoxel 1 is both included and excluded/);
  });
});
