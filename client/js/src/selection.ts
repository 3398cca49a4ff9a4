// SPDX-License-Identifier: Apache-2.0
// Nodes of a merge tree that hold some supervoxels and exclude others, as core/include/segserve/selection.hpp defines them.
import {type Cut, type MergeTree, NO_NODE} from './tree.js';

/** A set of nodes that could be chosen. */
export interface Candidate {
  /** Nodes of the merge tree, of which none holds another. */
  readonly nodes: readonly number[];
  /** The input points below them, and the thresholds between which a cut makes this choice. Servers tell the nodes alone. */
  readonly points?: number;
  readonly thresholds?: readonly [number, number];
}

interface Step {
  readonly group: number;
  readonly node: number;
}

/**
 * The sets of the fewest nodes that hold all positive leaves and no negative one.
 *
 * There is one node for each group of positives: those below the same topmost node without negatives. Candidate 0 has the
 * smallest such nodes; each step puts a group's node in place of its child, in the order of the tree's rows.
 */
export class Selection {
  readonly #tree: MergeTree;
  readonly #smallest: number[] = [];
  readonly #steps: Step[] = [];

  /** RangeError if there is no positive leaf, or one is positive and negative. */
  constructor(tree: MergeTree, positives: readonly number[], negatives: readonly number[]) {
    this.#tree = tree;
    if (positives.length === 0) throw new RangeError('nothing is included');
    const isNegative = markAncestors(tree, negatives);
    const groups = new Map<number, number>();  // topmost node without negatives: lowest node that holds its positives
    for (const leaf of [...new Set(positives)].sort((a, b) => a - b)) {
      if (isNegative[leaf]) throw new RangeError(`supervoxel ${leaf + 1} is both included and excluded`);
      let top = leaf;
      while (tree.parent[top] !== NO_NODE && !isNegative[tree.parent[top]]) top = tree.parent[top];
      const before = groups.get(top);
      groups.set(top, before === undefined ? leaf : lowestCommonAncestor(tree, before, leaf));
    }
    for (const [top, smallest] of groups) this.#addGroup(top, smallest);
    this.#steps.sort((a, b) => a.node - b.node);
  }

  #addGroup(top: number, smallest: number): void {
    const group = this.#smallest.push(smallest) - 1;
    for (let node = smallest; node !== top;) {
      node = this.#tree.parent[node];
      this.#steps.push({group, node});
    }
  }

  /** The candidate that a cut makes. */
  at(cut: Cut): number {
    const made = this.#tree.leafCount + this.#tree.appliedRows(cut);
    return this.#steps.filter(({node}) => node < made).length;
  }

  /** All candidates, from small to large. */
  candidates(): Candidate[] {
    const nodes = [...this.#smallest];
    const all: Candidate[] = [this.#candidate(0, nodes)];
    for (const [k, {group, node}] of this.#steps.entries()) {
      nodes[group] = node;
      all.push(this.#candidate(k + 1, nodes));
    }
    return all;
  }

  /** The thresholds from the first to the second, between which a cut makes a candidate. */
  thresholds(candidate: number): readonly [number, number] {
    const from = candidate === 0 ? 0 : this.#heightOf(this.#steps[candidate - 1]);
    const to = candidate < this.#steps.length ? this.#heightOf(this.#steps[candidate]) : 1;
    return [from, to];
  }

  #candidate(number: number, nodes: readonly number[]): Candidate {
    const points = nodes.reduce((sum, node) => sum + this.#tree.points[node], 0);
    return {nodes: [...nodes], points, thresholds: this.thresholds(number)};
  }

  /** The threshold above which a cut makes the node of a step; 1 if none does. */
  #heightOf({node}: Step): number {
    const row = node - this.#tree.leafCount;
    return row < this.#tree.mergedRows ? this.#tree.height[row] : 1;
  }
}

/** For each node whether a leaf of the list is it or below it. */
function markAncestors(tree: MergeTree, leaves: readonly number[]): Uint8Array {
  const marked = new Uint8Array(tree.parent.length);
  for (const leaf of leaves) {
    for (let node = leaf; node !== NO_NODE && !marked[node]; node = tree.parent[node]) marked[node] = 1;
  }
  return marked;
}

/** Nodes have greater ids than those below them, so that the lower one of two goes up until they meet. */
function lowestCommonAncestor(tree: MergeTree, first: number, second: number): number {
  let [a, b] = [first, second];
  while (a !== b) {
    if (a < b) a = tree.parent[a];
    else b = tree.parent[b];
  }
  return a;
}

/** For each leaf, 1 if it is below one of the nodes, else 0. */
export function leavesBelow(tree: MergeTree, nodes: readonly number[]): Uint8Array {
  const leaves = tree.leafCount;
  const below = new Uint8Array(tree.parent.length);
  for (const node of nodes) below[node] = 1;
  for (let row = tree.left.length - 1; row >= 0; --row) {
    if (below[leaves + row]) below[tree.left[row]] = below[tree.right[row]] = 1;
  }
  return below.subarray(0, leaves);
}
