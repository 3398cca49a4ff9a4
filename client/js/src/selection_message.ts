// SPDX-License-Identifier: Apache-2.0
// The part of an answer that the prompts of its request select.
import {type PromptedPoint as PointMessage, type Selection as SelectionMessage} from './gen/segserve/v1/prompts_pb.js';
import {type IntegerArray, type ResultSummary} from './gen/segserve/v1/result_pb.js';
import {integers} from './integers.js';
import {type PromptedPoint} from './places.js';
import {type Picked} from './result.js';
import {segmentOf, thresholdsOf} from './segment_message.js';

const MOST_PROMPTS = 64;               // of each kind
const MOST_CANDIDATE_NODES = 1 << 24;  // of all candidates together

/** RangeError if the selection does not fit the result. */
export function pickedOf(message: SelectionMessage, selected: IntegerArray | undefined, summary: ResultSummary): Picked {
  const {thresholds, segment} = message;
  if (thresholds === undefined) throw new RangeError('selection: it has no thresholds');
  return {
    labels: selected && integers(selected, Number(summary.points), 1, 'selected'),
    include: message.include.map((point) => pointOf(point, summary)),
    exclude: message.exclude.map((point) => pointOf(point, summary)),
    candidates: candidatesOf(message, summary),
    candidate: message.candidate,
    thresholds: thresholdsOf(thresholds, 'selection'),
    segment: segment && segmentOf(segment, 1),
  };
}

function candidatesOf(message: SelectionMessage, {supervoxels}: ResultSummary): Picked['candidates'] {
  const {smallest, stepGroups, stepNodes, candidate} = message;
  const nodes = Math.max(2 * supervoxels - 1, 0);
  const isOfTree = smallest.length > 0 && smallest.length <= MOST_PROMPTS && stepNodes.length < Math.max(supervoxels, 1) &&
                   [...smallest, ...stepNodes].every((node) => node < nodes) && stepGroups.length === stepNodes.length &&
                   stepGroups.every((group) => group < smallest.length) && candidate <= stepNodes.length;
  if (!isOfTree) throw new RangeError('selection: its candidates are none of the tree');
  if (smallest.length * (stepNodes.length + 1) > MOST_CANDIDATE_NODES) throw new RangeError('selection: it has too many candidates');
  const all = [{nodes: [...smallest]}];
  stepNodes.forEach((node, k) => {
    const before = all[k].nodes;
    all.push({nodes: before.map((each, group) => (group === stepGroups[k] ? node : each))});
  });
  return all;
}

function pointOf({point, supervoxel, distance}: PointMessage, {points, supervoxels}: ResultSummary): PromptedPoint {
  if (point >= points || supervoxel < 1 || supervoxel > supervoxels || !(distance >= 0)) {
    throw new RangeError(`selection: point ${point} is none of the cloud`);
  }
  return {point: Number(point), supervoxel, distance};
}
