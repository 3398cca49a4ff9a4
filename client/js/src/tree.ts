// SPDX-License-Identifier: Apache-2.0
// The merge tree of a scene, and cuts of it.

/** Where a tree is cut: at a threshold, 0 to 1, or to a number of regions. */
export type Cut = {readonly threshold: number, readonly regions?: undefined} |
                  {readonly regions: number, readonly threshold?: undefined};

/** The columns of a merge tree that cannot be derived from others. */
export interface MergeTreeColumns {
  /** m values: the input points of each supervoxel. */
  readonly leafPoints: Uint32Array;
  /** m - 1 values each: the two nodes that each row merges. */
  readonly left: Uint32Array;
  readonly right: Uint32Array;
  /** m - 1 values: how unlike the two regions are, in [0, 1]. */
  readonly weight: Float64Array;
  readonly mergedRows: number;
}

/**
 * The merge tree (dendrogram) of m supervoxels: m leaves, of which leaf s - 1 is supervoxel s, and m - 1 rows.
 *
 * Row r merges the nodes left[r] < right[r] to node m + r, as SciPy's linkage matrix has it. The first `mergedRows` rows
 * are merges of neighbors. The others join regions that do not touch, at weight 1, so that there is one tree: without
 * them it is a forest.
 */
export class MergeTree implements MergeTreeColumns {
  readonly leafPoints: Uint32Array;
  readonly left: Uint32Array;
  readonly right: Uint32Array;
  readonly weight: Float64Array;
  readonly mergedRows: number;
  /** m - 1 values: the maximum weight of the rows 0 to r. */
  readonly height: Float64Array;
  /** 2 m - 1 values: the input points below each node. */
  readonly points: Float64Array;
  /** 2 m - 1 values: the node that each node becomes a part of; NO_NODE for the root. */
  readonly parent: Uint32Array;

  /** RangeError, naming the first wrong row, unless the columns describe a tree. */
  constructor(columns: MergeTreeColumns) {
    this.leafPoints = columns.leafPoints;
    this.left = columns.left;
    this.right = columns.right;
    this.weight = columns.weight;
    this.mergedRows = columns.mergedRows;
    const leaves = this.leafCount;
    const rows = Math.max(leaves - 1, 0);
    for (const name of ['left', 'right', 'weight'] as const) {
      const {length} = this[name];
      if (length !== rows) throw new RangeError(`merge tree: ${leaves} leaves take ${rows} rows, but ${name} has ${length}`);
    }
    if (!(this.mergedRows >= 0 && this.mergedRows <= rows)) {
      throw new RangeError(`merge tree: ${this.mergedRows} of ${rows} rows are MERGED`);
    }
    this.height = new Float64Array(rows);
    this.points = new Float64Array(leaves + rows);
    this.points.set(this.leafPoints);
    this.parent = new Uint32Array(leaves + rows).fill(NO_NODE);
    for (let row = 0; row < rows; ++row) this.#addRow(row);
  }

  /** The number of supervoxels, m. */
  get leafCount(): number {
    return this.leafPoints.length;
  }

  #addRow(row: number): void {
    const {left, right, weight, parent, points} = this;
    const [a, b, node] = [left[row], right[row], this.leafCount + row];
    const refuse = (what: string) => { throw new RangeError(`merge tree, row ${row}: ${what}`); };
    if (a >= b || b >= node) refuse('left and right are not two earlier nodes in order');
    if (parent[a] !== NO_NODE || parent[b] !== NO_NODE) refuse('a node is merged twice');
    if (!(weight[row] >= 0 && weight[row] <= 1)) refuse('the weight is not in [0, 1]');
    if (row >= this.mergedRows && weight[row] !== 1) refuse('it is JOINED, but its weight is not 1');
    parent[a] = parent[b] = node;
    points[node] = points[a] + points[b];
    this.height[row] = row === 0 ? weight[row] : Math.max(this.height[row - 1], weight[row]);
  }

  /** How many rows a cut applies. RangeError unless exactly one of threshold and regions is given, and in its range. */
  appliedRows({threshold, regions}: Cut): number {
    if ((threshold === undefined) === (regions === undefined)) {
      throw new RangeError('cut: give either regions or threshold');
    }
    if (regions !== undefined) {
      if (!Number.isInteger(regions) || regions < 1) {
        throw new RangeError(`regions: ${regions} is not a whole number above 0`);
      }
      return Math.max(this.leafCount - regions, 0);
    }
    const limit = threshold as number;
    if (!(limit >= 0 && limit <= 1)) throw new RangeError(`threshold: ${limit} is not in [0, 1]`);
    let [low, high] = [0, this.mergedRows];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.height[middle] < limit) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /**
   * The segment of each supervoxel, m values.
   *
   * Segments are numbered from 1 by descending number of points, and by their smallest supervoxel if these are equal, as
   * those of the server.
   */
  cut(cut: Cut): Uint32Array {
    const leaves = this.leafCount;
    const rows = this.appliedRows(cut);
    const root = Uint32Array.from({length: leaves + rows}, (_, node) => node);
    for (let row = rows - 1; row >= 0; --row) root[this.left[row]] = root[this.right[row]] = root[leaves + row];
    const roots: number[] = [];  // by their smallest leaves
    const seen = new Uint8Array(leaves + rows);
    for (let leaf = 0; leaf < leaves; ++leaf) {
      if (!seen[root[leaf]]) roots.push(root[leaf]);
      seen[root[leaf]] = 1;
    }
    roots.sort((a, b) => this.points[b] - this.points[a]);  // It is stable.
    const number = new Uint32Array(leaves + rows);
    roots.forEach((node, i) => { number[node] = i + 1; });
    return Uint32Array.from({length: leaves}, (_, leaf) => number[root[leaf]]);
  }
}

/** The parent of the root. It is greater than every node. */
export const NO_NODE = 0xffffffff;
