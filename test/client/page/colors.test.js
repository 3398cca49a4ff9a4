// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import {test} from 'node:test';
import {colorLeaves, colorNodes, difference, PALETTE} from '../../../client/page/src/colors.js';
import {randomEdges, randomNumbers, randomTree} from './random_trees.js';

/** The least difference of the colors of two segments that touch, over all cuts. */
function leastDifference(tree, edges, colorOf) {
  let least = 1;
  for (let rows = 0; rows <= tree.rows; ++rows) {
    const {segmentOfLeaf, nodes} = tree.cut(rows);
    for (let e = 0; e < edges.length; e += 2) {
      const [a, b] = [segmentOfLeaf[edges[e]], segmentOfLeaf[edges[e + 1]]];
      if (a !== b) least = Math.min(least, difference(colorOf[nodes[a - 1]], colorOf[nodes[b - 1]]));
    }
  }
  return least;
}

test('all colors of the palette differ, and can be seen on a dark ground', () => {
  for (let i = 0; i < PALETTE.length; ++i) {
    assert.ok(Math.max(...PALETTE[i].rgb) > 120);
    for (let k = 0; k < i; ++k) assert.ok(difference(i, k) > 0.03);
  }
});

test('a node has the color of its larger child', () => {
  const random = randomNumbers(3);
  const tree = randomTree(200, random);
  const colors = colorNodes(tree, randomEdges(200, 600, random));
  for (let node = tree.leaves; node < tree.nodes; ++node) assert.equal(colors[node], colors[tree.largerChild(node)]);
});

test('neighbors never look alike, in any cut', () => {
  const random = randomNumbers(4);
  for (let round = 0; round < 60; ++round) {
    const leaves = 2 + Math.floor(random() * 60);
    const tree = randomTree(leaves, random), edges = randomEdges(leaves, 2 * leaves, random);
    const least = leastDifference(tree, edges, colorNodes(tree, edges));
    assert.ok(least > 0.1, `${leaves} leaves, seed round ${round}: ${least}`);
  }
});

test('wishes for colors are granted where neighbors look different', () => {
  const random = randomNumbers(11);
  const tree = randomTree(30, random), edges = randomEdges(30, 40, random), {nodes} = tree.cut(20);
  const wishes = new Map([[nodes[0], 7], [nodes[1], 9]]);
  const colors = colorNodes(tree, edges, wishes);
  assert.deepEqual([colors[nodes[0]], colors[nodes[1]]], [7, 9]);
  const same = new Map([...nodes].map((node) => [node, 7]));
  assert.ok(leastDifference(tree, edges, colorNodes(tree, edges, same)) > 0.1);
});

test('neighboring supervoxels never look alike', () => {
  const random = randomNumbers(5);
  const tree = randomTree(300, random), edges = randomEdges(300, 900, random), colors = colorLeaves(tree, edges);
  for (let e = 0; e < edges.length; e += 2) assert.ok(difference(colors[edges[e]], colors[edges[e + 1]]) > 0.1);
});
