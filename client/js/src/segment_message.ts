// SPDX-License-Identifier: Apache-2.0
// The statistics of segments in answers.
import {type ResultSummary} from './gen/segserve/v1/result_pb.js';
import {type Segment as SegmentMessage, type ThresholdRange} from './gen/segserve/v1/segment_pb.js';
import {type Segment, triple} from './result.js';

const MOST_DESCRIBED_SEGMENTS = 10_000;

/** The statistics of a result. RangeError if they do not fit its summary. */
export function segmentsOf(messages: readonly SegmentMessage[], {segments, segmentedPoints}: ResultSummary): Segment[] {
  const expected = Math.min(segments, MOST_DESCRIBED_SEGMENTS);
  if (messages.length !== expected) {
    throw new RangeError(`segments: has ${messages.length} entries, but must have ${expected}`);
  }
  let [sum, before] = [0, Infinity];
  for (const {points} of messages) {
    sum += points;
    if (points > before || sum > segmentedPoints) {
      throw new RangeError('segments: their numbers of points do not fit the summary');
    }
    before = points;
  }
  return messages.map((message, i) => segmentOf(message, i + 1));
}

/** RangeError if it is broken. */
export function segmentOf({points, centroid, box, color, normal, thresholds}: SegmentMessage, label: number): Segment {
  if (box?.axes.length !== 3) {
    throw new RangeError(`segment ${label}: box.axes: has ${box?.axes.length ?? 0} axes, but must have 3`);
  }
  const [first, second, third] = box.axes.map(triple);
  const range = thresholds && thresholdsOf(thresholds, `segment ${label}`);
  return {
    label,
    points,
    centroid: triple(centroid),
    box: {center: triple(box.center), axes: [first, second, third], halfExtents: triple(box.halfExtents)},
    color: color && [color.red, color.green, color.blue],
    normal: normal && triple(normal),
    thresholds: range,
    stability: range && range[1] - range[0],
  };
}

/** RangeError unless it is ascending in [0, 1]. */
export function thresholdsOf({lower, upper}: ThresholdRange, name: string): readonly [number, number] {
  if (!(lower >= 0 && lower <= upper && upper <= 1)) throw new RangeError(`${name}: thresholds: must be ascending in [0, 1]`);
  return [lower, upper];
}
