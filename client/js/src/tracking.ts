// SPDX-License-Identifier: Apache-2.0
// Objects that keep their ids from frame to frame: what requests ask for, and what results tell.
import {clone, create} from '@bufbuild/protobuf';

import {type RigidTransform, RigidTransformSchema, type TrackRequest, TrackRequestSchema} from './gen/segserve/v1/tracking_pb.js';
import {refuseUnknown} from './names.js';

/**
 * A rigid motion: the three rows of a 3 x 4 matrix, or the four of a 4 x 4 matrix. Each row has the numbers of the rotation
 * and then that of the translation, in meters.
 */
export type Pose = readonly ArrayLike<number>[];

/** What is followed, and how. The server checks ranges. */
export interface TrackRules {
  /** Tracks.state of the cloud before, such as one that was saved; by default all objects are new. */
  state?: Uint8Array;
  /**
   * From the frame of the cloud to one that is fixed to the world. By default the motion of the view is estimated. A frame
   * of a stream may have its own.
   */
  pose?: Pose;
  /** The highest speed of an object relative to most others, m/s. */
  maxSpeed?: number;
  /** For so many frames an object that is out of sight keeps its id. */
  keepLost?: number;
  /** Segments of fewer points are not followed. */
  minPoints?: number;
}

/** Asks for ids that objects keep from cloud to cloud. */
export interface Tracking extends TrackRules {
  /** When the cloud was captured, seconds since any moment. By default 0.1 s have passed since the cloud before. */
  time?: number;
}

const RULE_NAMES: Record<keyof TrackRules, true> = {state: true, pose: true, maxSpeed: true, keepLost: true, minPoints: true};
const MOST_UINT32 = 2 ** 32 - 1;

/** How the frames of a stream are followed. */
export interface StreamTracking {
  /** What each frame asks for; its state is that with which the stream begins. */
  readonly request: TrackRequest;
  /** Whether each frame tells when it was captured. */
  readonly isTimed: boolean;
}

/** The message of a request; undefined if nothing is followed. TypeError, RangeError: the values make no sense. */
export function trackRequest(track: boolean | Tracking | undefined): TrackRequest | undefined {
  return requestOf(track, {...RULE_NAMES, time: true});
}

/** The same for a stream, whose frames have times of their own. */
export function streamTracking(track: boolean | TrackRules | undefined): StreamTracking | undefined {
  const request = requestOf(track, RULE_NAMES as Record<keyof Tracking, true>);
  return request && {request, isTimed: true};
}

function requestOf(track: boolean | Tracking | undefined, known: Record<keyof Tracking, true>): TrackRequest | undefined {
  if (track === undefined || track === false) return undefined;
  const given = track === true ? {} : track;
  if (typeof given !== 'object' || given === null) throw new TypeError(`track: true or an object is needed, not ${String(given)}`);
  refuseUnknown<Tracking>('track', given, known);
  const {state = new Uint8Array(0), pose, time, maxSpeed, keepLost, minPoints} = given;
  if (!(state instanceof Uint8Array)) throw new TypeError('track.state: it must be a Uint8Array, that of the result before');
  return create(TrackRequestSchema, {
    state: new Uint8Array(state),
    pose: pose && poseMessage(pose),
    time: checkedNumber('time', time),
    maxSpeed: checkedNumber('maxSpeed', maxSpeed),
    keepLost: checkedCount('keepLost', keepLost),
    minPoints: checkedCount('minPoints', minPoints),
  });
}

function checkedNumber(name: string, value: number | undefined): number | undefined {
  if (value !== undefined && !Number.isFinite(value)) throw new RangeError(`track.${name}: ${String(value)} is no finite number`);
  return value;
}

function checkedCount(name: string, value: number | undefined): number | undefined {
  if (value !== undefined && !(Number.isInteger(value) && value >= 0 && value <= MOST_UINT32)) {
    throw new RangeError(`track.${name}: ${String(value)} is not a whole number from 0 to ${MOST_UINT32}`);
  }
  return value;
}

/** RangeError unless it is a 3 x 4 or 4 x 4 matrix of finite numbers. Whether it turns rigidly is for the server to say. */
function poseMessage(pose: Pose): RigidTransform {
  const rows = Array.isArray(pose) ? pose.map((row: ArrayLike<number>) => Array.from(row)) : [];
  const isMatrix = (rows.length === 3 || rows.length === 4) &&
                   rows.every((row) => row.length === 4 && row.every(Number.isFinite));
  if (!isMatrix) throw new RangeError('pose: a matrix of 3 or 4 rows with 4 finite numbers each is needed');
  if (rows.length === 4 && String(rows[3]) !== '0,0,0,1') throw new RangeError('pose: the last row of a 4 x 4 matrix is 0, 0, 0, 1');
  const [x, y, z] = rows.map((row) => row[3]);
  return create(RigidTransformSchema, {rotation: rows.slice(0, 3).flatMap((row) => row.slice(0, 3)), translation: {x, y, z}});
}

/**
 * What one frame of a stream asks for; its state is set when it is sent. `seconds`: when it was captured. RangeError if the
 * frame has a pose, but its stream follows nothing.
 */
export function frameTracking(tracking: StreamTracking | undefined, pose: Pose | undefined,
                              seconds: number): TrackRequest | undefined {
  if (tracking === undefined) {
    if (pose !== undefined) throw new RangeError('pose: it is for a stream that was opened with track');
    return undefined;
  }
  const request = clone(TrackRequestSchema, tracking.request);
  request.state = new Uint8Array(0);
  if (pose !== undefined) request.pose = poseMessage(pose);
  if (tracking.isTimed) request.time = seconds;
  return request;
}
