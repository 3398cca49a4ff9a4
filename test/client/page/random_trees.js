// SPDX-License-Identifier: Apache-2.0
// Random merge trees, and sets of leaves that touch.
import {MergeTree} from '../../../client/page/src/merge_tree.js';

/** A generator of numbers in [0, 1) that depends on its seed alone (mulberry32). */
export function randomNumbers(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** The columns of a tree with some equal weights and some joined rows. */
export function randomColumns(leaves, random) {
  const below = (n) => Math.floor(random() * n);
  const leafPoints = Uint32Array.from({length: leaves}, () => 1 + below(20));
  const alive = Array.from({length: leaves}, (_, leaf) => leaf);
  const rows = Math.max(0, leaves - 1), mergedRows = rows - below(Math.min(rows, 3) + 1);
  const left = [], right = [], weight = [];
  for (let row = 0; row < rows; ++row) {
    const [a] = alive.splice(below(alive.length), 1), [b] = alive.splice(below(alive.length), 1);
    left.push(Math.min(a, b));
    right.push(Math.max(a, b));
    weight.push(row < mergedRows ? below(11) / 10 : 1);
    alive.push(leaves + row);
  }
  return {leafPoints, left: Uint32Array.from(left), right: Uint32Array.from(right), weight: Float64Array.from(weight),
          mergedRows};
}

export const randomTree = (leaves, random) => new MergeTree(randomColumns(leaves, random));

/** Pairs of leaves, at most `count`. */
export function randomEdges(leaves, count, random) {
  const edges = [];
  for (let k = 0; k < count; ++k) {
    const [a, b] = [Math.floor(random() * leaves), Math.floor(random() * leaves)];
    if (a !== b) edges.push(Math.min(a, b), Math.max(a, b));
  }
  return Uint32Array.from(edges);
}
