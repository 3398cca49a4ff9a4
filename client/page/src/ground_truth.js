// SPDX-License-Identifier: Apache-2.0
// Compares segments with labels that the file has. Label 0 means that a point is not labeled.

const RIGHT = 0, LEAKED = 1, SPLIT = 2;

export class GroundTruth {
  /** `truth` has for each point an index into the file's labels, of which 0 is "not labeled". */
  constructor(truth, supervoxel, leaves, labels) {
    const count = new Map();
    for (let i = 0; i < truth.length; ++i) {
      if (truth[i] === 0 || supervoxel[i] === 0) continue;
      const key = (supervoxel[i] - 1) * labels + truth[i];
      count.set(key, (count.get(key) ?? 0) + 1);
    }
    this.leaves = leaves;
    this.labels = labels;
    this.cells = [...count].map(([key, points]) => ({leaf: Math.floor(key / labels), label: key % labels, points}));
  }

  /**
   * For each leaf the label that most points of its segment have, and whether its segment is the largest part of that
   * label. A point of another label leaked into the segment; a point of the label is split off unless the segment is
   * the largest part. `rates` has the shares of points that are right, leaked and split.
   */
  compare(cut) {
    const points = new Map();
    for (const {leaf, label, points: n} of this.cells) {
      const key = cut.segmentOfLeaf[leaf] * this.labels + label;
      points.set(key, (points.get(key) ?? 0) + n);
    }
    const major = new Uint32Array(cut.segments + 1);
    const most = new Float64Array(cut.segments + 1);
    for (const [key, n] of points) {
      const segment = Math.floor(key / this.labels);
      if (n > most[segment]) [most[segment], major[segment]] = [n, key % this.labels];
    }
    const largest = new Float64Array(this.labels), main = new Uint32Array(this.labels);
    for (let segment = 1; segment <= cut.segments; ++segment) {
      const label = major[segment];
      if (most[segment] > largest[label]) [largest[label], main[label]] = [most[segment], segment];
    }
    const isMain = (segment) => main[major[segment]] === segment;
    return {
      label: Uint32Array.from(cut.segmentOfLeaf, (segment) => major[segment]),
      isMain: Uint8Array.from(cut.segmentOfLeaf, (segment) => Number(isMain(segment))),
      rates: this.#rates(points, major, isMain),
    };
  }

  #rates(points, major, isMain) {
    const sums = [0, 0, 0];
    for (const [key, n] of points) {
      const segment = Math.floor(key / this.labels);
      const verdict = key % this.labels !== major[segment] ? LEAKED : isMain(segment) ? RIGHT : SPLIT;
      sums[verdict] += n;
    }
    const total = Math.max(1, sums[0] + sums[1] + sums[2]);
    return {right: sums[RIGHT] / total, leaked: sums[LEAKED] / total, split: sums[SPLIT] / total};
  }
}
