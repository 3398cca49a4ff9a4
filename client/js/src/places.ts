// SPDX-License-Identifier: Apache-2.0
// Places that someone points at.
import {create} from '@bufbuild/protobuf';

import {type Prompt, PromptSchema, type Prompts as PromptsMessage, PromptsSchema} from './gen/segserve/v1/prompts_pb.js';

/** A pixel of an organized cloud: column and row from the upper left, from 0. */
export type Pixel = readonly [number, number];
/** A position in the coordinates of the cloud, which stands for the nearest point that is segmented. */
export type Position = readonly [number, number, number];
/** A place that someone points at. */
export type Place = Pixel | Position;

/** Places on an object, and places beside it, of which the server tells what they select. */
export interface Prompts {
  /** From 1 to 64. */
  readonly include: readonly Place[];
  /** At most 64. */
  readonly exclude?: readonly Place[];
  /** Takes the choice that is larger by so many steps than the one that the cut makes; below 0 it is smaller. */
  readonly larger?: number;
}

const MOST_STEPS = 2 ** 31 - 1;

/** RangeError unless it is two whole numbers, or three finite ones. */
export function checkedPlace(place: Place): Place {
  const isPixel = place.length === 2 && place.every((number) => Number.isInteger(number) && number >= 0);
  if (!isPixel && !(place.length === 3 && place.every(Number.isFinite))) {
    throw new RangeError(`${String(place)} is neither a pixel [column, row] nor a position [x, y, z]`);
  }
  return place;
}

/** RangeError unless it is a whole number of 32 bits. */
export function checkedSteps(larger: number): number {
  if (!Number.isInteger(larger) || Math.abs(larger) > MOST_STEPS) {
    throw new RangeError(`larger: ${larger} is no whole number of 32 bits`);
  }
  return larger;
}

/** The prompts as the API has them. RangeError if they make no sense. */
export function promptsMessage({include, exclude = [], larger = 0}: Prompts): PromptsMessage {
  if (include.length === 0) throw new RangeError('prompts: nothing is included');
  return create(PromptsSchema, {
    include: include.map(promptOf),
    exclude: exclude.map(promptOf),
    larger: checkedSteps(larger),
  });
}

function promptOf(given: Place): Prompt {
  const place = checkedPlace(given);
  if (place.length === 2) {
    const [column, row] = place;
    return create(PromptSchema, {place: {case: 'pixel', value: {column, row}}});
  }
  const [x, y, z] = place;
  return create(PromptSchema, {place: {case: 'position', value: {x, y, z}}});
}

/** The cloud in which places are looked for. */
export interface PlacedCloud {
  readonly supervoxels: Uint32Array;
  /** The columns and rows of an organized cloud. */
  readonly width?: number;
  readonly height?: number;
  /** The coordinates of all points. */
  readonly xyz?: Float32Array | Float64Array;
}

/** The segmented point that a place stands for. */
export interface PromptedPoint {
  /** Its index in the cloud. */
  readonly point: number;
  /** From 1. */
  readonly supervoxel: number;
  /** From the position that was asked for; 0 for a pixel. */
  readonly distance: number;
}

/** The segmented point that a place, or the index of a point, stands for. RangeError if there is none. */
export function findPoint(given: Place | number, cloud: PlacedCloud): PromptedPoint {
  if (typeof given === 'number') return pointOfIndex(given, cloud);
  const place = checkedPlace(given);
  return place.length === 2 ? pointOfPixel(place, cloud) : nearestPoint(place, cloud);
}

function pointOfIndex(point: number, {supervoxels}: PlacedCloud): PromptedPoint {
  const supervoxel = supervoxels[point];
  if (supervoxel === undefined) {
    throw new RangeError(`select: there is no point ${point}; the cloud has ${supervoxels.length}`);
  }
  if (supervoxel === 0) throw new RangeError(`select: point ${point} is not segmented`);
  return {point, supervoxel, distance: 0};
}

function pointOfPixel([column, row]: Pixel, {supervoxels, width, height = 0}: PlacedCloud): PromptedPoint {
  const pixel = `pixel ${column},${row}`;
  if (width === undefined || height < 2) {
    throw new RangeError(`${pixel}: the cloud is no image as far as the client knows; tell a position [x, y, z]`);
  }
  if (column >= width || row >= height) {
    throw new RangeError(`${pixel} is outside the image of ${width} x ${height} pixels`);
  }
  const point = row * width + column;
  if (supervoxels[point] === 0) throw new RangeError(`${pixel} has no segmented point`);
  return {point, supervoxel: supervoxels[point], distance: 0};
}

function nearestPoint([x, y, z]: Position, {supervoxels, xyz}: PlacedCloud): PromptedPoint {
  if (xyz === undefined) throw new RangeError('select: a position [x, y, z] needs xyz, the cloud that was segmented');
  if (xyz.length !== 3 * supervoxels.length) {
    throw new RangeError(`select: xyz has ${xyz.length / 3} points, but the result has ${supervoxels.length}`);
  }
  let [nearest, least] = [-1, Infinity];
  for (let i = 0; i < supervoxels.length; ++i) {
    if (supervoxels[i] === 0) continue;
    const square = (xyz[3 * i] - x) ** 2 + (xyz[3 * i + 1] - y) ** 2 + (xyz[3 * i + 2] - z) ** 2;
    if (square < least) [nearest, least] = [i, square];
  }
  if (nearest < 0) throw new RangeError('the cloud has no segmented point');
  return {point: nearest, supervoxel: supervoxels[nearest], distance: Math.sqrt(least)};
}
