// SPDX-License-Identifier: Apache-2.0
// Nodes of a merge tree chosen by clicks, as core/include/segserve/selection.hpp defines them.
import {NO_NODE} from './merge_tree.js';

/** For each node whether a leaf of the list is below it. */
function markAncestors(tree, leaves) {
  const marked = new Uint8Array(tree.nodes);
  for (const leaf of leaves) {
    for (let node = leaf; node !== NO_NODE && !marked[node]; node = tree.parent[node]) marked[node] = 1;
  }
  return marked;
}

/**
 * The fewest nodes that hold all positive leaves and no negative one. There is one node for each group of positives:
 * those below the same topmost node without negatives.
 * @return {{smallest: number[], steps: {group: number, node: number}[]}} the smallest such nodes, and the steps that
 *     enlarge them one after the other, in the order of the tree's rows: each puts a group's node in place of its child.
 *     Undefined if a leaf is positive and negative.
 */
export function select(tree, positives, negatives) {
  const isNegative = markAncestors(tree, negatives);
  if (positives.some((leaf) => isNegative[leaf])) return undefined;
  const groups = new Map();  // Topmost node: its positives.
  for (const leaf of new Set(positives)) {
    let top = leaf;
    while (tree.parent[top] !== NO_NODE && !isNegative[tree.parent[top]]) top = tree.parent[top];
    if (groups.has(top)) groups.get(top).push(leaf); else groups.set(top, [leaf]);
  }
  const smallest = [], steps = [];
  const tops = [...groups.keys()].sort((a, b) => Math.min(...groups.get(a)) - Math.min(...groups.get(b)));
  for (const [group, top] of tops.entries()) {
    smallest.push(lowestCommonAncestor(tree, groups.get(top)));
    for (let node = smallest[group]; node !== top;) {
      node = tree.parent[node];
      steps.push({group, node});
    }
  }
  steps.sort((a, b) => a.node - b.node);
  return {smallest, steps};
}

/** Nodes have greater ids than those below them, so that the lower one of two goes up until they meet. */
function lowestCommonAncestor(tree, leaves) {
  return leaves.reduce((a, b) => {
    while (a !== b) {
      if (a < b) a = tree.parent[a]; else b = tree.parent[b];
    }
    return a;
  });
}

/** The nodes after the first `size` steps, one for each group. */
export function nodesOf(selection, size) {
  const nodes = [...selection.smallest];
  for (const {group, node} of selection.steps.slice(0, size)) nodes[group] = node;
  return nodes;
}

/** The number of steps that a cut after `rows` rows makes. */
export function sizeAfter(tree, selection, rows) {
  return selection.steps.filter(({node}) => node < tree.leaves + rows).length;
}

/** The thresholds over which the nodes after `size` steps are all chosen: those t with from < t <= to. */
export function thresholdsOf(tree, selection, size) {
  const heightOf = ({node}) => (tree.isJoined(node) ? 1 : tree.heightOf(node));
  const {smallest, steps} = selection;
  return {from: size === 0 ? 0 : heightOf(steps[size - 1]), to: size < steps.length ? heightOf(steps[size]) : 1};
}
