// SPDX-License-Identifier: Apache-2.0
// Results of messages from a server, each number of which is checked.
import {float64Of} from './bytes.js';
import {brokenAnswer, SegserveError} from './errors.js';
import {type MergeTree as MergeTreeMessage, type ResultSummary, type SegmentationResult} from './gen/segserve/v1/result_pb.js';
import {blockBytes, integers} from './integers.js';
import {type Output} from './options.js';
import {type Echo, Result, type ResultArrays, type Shape} from './result.js';
import {segmentsOf} from './segment_message.js';
import {pickedOf} from './selection_message.js';
import {tracksOf} from './tracks.js';
import {MergeTree} from './tree.js';

const MOST_POINTS = 100_000_000;  // that are believed if only the server knows how many there are
const ANY_VALUE = 2 ** 32 - 1;

/** What the caller knows of a cloud, and wants of its result. */
export interface Expected {
  /** Undefined if only the server knows. */
  readonly points?: number;
  readonly shape?: Shape;
  readonly outputs: readonly Output[];
  /** Whether the request has prompts. */
  readonly isPrompted?: boolean;
  /** Whether the request asks for the ids of objects. */
  readonly isTracked?: boolean;
}

/** The result in an answer. SegserveError (INTERNAL) if the answer is broken, or lacks what was wanted. */
export function decodeResult(message: SegmentationResult | undefined, expected: Expected, echo: Echo): Result {
  try {
    return readResult(message, expected, echo);
  } catch (error) {
    if (error instanceof RangeError) throw brokenAnswer(error.message);
    throw error;
  }
}

function readResult(message: SegmentationResult | undefined, expected: Expected, echo: Echo): Result {
  const summary = message?.summary;
  if (message === undefined || summary === undefined) throw new RangeError('it has no summary');
  checkSummary(summary, expected.points);
  const points = Number(summary.points);
  const arrays: ResultArrays = {
    labels: message.labels && integers(message.labels, points, summary.segments, 'labels'),
    supervoxels: message.supervoxels && integers(message.supervoxels, points, summary.supervoxels, 'supervoxels'),
    tree: message.tree && treeOf(message.tree, summary),
    segments: message.segments.length > 0 || expected.outputs.includes('segments') ? segmentsOf(message.segments, summary) :
                                                                                     undefined,
    selection: message.selection && pickedOf(message.selection, message.selected, summary),
    tracks: message.tracking && tracksOf(message.tracking, summary.segments),
  };
  const missing = expected.outputs.filter((name) => arrays[name] === undefined);
  if (missing.length > 0) throw new RangeError(`it lacks ${missing.join(', ')}`);
  if (expected.isPrompted && arrays.selection === undefined) {
    throw new SegserveError('UNIMPLEMENTED', 'the server is older than the prompts, and has selected nothing');
  }
  if (expected.isTracked && arrays.tracks === undefined) {
    throw new SegserveError('UNIMPLEMENTED', 'the server is older than tracking, and has followed nothing');
  }
  return new Result(summary, arrays, expected.shape ?? {}, echo);
}

function checkSummary(summary: ResultSummary, expectedPoints: number | undefined): void {
  const {points, finitePoints, segmentedPoints, supervoxels, segments} = summary;
  if (expectedPoints !== undefined && points !== BigInt(expectedPoints)) {
    throw new RangeError(`the result has ${points} points, but the cloud has ${expectedPoints}`);
  }
  if (points > MOST_POINTS) throw new RangeError(`it claims ${points} points, and at most ${MOST_POINTS} are accepted`);
  if (!(segments <= supervoxels && supervoxels <= segmentedPoints && segmentedPoints <= finitePoints &&
        finitePoints <= points)) {
    throw new RangeError(`the numbers of the summary contradict each other: ${points} points, ${finitePoints} finite ` +
                         `points, ${segmentedPoints} segmented points, ${supervoxels} supervoxels, ${segments} segments`);
  }
}

function treeOf(message: MergeTreeMessage, {supervoxels, segmentedPoints}: ResultSummary): MergeTree {
  const rows = Math.max(supervoxels - 1, 0);
  const tree = new MergeTree({
    leafPoints: integers(message.leafPoints, supervoxels, ANY_VALUE, 'tree.leaf_points'),
    left: integers(message.left, rows, ANY_VALUE, 'tree.left'),
    right: integers(message.right, rows, ANY_VALUE, 'tree.right'),
    weight: float64Of(blockBytes(message.weight, 8 * rows, 'tree.weight')),
    mergedRows: message.mergedRows,
  });
  const points = tree.leafPoints.reduce((sum, count) => sum + count, 0);
  if (BigInt(points) !== segmentedPoints) {
    throw new RangeError(`tree.leaf_points: the sum is ${points} points, but must be ${segmentedPoints}`);
  }
  return tree;
}
