// SPDX-License-Identifier: Apache-2.0
// The state of one result: its cut, what is chosen and what the pointer is over. It knows no screen.
import {colorLeaves, colorNodes, PALETTE} from './colors.js';
import {GroundTruth} from './ground_truth.js';
import {PlaceGrid} from './nearest.js';
import {nodesOf, select, sizeAfter, thresholdsOf} from './selection.js';
import {orientedBoxes, SupervoxelSums} from './statistics.js';

export class Side {
  constructor({name, method, tree, edges, normals, supervoxel, threshold, regions, cloud}) {
    Object.assign(this, {name, method, tree, edges, supervoxel, cloud});
    this.colorOfNode = colorNodes(tree, edges);
    this.colorOfLeaf = colorLeaves(tree, edges);
    this.sums = new SupervoxelSums(cloud.positions, cloud.rgb, supervoxel, tree.leaves);
    this.centroids = this.sums.centroids();
    this.normals = normals ?? this.sums.normals(tree.leaves, cloud);
    this.truth = cloud.truth && new GroundTruth(cloud.truth, supervoxel, tree.leaves, cloud.truthLabels.length);
    this.clicks = [];
    if (regions === null) this.setThreshold(threshold); else this.setRows(tree.rowsForRegions(regions));
  }

  /** Gives segments the colors of those of another side of the same cloud with which they share most points. */
  matchColors(other) {
    const shared = new Map();
    for (let point = 0; point < this.supervoxel.length; ++point) {
      const [mine, its] = [this.nodeOfPoint(point), other.nodeOfPoint(point)];
      if (mine === undefined || its === undefined) continue;
      const key = mine * other.tree.nodes + its;
      shared.set(key, (shared.get(key) ?? 0) + 1);
    }
    this.#takeColors(other, shared);
  }

  /** Gives segments the colors of those of the frame before that are nearest: by supervoxels, weighed by their points. */
  matchNear(other) {
    const places = new PlaceGrid(other.centroids, Math.max(1e-3, other.cloud.radius / 12));
    const shared = new Map();
    for (let leaf = 0; leaf < this.tree.leaves; ++leaf) {
      const near = places.nearest(...this.centroids.subarray(3 * leaf, 3 * leaf + 3));
      if (near === undefined) continue;
      const key = this.#nodeOfLeaf(leaf) * other.tree.nodes + other.#nodeOfLeaf(near);
      shared.set(key, (shared.get(key) ?? 0) + this.tree.points[leaf]);
    }
    this.#takeColors(other, shared);
  }

  /** `shared` has weights of pairs: mine * other.tree.nodes + its. */
  #takeColors(other, shared) {
    const taken = new Set(), preferred = new Map();
    // Each segment of the other side gives its color away once, to where most of it is.
    for (const [key] of [...shared].sort((a, b) => b[1] - a[1])) {
      const [mine, its] = [Math.floor(key / other.tree.nodes), key % other.tree.nodes];
      if (preferred.has(mine) || taken.has(its)) continue;
      taken.add(its);
      preferred.set(mine, other.colorOfNode[its]);
    }
    this.colorOfNode = colorNodes(this.tree, this.edges, preferred);
  }

  #nodeOfLeaf(leaf) { return this.cut.nodes[this.cut.segmentOfLeaf[leaf] - 1]; }

  setThreshold(threshold) {
    this.setRows(this.tree.rowsAtThreshold(threshold));
    this.threshold = threshold;
  }

  /** Cuts the tree after so many rows. */
  setRows(rows) {
    this.rows = Math.min(Math.max(0, rows), this.tree.rows);
    const {from, to} = this.thresholds;
    this.threshold = from < to || this.rows === 0 ? to : undefined;
    this.cut = this.tree.cut(this.rows);
    this.boxesOfCut = undefined;
  }

  /** The thresholds at which the cut is the current one: those t with from < t <= to. */
  get thresholds() {
    const {height, mergedRows} = this.tree, rows = this.rows;
    if (rows > mergedRows) return {from: 1, to: 1};
    return {from: rows > 0 ? height[rows - 1] : 0, to: rows < mergedRows ? height[rows] : 1};
  }

  /** sRGB bytes of a node. */
  rgbOfNode(node) { return PALETTE[this.colorOfNode[node]].rgb; }

  /** The node of the current cut that holds a point; undefined if the point is not segmented. */
  nodeOfPoint(point) {
    const leaf = this.leafOfPoint(point);
    return leaf === undefined ? undefined : this.cut.nodes[this.cut.segmentOfLeaf[leaf] - 1];
  }

  leafOfPoint(point) {
    return point === undefined || this.supervoxel[point] === 0 ? undefined : this.supervoxel[point] - 1;
  }

  /** Adds a click. A leaf that is included and excluded keeps what was said last. */
  click(point, isPositive) {
    const leaf = this.leafOfPoint(point);
    if (leaf === undefined) return;
    this.clicks = this.clicks.filter((click) => click.leaf !== leaf);
    this.clicks.push({leaf, point, isPositive});
    this.#select();
    if (this.selection) this.size = sizeAfter(this.tree, this.selection, this.rows);
  }

  /** Chooses a node of the tree. */
  choose(node) {
    this.clicks = [{leaf: this.tree.leavesBelow(node)[0], isPositive: true}];
    this.#select();
    this.size = this.selection.steps.filter((step) => step.node <= node).length;
  }

  #select() {
    const leaves = (isPositive) => this.clicks.filter((c) => c.isPositive === isPositive).map((c) => c.leaf);
    const positives = leaves(true);
    this.selection = positives.length > 0 ? select(this.tree, positives, leaves(false)) : undefined;
  }

  clear() {
    this.clicks = [];
    this.selection = undefined;
  }

  /** Takes the next larger (1) or smaller (-1) candidate. */
  resize(steps) {
    if (this.selection) this.size = Math.min(Math.max(0, this.size + steps), this.selection.steps.length);
  }

  get chosenNodes() { return this.selection ? nodesOf(this.selection, this.size) : []; }

  /** What there is to say about the chosen nodes together. */
  describeChosen() {
    const nodes = this.chosenNodes;
    const leaves = nodes.flatMap((node) => [...this.tree.leavesBelow(node)]);
    const described = this.sums.describe(leaves);
    const [box] = this.#boxes([leaves], [described]);
    const {steps} = this.selection, rowsUpTo = (node) => node - this.tree.leaves;
    const range = nodes.length === 1 ? this.tree.thresholds(nodes[0])
                                     : thresholdsOf(this.tree, this.selection, this.size);
    return {...described, box, nodes, leaves, thresholds: range,
            firstRows: this.size > 0 ? rowsUpTo(steps[this.size - 1].node) + 1 : 0,
            lastRows: this.size < steps.length ? rowsUpTo(steps[this.size].node) : this.tree.rows,
            candidates: steps.length + 1};
  }

  #boxes(groups, described) {
    const {supervoxel, cloud, tree} = this;
    const segmentOfSupervoxel = new Int32Array(tree.leaves + 1).fill(-1);
    groups.forEach((leaves, k) => { for (const leaf of leaves) segmentOfSupervoxel[leaf + 1] = k; });
    return orientedBoxes(cloud.positions, supervoxel, segmentOfSupervoxel, described);
  }

  /** The boxes of the largest segments of the cut. */
  boxes(most) {
    const groups = Array.from(this.cut.nodes.slice(0, most), (node) => this.tree.leavesBelow(node));
    this.boxesOfCut ??= this.#boxes(groups, groups.map((leaves) => this.sums.describe(leaves)));
    return this.boxesOfCut;
  }
}
