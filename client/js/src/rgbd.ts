// SPDX-License-Identifier: Apache-2.0
// Encodes the images of an RGB-D camera.
import {create} from '@bufbuild/protobuf';

import {bytesOf, concatenated} from './bytes.js';
import {CloudSchema, type Intrinsics as IntrinsicsMessage, IntrinsicsSchema, RgbdImagesSchema, ViewKind,
        ViewSchema} from './gen/segserve/v1/cloud_pb.js';
import {BlockList, Payload} from './payload.js';

/** A pinhole camera without distortion, pixels. The center of the first pixel is (0, 0). */
export interface Intrinsics {
  fx: number;
  fy: number;
  cx: number;
  cy: number;
}

/** The pixels of an image, row by row. */
export interface Pixels<Data> {
  width: number;
  height: number;
  data: Data;
}

/** The images of an RGB-D camera, which make a cloud of the depth's rows and columns in the view of a camera. */
export interface RgbdImages {
  /** Pixels, or the bytes of a PNG, PGM or PFM file. 0, 65535 and NaN mean "no depth". */
  depth: Pixels<Uint16Array | Float32Array> | Uint8Array;
  /**
   * Pixels with 1 (gray), 3 (RGB) or 4 (RGBA, as ImageData has it; alpha is ignored) numbers each, or the bytes of a PNG,
   * JPEG, PPM or PGM file. It is seen from the place of the depth. Its size may be another than that of the depth.
   */
  color?: Pixels<Uint8Array | Uint8ClampedArray> | Uint8Array;
  intrinsics: Intrinsics;
  /** Meters per unit of depth, at most 1; by default 0.001 for integers, and 1 for floats. */
  depthScale?: number;
  /** Those of the color, if both images do not show the same part of the scene. */
  colorIntrinsics?: Intrinsics;
}

const MILLIMETER = 0.001;

/** TypeError, RangeError: the images or numbers make no sense. */
export function encodeRgbdImages(images: RgbdImages): Payload {
  const {depth, color, intrinsics, depthScale, colorIntrinsics} = images;
  const file = depthFile(depth);
  const size = sizeOfFile(file);
  const camera = checkedIntrinsics('intrinsics', intrinsics);
  const blocks = new BlockList();
  const value = create(RgbdImagesSchema, {
    depth: blocks.add(file),
    depthScale: depthScale ?? (holdsFloats(file) ? 1 : MILLIMETER),
    fx: camera.fx,
    fy: camera.fy,
    cx: camera.cx,
    cy: camera.cy,
  });
  if (color !== undefined) value.color = blocks.add(colorFile(color));
  if (colorIntrinsics !== undefined) value.colorIntrinsics = checkedIntrinsics('colorIntrinsics', colorIntrinsics);
  const header = create(CloudSchema, {
    width: size?.width ?? 0,
    height: size?.height ?? 0,
    view: create(ViewSchema, {kind: ViewKind.CAMERA}),
    payload: {case: 'rgbd', value},
  });
  return new Payload(header, blocks.bytes, size && size.width * size.height);
}

function checkedIntrinsics(what: string, {fx, fy, cx, cy}: Intrinsics): IntrinsicsMessage {
  if (![fx, fy, cx, cy].every(Number.isFinite) || fx <= 0 || fy <= 0) {
    throw new RangeError(`${what}: fx ${fx}, fy ${fy}, cx ${cx}, cy ${cy} are not finite with fx and fy above 0`);
  }
  return create(IntrinsicsSchema, {fx, fy, cx, cy});
}

function ascii(text: string): Uint8Array {
  return new TextEncoder().encode(text);
}

/** The numbers of each pixel. RangeError unless that is a whole number above 0. */
function channels(what: string, {width, height, data}: Pixels<{readonly length: number}>): number {
  const perPixel = data.length / (width * height);
  if (!Number.isInteger(width) || !Number.isInteger(height) || width < 1 || height < 1 || !Number.isInteger(perPixel) ||
      perPixel < 1) {
    throw new RangeError(`${what}: ${data.length} numbers are no image of ${width} x ${height} pixels`);
  }
  return perPixel;
}

function depthFile(depth: RgbdImages['depth']): Uint8Array {
  if (depth instanceof Uint8Array) return new Uint8Array(depth);
  const {width, height, data} = depth;
  const isFloat = data instanceof Float32Array;
  if (!isFloat && !(data instanceof Uint16Array)) {
    throw new TypeError('depth: its data must be a Uint16Array or a Float32Array; or give the bytes of a file');
  }
  if (channels('depth', depth) !== 1) throw new RangeError('depth: it has more than one number for each pixel');
  return isFloat ? pfm(width, height, data) : pgm16(width, height, data);
}

/** The last row comes first. */
function pfm(width: number, height: number, data: Float32Array): Uint8Array {
  const rows = new Float32Array(data.length);
  for (let row = 0; row < height; ++row) {
    rows.set(data.subarray(row * width, (row + 1) * width), (height - 1 - row) * width);
  }
  return concatenated([ascii(`Pf\n${width} ${height}\n-1.0\n`), bytesOf(rows)]);
}

function pgm16(width: number, height: number, data: Uint16Array): Uint8Array {
  const bytes = new Uint8Array(2 * data.length);  // big endian
  for (let i = 0; i < data.length; ++i) {
    bytes[2 * i] = data[i] >> 8;
    bytes[2 * i + 1] = data[i];
  }
  return concatenated([ascii(`P5\n${width} ${height}\n65535\n`), bytes]);
}

function colorFile(color: NonNullable<RgbdImages['color']>): Uint8Array {
  if (color instanceof Uint8Array) return new Uint8Array(color);
  const {width, height, data} = color;
  if (!(data instanceof Uint8Array) && !(data instanceof Uint8ClampedArray)) {
    throw new TypeError('color: its data must be a Uint8Array; or give the bytes of a file');
  }
  const perPixel = channels('color', color);
  if (![1, 3, 4].includes(perPixel)) {
    throw new RangeError(`color: ${perPixel} numbers for each pixel are neither gray, RGB nor RGBA`);
  }
  const head = ascii(`${perPixel === 1 ? 'P5' : 'P6'}\n${width} ${height}\n255\n`);
  return concatenated([head, perPixel === 4 ? withoutAlpha(data) : new Uint8Array(data)]);
}

function withoutAlpha(rgba: Uint8Array | Uint8ClampedArray): Uint8Array {
  const rgb = new Uint8Array(rgba.length / 4 * 3);
  for (let from = 0, to = 0; from < rgba.length; from += 4, to += 3) {
    rgb[to] = rgba[from];
    rgb[to + 1] = rgba[from + 1];
    rgb[to + 2] = rgba[from + 2];
  }
  return rgb;
}

function holdsFloats(file: Uint8Array): boolean {
  return file[0] === 0x50 && file[1] === 0x66;  // Pf
}

/** Columns and rows by the header of a PNG, PGM or PFM file; undefined if they are not plain to see. */
function sizeOfFile(file: Uint8Array): {width: number, height: number} | undefined {
  const head = String.fromCharCode(...file.subarray(0, 1024));
  if (head.startsWith('\x89PNG') && head.slice(12, 16) === 'IHDR' && file.length >= 24) {
    const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
    return {width: view.getUint32(16), height: view.getUint32(20)};
  }
  const found = /^P[25f]\s+(?:#[^\n]*\n\s*)*(\d{1,9})\s+(\d{1,9})\s/.exec(head);
  return found === null ? undefined : {width: Number(found[1]), height: Number(found[2])};
}
