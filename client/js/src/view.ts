// SPDX-License-Identifier: Apache-2.0
// Where the sensor is relative to the points of a cloud.
import {create} from '@bufbuild/protobuf';

import {type View as ViewMessage, ViewKind, ViewSchema} from './gen/segserve/v1/cloud_pb.js';

/** The points that one of several cameras saw. They follow one another in the cloud. */
export interface CameraPoints {
  /** Their number, at least 1. */
  readonly points: number;
  /** The position of the camera in the frame of the cloud, meters. */
  readonly sensor: readonly [number, number, number];
}

/** The most cameras that a view may have. */
const MOST_CAMERAS = 64;

/**
 * The frame of a cloud's points.
 *
 * "camera": z points forward, the sensor is at the origin, and every finite point has z > 0. Voxels grow with the
 * distance. "world": any other frame. Voxels are equally large everywhere, and normals are turned toward `sensor` if it
 * is known.
 */
export interface View {
  readonly kind: 'camera' | 'world';
  /** The position of the sensor in the frame of the cloud, meters. Only a "world" may have one. */
  readonly sensor?: readonly [number, number, number];
  /**
   * The cameras of a "world" that several of them saw at once, in the order of their points, instead of `sensor`. All
   * points are in the frame that the cameras share. Each normal is turned to the camera that saw the surface.
   */
  readonly cameras?: readonly CameraPoints[];
}

/**
 * What functions take as a view: a View, or "camera", "world" or "world:X,Y,Z" as segctl does. Without a view the server
 * chooses one by the points, as for a file; Result.view and Result.viewRule then tell what it chose.
 */
export type ViewLike = View | 'camera' | 'world' | `world:${number},${number},${number}`;

/** RangeError if it is none. */
function checkedPosition(position: readonly number[]): [number, number, number] {
  if (position.length !== 3 || !position.every(Number.isFinite)) {
    throw new RangeError(`view: ${String(position)} is not a position of three finite numbers`);
  }
  return [position[0]!, position[1]!, position[2]!];
}

/** RangeError if there is a fault. Whether the numbers of points add up is for the server to say. */
function checkedCameras({kind, sensor, cameras = []}: View): readonly CameraPoints[] {
  if (cameras.length === 0) return [];
  if (kind !== 'world' || sensor !== undefined) {
    throw new RangeError(`view: only a 'world' without a sensor may have cameras`);
  }
  if (cameras.length > MOST_CAMERAS) {
    throw new RangeError(`view: there are ${cameras.length} cameras, but at most ${MOST_CAMERAS} are possible`);
  }
  return cameras.map(({points, sensor: position}) => {
    if (!Number.isInteger(points) || points < 1) {
      throw new RangeError(`view: a camera has ${points} points, but must have a whole number from 1 on`);
    }
    return {points, sensor: checkedPosition(position)};
  });
}

/** RangeError if it is no view. */
function checkedView(view: View): View {
  const {kind, sensor} = view;
  if (kind !== 'camera' && kind !== 'world') throw new RangeError(`view: '${kind}' is neither 'camera' nor 'world'`);
  const cameras = checkedCameras(view);
  if (cameras.length > 0) return {kind, cameras};
  if (sensor === undefined) return {kind};
  if (kind === 'camera') {
    throw new RangeError(`view: the sensor of a camera is at the origin; only 'world' has a position`);
  }
  return {kind, sensor: checkedPosition(sensor)};
}

/** The message of a view. RangeError or TypeError if it is none. */
export function viewMessage(view: ViewLike): ViewMessage {
  const {kind, sensor, cameras} = asView(view);
  if (cameras !== undefined) {
    return create(ViewSchema, {
      kind: ViewKind.WORLD,
      cameras: cameras.map(({points, sensor: [x, y, z]}) => ({points, sensor: {x, y, z}})),
    });
  }
  if (kind === 'camera') return create(ViewSchema, {kind: ViewKind.CAMERA});
  if (sensor === undefined) return create(ViewSchema, {kind: ViewKind.WORLD});
  return create(ViewSchema, {kind: ViewKind.WORLD, sensor: {x: sensor[0], y: sensor[1], z: sensor[2]}});
}

function asView(view: ViewLike): View {
  if (typeof view === 'object') return checkedView(view);
  if (typeof view !== 'string') throw new TypeError(`view: a View or a text is needed, not ${typeof view}`);
  const colon = view.indexOf(':');
  if (colon < 0) return checkedView({kind: view as View['kind']});
  const words = view.slice(colon + 1).split(',');
  const numbers = words.map((word) => (word.trim() === '' ? NaN : Number(word)));
  if (numbers.length !== 3 || numbers.some(Number.isNaN)) {
    throw new RangeError(`view: '${view}' is not camera, world or world:X,Y,Z`);
  }
  return checkedView({kind: view.slice(0, colon) as View['kind'], sensor: numbers as [number, number, number]});
}

/** The view that a result tells. RangeError if it tells none. */
export function viewOf(message: ViewMessage | undefined): View {
  if (message?.kind === ViewKind.CAMERA) return {kind: 'camera'};
  if (message?.kind !== ViewKind.WORLD) throw new RangeError('the result does not say which view was used');
  const {sensor, cameras} = message;
  if (cameras.length > 0) {
    return {
      kind: 'world',
      cameras: cameras.map(({points, sensor: at}) => ({points, sensor: [at?.x ?? 0, at?.y ?? 0, at?.z ?? 0]})),
    };
  }
  return sensor === undefined ? {kind: 'world'} : {kind: 'world', sensor: [sensor.x, sensor.y, sensor.z]};
}
