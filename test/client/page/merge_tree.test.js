// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {MergeTree} from '../../../client/page/src/merge_tree.js';
import {randomNumbers, randomTree} from './random_trees.js';

// Supervoxels 1 to 4: the first two merge at 0.1, the last two at 0.4, and both are joined without an edge.
const SMALL = new MergeTree({leafPoints: Uint32Array.of(5, 10, 20, 1), left: Uint32Array.of(0, 2, 4),
                             right: Uint32Array.of(1, 3, 5), weight: Float64Array.of(0.1, 0.4, 1), mergedRows: 2});

test('a threshold applies the merged rows below it', () => {
  assert.deepEqual([0, 0.1, 0.11, 0.4, 0.5, 1].map((t) => SMALL.rowsAtThreshold(t)), [0, 0, 1, 1, 2, 2]);
});

test('a number of regions applies joined rows, too', () => {
  assert.deepEqual([1, 2, 3, 4, 9].map((d) => SMALL.rowsForRegions(d)), [3, 2, 1, 0, 0]);
});

test('segments are numbered by descending points, equal ones by their smallest leaf', () => {
  assert.deepEqual([...SMALL.cut(1).segmentOfLeaf], [2, 2, 1, 3]);
  assert.deepEqual([...SMALL.cut(2).segmentOfLeaf], [2, 2, 1, 1]);
  const equal = new MergeTree({leafPoints: Uint32Array.of(3, 3), left: Uint32Array.of(0), right: Uint32Array.of(1),
                               weight: Float64Array.of(0.5), mergedRows: 1});
  assert.deepEqual([...equal.cut(0).segmentOfLeaf], [1, 2]);
});

test('a tree may have one leaf or none', () => {
  const tree = (leaves) => new MergeTree({leafPoints: new Uint32Array(leaves), left: new Uint32Array(0),
                                          right: new Uint32Array(0), weight: new Float64Array(0), mergedRows: 0});
  assert.equal(tree(0).cut(tree(0).rowsForRegions(1)).segments, 0);
  assert.equal(tree(1).cut(tree(1).rowsAtThreshold(1)).segments, 1);
  assert.deepEqual(tree(1).thresholds(0), {from: 0, to: 1});
});

test('the height of a row is the greatest weight so far', () => {
  const tree = new MergeTree({leafPoints: Uint32Array.of(1, 1, 1), left: Uint32Array.of(0, 2), right: Uint32Array.of(1, 3),
                              weight: Float64Array.of(0.7, 0.2), mergedRows: 2});
  assert.deepEqual([...tree.height], [0.7, 0.7]);
  assert.equal(tree.stability(3), 0);  // Merged with its sibling at the height at which it begins.
});

test('a node is a segment at the thresholds and numbers of regions that it tells, and at no others', () => {
  const random = randomNumbers(1);
  for (let round = 0; round < 300; ++round) {
    const tree = randomTree(1 + Math.floor(random() * 12), random);
    for (let node = 0; node < tree.nodes; ++node) {
      const {from, to} = tree.thresholds(node), {fewest, most} = tree.regions(node);
      for (let t = 0; t <= 1.0001; t += 0.05) {
        const threshold = Math.min(1, Math.round(t * 100) / 100);
        const isSegment = tree.cut(tree.rowsAtThreshold(threshold)).nodes.includes(node);
        assert.equal(isSegment, (from < threshold || (threshold === 0 && tree.isLeaf(node))) && threshold <= to);
      }
      for (let regions = 1; regions <= tree.leaves; ++regions) {
        const isSegment = tree.cut(tree.rowsForRegions(regions)).nodes.includes(node);
        assert.equal(isSegment, fewest <= regions && regions <= most);
      }
    }
  }
});

test('the leaves below a node are those of its children', () => {
  const random = randomNumbers(2);
  const tree = randomTree(50, random);
  for (let row = 0; row < tree.rows; ++row) {
    const leaves = (node) => [...tree.leavesBelow(node)].sort((a, b) => a - b);
    const children = [...leaves(tree.left[row]), ...leaves(tree.right[row])].sort((a, b) => a - b);
    assert.deepEqual(leaves(tree.leaves + row), children);
  }
});
