// SPDX-License-Identifier: Apache-2.0
// The format of core/codec/quantised/FORMAT.md, with the cells that the C++ encoder chooses.
import {concatenated} from './bytes.js';
import {type Points} from './cloud.js';
import {type Zstd} from './zstd.js';

const ERROR_BOUNDS = [0.0001, 0.01] as const;  // meters
const HEADER_BYTES = 40;

/** RangeError unless the server accepts it. */
export function checkErrorBound(errorBound: number): number {
  const [low, high] = ERROR_BOUNDS;
  if (!(errorBound >= low && errorBound <= high)) {
    throw new RangeError(`errorBound: ${errorBound} m is not in [${low}, ${high}] m`);
  }
  return errorBound;
}

/** RangeError if coordinates are too far away for the error bound. */
export function quantisedBytes(points: Points, errorBound: number, zstd: Zstd): Uint8Array {
  const finite = finitePoints(points);
  const step = cellEdge(points, finite, errorBound);
  const body: Uint8Array[] = finite.length === points.count ? [] : [finiteBits(finite, points.count)];
  const planeCounts = [0, 0, 0];
  for (let axis = 0; axis < 3 && finite.length > 0; ++axis) {
    const planes = bytePlanes(zigzagCells(points.xyz, finite, axis, step));
    planeCounts[axis] = planes.length;
    body.push(...planes);
  }
  if (points.rgb !== undefined) {
    for (let channel = 0; channel < 3; ++channel) body.push(colorDifferences(points.rgb, finite, channel));
  }
  return concatenated([header(points, finite.length, planeCounts, step, errorBound), zstd.compress(concatenated(body))]);
}

/** The indices of the points whose three coordinates are finite. */
function finitePoints({xyz, count}: Points): Uint32Array {
  const finite = new Uint32Array(count);
  let found = 0;
  for (let i = 0; i < count; ++i) {
    if (Number.isFinite(xyz[3 * i]) && Number.isFinite(xyz[3 * i + 1]) && Number.isFinite(xyz[3 * i + 2])) finite[found++] = i;
  }
  return finite.subarray(0, found);
}

function cellEdge({xyz}: Points, finite: Uint32Array, errorBound: number): number {
  let largest = 0;
  for (const i of finite) largest = Math.max(largest, Math.abs(xyz[3 * i]), Math.abs(xyz[3 * i + 1]), Math.abs(xyz[3 * i + 2]));
  const rounding = (largest + errorBound) * 2 ** -23;
  if (rounding > errorBound / 2) {
    throw new RangeError(`errorBound: coordinates of ${largest} m cannot be kept within ${errorBound} m as floats`);
  }
  return 2 * (errorBound - rounding);
}

/** One bit for each point, the first one lowest. */
function finiteBits(finite: Uint32Array, count: number): Uint8Array {
  const bits = new Uint8Array((count + 7) >> 3);
  for (const i of finite) bits[i >> 3] |= 1 << (i & 7);
  return bits;
}

/** The differences between the cells of successive points; signs alternate, so that small numbers stay small. */
function zigzagCells(xyz: Points['xyz'], finite: Uint32Array, axis: number, step: number): Uint32Array {
  const zigzag = new Uint32Array(finite.length);
  const inverse = 1 / step;
  let before = 0;
  for (let k = 0; k < finite.length; ++k) {
    const cell = Math.floor(xyz[3 * finite[k] + axis] * inverse) | 0;
    const difference = (cell - before) | 0;
    zigzag[k] = difference << 1 ^ difference >> 31;
    before = cell;
  }
  return zigzag;
}

/** The lowest bytes of all values, then the next ones, as many as the largest value needs, and at least one. */
function bytePlanes(values: Uint32Array): Uint8Array[] {
  let used = 0;
  for (const value of values) used |= value;
  const count = Math.max(1, (32 - Math.clz32(used) + 7) >> 3);
  return Array.from({length: count}, (_, plane) => {
    const bytes = new Uint8Array(values.length);
    for (let k = 0; k < values.length; ++k) bytes[k] = values[k] >>> 8 * plane;
    return bytes;
  });
}

function colorDifferences(rgb: Uint8Array | Uint8ClampedArray, finite: Uint32Array, channel: number): Uint8Array {
  const differences = new Uint8Array(finite.length);
  let before = 0;
  for (let k = 0; k < finite.length; ++k) {
    const value = rgb[3 * finite[k] + channel];
    differences[k] = value - before;
    before = value;
  }
  return differences;
}

function header({rgb, width, height}: Points, finite: number, planeCounts: number[], step: number,
                errorBound: number): Uint8Array {
  const bytes = new Uint8Array(HEADER_BYTES);
  const view = new DataView(bytes.buffer);
  bytes.set(new TextEncoder().encode('SEGQ'));
  view.setUint16(4, 1, true);
  view.setUint8(6, rgb === undefined ? 0 : 1);
  view.setUint32(8, width, true);
  view.setUint32(12, height, true);
  view.setUint32(16, finite, true);
  bytes.set(planeCounts, 20);
  view.setFloat64(24, step, true);
  view.setFloat64(32, errorBound, true);
  return bytes;
}
