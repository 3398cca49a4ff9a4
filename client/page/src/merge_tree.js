// SPDX-License-Identifier: Apache-2.0
// The merge tree of a result, and cuts of it, as core/include/segserve/merge_tree.hpp defines them: m leaves, of which
// leaf s - 1 is supervoxel s, and m - 1 rows, of which row r makes node m + r of the nodes left[r] and right[r].

/** The parent of the root. It is greater than every node. */
export const NO_NODE = 0xffffffff;

export class MergeTree {
  /**
   * @param {{leafPoints: Uint32Array, left: Uint32Array, right: Uint32Array, weight: Float64Array, mergedRows: number}}
   *     columns those that cannot be derived from others
   */
  constructor({leafPoints, left, right, weight, mergedRows}) {
    this.leaves = leafPoints.length;
    this.rows = left.length;
    this.nodes = this.leaves + this.rows;
    this.left = left;
    this.right = right;
    this.mergedRows = mergedRows;
    this.#complete(leafPoints, weight);
    this.#orderLeaves();
  }

  #complete(leafPoints, weight) {
    const m = this.leaves;
    this.parent = new Uint32Array(this.nodes).fill(NO_NODE);
    this.points = new Uint32Array(this.nodes);
    this.points.set(leafPoints);
    /** Of rows: the maximum weight so far. */
    this.height = new Float64Array(this.rows);
    for (let row = 0, highest = 0; row < this.rows; ++row) {
      const [left, right] = [this.left[row], this.right[row]];
      this.parent[left] = this.parent[right] = m + row;
      this.points[m + row] = this.points[left] + this.points[right];
      this.height[row] = highest = Math.max(highest, weight[row]);
    }
  }

  /** Gives every node the interval [begin, end) of the leaves below it. The larger child comes first. */
  #orderLeaves() {
    const m = this.leaves;
    this.begin = new Uint32Array(this.nodes);
    this.end = new Uint32Array(this.nodes);
    const count = new Uint32Array(this.nodes).fill(1, 0, m);
    for (let row = 0; row < this.rows; ++row) count[m + row] = count[this.left[row]] + count[this.right[row]];
    if (m > 0) this.end[this.nodes - 1] = m;
    for (let row = this.rows - 1; row >= 0; --row) {
      const heavy = this.largerChild(m + row), light = this.left[row] + this.right[row] - heavy;
      this.begin[heavy] = this.begin[m + row];
      this.end[heavy] = this.begin[light] = this.begin[heavy] + count[heavy];
      this.end[light] = this.end[m + row];
    }
    /** The leaves in the order of the intervals. */
    this.order = new Uint32Array(m);
    for (let leaf = 0; leaf < m; ++leaf) this.order[this.begin[leaf]] = leaf;
  }

  /** The child of more points; of equal ones the first. */
  largerChild(node) {
    const row = node - this.leaves;
    return this.points[this.right[row]] > this.points[this.left[row]] ? this.right[row] : this.left[row];
  }

  isLeaf(node) { return node < this.leaves; }
  heightOf(node) { return this.isLeaf(node) ? 0 : this.height[node - this.leaves]; }
  /** Whether the children of a node have no edge between them. */
  isJoined(node) { return node - this.leaves >= this.mergedRows; }

  /** The supervoxels below a node, as leaves. */
  leavesBelow(node) { return this.order.subarray(this.begin[node], this.end[node]); }

  /** The number of rows that a cut at a threshold applies. */
  rowsAtThreshold(threshold) {
    let low = 0, high = this.mergedRows;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.height[middle] < threshold) low = middle + 1; else high = middle;
    }
    return low;
  }

  /**
   * Where a cut after `rows` rows stands between the finest, 0, and the coarsest, 1: by the logarithm of the number of
   * regions. Thresholds would crowd nearly all merges at one end.
   */
  coarseness(rows) { return this.leaves < 2 ? 0 : 1 - Math.log(this.leaves - rows) / Math.log(this.leaves); }

  /** The number of rows of a cut that stands there. */
  rowsAtCoarseness(coarseness) {
    return this.rowsForRegions(Math.round(Math.max(1, this.leaves) ** (1 - Math.min(Math.max(coarseness, 0), 1))));
  }

  /** The number of rows that a cut to a number of regions applies. */
  rowsForRegions(regions) { return Math.max(0, this.leaves - Math.max(1, regions)); }

  /**
   * The thresholds over which a node is a segment: those t with from < t <= to, and for a leaf t = 0, too. Empty where
   * from = to.
   */
  thresholds(node) {
    const parent = this.parent[node];
    if (this.isJoined(node)) return {from: 1, to: 1};
    const isCut = parent !== NO_NODE && !this.isJoined(parent);
    return {from: this.heightOf(node), to: isCut ? this.heightOf(parent) : 1};
  }

  /** The length of that range. */
  stability(node) {
    const {from, to} = this.thresholds(node);
    return to - from;
  }

  /** The numbers of regions with which a node is a segment: from `fewest` to `most`. */
  regions(node) {
    const m = this.leaves, parent = this.parent[node];
    return {fewest: parent === NO_NODE ? 1 : 2 * m - parent, most: this.isLeaf(node) ? m : 2 * m - node - 1};
  }

  /** The node that is a segment after `rows` rows and holds `node`; a node that does not exist yet stays as it is. */
  ancestorAfter(node, rows) {
    while (this.parent[node] < this.leaves + rows) node = this.parent[node];
    return node;
  }

  /**
   * The partition after the first `rows` rows: the segment of each leaf, and the node of each segment k at [k - 1].
   * Segments are numbered from 1 by descending points, and of equal ones by their smallest leaf.
   */
  cut(rows) {
    const m = this.leaves;
    const root = new Uint32Array(m + rows);
    for (let node = 0; node < root.length; ++node) root[node] = node;
    for (let row = rows - 1; row >= 0; --row) root[this.left[row]] = root[this.right[row]] = root[m + row];
    const roots = [];
    const number = new Uint32Array(root.length);
    for (let leaf = 0; leaf < m; ++leaf) {
      if (number[root[leaf]]++ === 0) roots.push(root[leaf]);
    }
    roots.sort((a, b) => this.points[b] - this.points[a]);  // It is stable.
    roots.forEach((node, i) => { number[node] = i + 1; });
    const segmentOfLeaf = new Uint32Array(m);
    for (let leaf = 0; leaf < m; ++leaf) segmentOfLeaf[leaf] = number[root[leaf]];
    return {rows, segmentOfLeaf, nodes: Uint32Array.from(roots), segments: roots.length};
  }
}
