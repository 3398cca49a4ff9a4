// SPDX-License-Identifier: Apache-2.0
// Clouds of the caller's arrays: what is accepted, and checked before anything is sent.
import {type Codec} from './codecs.js';
import {type ViewLike} from './view.js';

/** The unit of coordinates; "auto" leaves it to the server. */
export type Unit = 'm' | 'cm' | 'mm' | 'in' | 'ft' | 'auto';

/** A cloud of N points in arrays. */
export interface CloudArrays {
  /**
   * x, y and z of the first point, then those of the second, and so on: 3 N numbers in meters, unless `unit` says
   * otherwise. NaN marks a missing point. Doubles that are far from 0 are sent as doubles.
   */
  xyz: Float32Array | Float64Array;
  /** R, G and B of the first point, then those of the second, and so on: 3 N numbers, sRGB. */
  rgb?: Uint8Array | Uint8ClampedArray;
  /** The columns and rows of an organized cloud, whose points come row by row; N = width * height. */
  width?: number;
  height?: number;
  view?: ViewLike;
  /** By default "planar" if the view is given, and "pcd" if not. */
  codec?: Codec;
  /** Of the codec "quantised": the largest error of a coordinate, meters, 0.0001 to 0.01. By default 0.001. */
  errorBound?: number;
  unit?: Unit;
}

/** N points, checked. */
export interface Points {
  /** Doubles if a coordinate is so far from 0 that floats are too coarse. */
  readonly xyz: Float32Array | Float64Array;
  readonly rgb: Uint8Array | Uint8ClampedArray | undefined;
  readonly count: number;
  readonly width: number;
  /** 1 for a cloud that is not organized. */
  readonly height: number;
}

/** A coordinate beyond this has a float whose last bit is above 0.06 mm, meters. */
const FAR = 512;
const MOST_POINTS = 0x7fffffff;

/** TypeError or RangeError tells what does not fit. */
export function checkedPoints({xyz, rgb, width, height}: CloudArrays): Points {
  if (!(xyz instanceof Float32Array) && !(xyz instanceof Float64Array)) {
    throw new TypeError('xyz: it must be a Float32Array or a Float64Array');
  }
  if (xyz.length === 0) throw new RangeError('xyz: there is no point');
  if (xyz.length % 3 !== 0) throw new RangeError(`xyz: ${xyz.length} numbers are not three for each point`);
  const count = xyz.length / 3;
  if (count > MOST_POINTS) throw new RangeError(`xyz: ${count} points are more than the ${MOST_POINTS} that are possible`);
  if (rgb !== undefined) checkColors(rgb, count);
  return {xyz: xyz instanceof Float64Array ? nearest(xyz) : xyz, rgb, count, ...shape(count, width, height)};
}

function checkColors(rgb: Uint8Array | Uint8ClampedArray, count: number): void {
  if (!(rgb instanceof Uint8Array) && !(rgb instanceof Uint8ClampedArray)) {
    throw new TypeError('rgb: it must be a Uint8Array, with numbers from 0 to 255');
  }
  if (rgb.length !== 3 * count) {
    throw new RangeError(`rgb: it has ${rgb.length} numbers, but must have ${3 * count}, three for each point of xyz`);
  }
}

function shape(count: number, width: number | undefined, height: number | undefined): {width: number, height: number} {
  if (width === undefined && height === undefined) return {width: count, height: 1};
  if (width === undefined || height === undefined) throw new RangeError('width, height: they go together');
  if (!isCount(width) || !isCount(height) || width * height !== count) {
    throw new RangeError(`width, height: ${width} x ${height} is not the number of points, ${count}`);
  }
  return {width, height};
}

function isCount(value: number): boolean {
  return Number.isInteger(value) && value > 0;
}

/** Floats, unless they would be too coarse. */
function nearest(xyz: Float64Array): Float32Array | Float64Array {
  const isFar = xyz.some((value) => Math.abs(value) > FAR && Number.isFinite(value));
  return isFar ? xyz : Float32Array.from(xyz);
}
