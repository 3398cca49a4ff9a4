// SPDX-License-Identifier: Apache-2.0
// Numbers about segments: centroid, mean color and oriented box, as core's SegmentStatistics defines them.

/** Sums over the points of each supervoxel, relative to the first point, from which those of segments follow. */
const COUNT = 0, POSITION = 1, PRODUCTS = 4, COLOR = 10, SUMS = 13;

export class SupervoxelSums {
  /** `positions` has x, y, z of each point, `rgb` three bytes or is undefined, `supervoxel` numbers from 1; 0 is none. */
  constructor(positions, rgb, supervoxel, leaves) {
    this.origin = positions.slice(0, 3);
    this.hasColor = rgb !== undefined;
    this.sums = new Float64Array(leaves * SUMS);
    const [ox, oy, oz] = this.origin, sums = this.sums;
    for (let i = 0; i < supervoxel.length; ++i) {
      if (supervoxel[i] === 0) continue;
      const at = (supervoxel[i] - 1) * SUMS;
      const x = positions[3 * i] - ox, y = positions[3 * i + 1] - oy, z = positions[3 * i + 2] - oz;
      sums[at] += 1;
      sums[at + 1] += x; sums[at + 2] += y; sums[at + 3] += z;
      sums[at + 4] += x * x; sums[at + 5] += x * y; sums[at + 6] += x * z;
      sums[at + 7] += y * y; sums[at + 8] += y * z; sums[at + 9] += z * z;
      if (rgb === undefined) continue;
      sums[at + 10] += rgb[3 * i]; sums[at + 11] += rgb[3 * i + 1]; sums[at + 12] += rgb[3 * i + 2];
    }
  }

  /** The centroids of all supervoxels: x, y, z each. */
  centroids() {
    const all = new Float32Array(this.sums.length / SUMS * 3);
    for (let leaf = 0; 3 * leaf < all.length; ++leaf) all.set(this.describe([leaf]).centroid, 3 * leaf);
    return all;
  }

  /**
   * The directions in which supervoxels are thinnest, toward the sensor, or up if there is none: x, y, z each.
   * `isCameraView` says that the sensor is at the origin.
   */
  normals(leaves, {isCameraView, sensor}) {
    const eye = isCameraView ? [0, 0, 0] : sensor;
    const all = new Float32Array(3 * leaves);
    for (let leaf = 0; leaf < leaves; ++leaf) {
      const {covariance, centroid} = this.describe([leaf]);
      const normal = principalAxes(covariance)[2];
      const toward = eye ? normal.reduce((sum, v, k) => sum + v * (eye[k] - centroid[k]), 0) : normal[2];
      all.set(normal.map((v) => (toward < 0 ? -v : v)), 3 * leaf);
    }
    return all;
  }

  /** {points, centroid, covariance (xx, xy, xz, yy, yz, zz), color} of the union of supervoxels. */
  describe(leaves) {
    const total = new Float64Array(SUMS);
    for (const leaf of leaves) {
      for (let k = 0; k < SUMS; ++k) total[k] += this.sums[leaf * SUMS + k];
    }
    const n = Math.max(1, total[COUNT]);
    const mean = Array.from(total, (sum) => sum / n);
    const [x, y, z] = mean.slice(POSITION, PRODUCTS);
    const products = [x * x, x * y, x * z, y * y, y * z, z * z];
    return {
      points: total[COUNT],
      centroid: [x, y, z].map((v, i) => v + this.origin[i]),
      covariance: products.map((product, k) => mean[PRODUCTS + k] - product),
      color: this.hasColor ? mean.slice(COLOR) : undefined,
    };
  }
}

/** The unit eigenvectors of a symmetric matrix (xx, xy, xz, yy, yz, zz), greatest eigenvalue first (Jacobi). */
export function principalAxes([xx, xy, xz, yy, yz, zz]) {
  const a = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
  const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 12; ++sweep) {
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) rotate(a, v, p, q);
  }
  const column = (k) => v.map((row) => row[k]);
  return [0, 1, 2].sort((i, k) => a[k][k] - a[i][i]).map(column);
}

/** One rotation of Jacobi's method, which makes a[p][q] zero. */
function rotate(a, v, p, q) {
  if (a[p][q] === 0) return;
  const theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
  const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
  const c = 1 / Math.hypot(t, 1), s = t * c;
  const turn = (rows, get, set) => {
    for (let k = 0; k < 3; ++k) {
      const [first, second] = [get(rows, k, p), get(rows, k, q)];
      set(rows, k, p, c * first - s * second);
      set(rows, k, q, s * first + c * second);
    }
  };
  const byColumn = [(m, k, i) => m[k][i], (m, k, i, value) => { m[k][i] = value; }];
  const byRow = [(m, k, i) => m[i][k], (m, k, i, value) => { m[i][k] = value; }];
  turn(a, ...byColumn);
  turn(a, ...byRow);
  turn(v, ...byColumn);
}

/**
 * The oriented boxes of several segments, by one pass over the points. `segmentOfSupervoxel` has at [supervoxel] the
 * index of a segment, or -1; `described` has what SupervoxelSums.describe says about each.
 * @return {{center: number[], axes: number[][], halfExtents: number[]}[]}
 */
export function orientedBoxes(positions, supervoxel, segmentOfSupervoxel, described) {
  const axes = described.map(({covariance}) => principalAxes(covariance));
  const flat = Float64Array.from(axes.flatMap((a, k) => [...a.flat(), ...described[k].centroid]));
  const low = new Float64Array(3 * described.length).fill(Infinity);
  const high = new Float64Array(3 * described.length).fill(-Infinity);
  for (let i = 0; i < supervoxel.length; ++i) {
    const segment = segmentOfSupervoxel[supervoxel[i]];
    if (segment < 0) continue;
    const at = 12 * segment;
    const x = positions[3 * i] - flat[at + 9], y = positions[3 * i + 1] - flat[at + 10];
    const z = positions[3 * i + 2] - flat[at + 11];
    for (let k = 0; k < 3; ++k) {
      const along = x * flat[at + 3 * k] + y * flat[at + 3 * k + 1] + z * flat[at + 3 * k + 2];
      if (along < low[3 * segment + k]) low[3 * segment + k] = along;
      if (along > high[3 * segment + k]) high[3 * segment + k] = along;
    }
  }
  return described.map(({centroid}, s) => {
    const extent = (k) => [low[3 * s + k], high[3 * s + k]];
    const middle = [0, 1, 2].map((k) => (extent(k)[0] + extent(k)[1]) / 2);
    return {
      center: centroid.map((v, i) => v + middle.reduce((sum, m, k) => sum + m * axes[s][k][i], 0)),
      axes: axes[s],
      halfExtents: [0, 1, 2].map((k) => (extent(k)[1] - extent(k)[0]) / 2),
    };
  });
}
