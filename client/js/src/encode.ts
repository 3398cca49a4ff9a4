// SPDX-License-Identifier: Apache-2.0
// Payloads of whatever callers have.
import {type CloudArrays} from './cloud.js';
import {encodeArrays, encodePcdFile, type PcdFile} from './codecs.js';
import {refuseUnknown} from './names.js';
import {Payload} from './payload.js';
import {encodeRgbdImages, type RgbdImages} from './rgbd.js';

/** A cloud: arrays, a PCD file, or images of an RGB-D camera. */
export type CloudInput = CloudArrays | PcdFile | RgbdImages;
/** A cloud, or one that was encoded before. */
export type CloudOrPayload = CloudInput | {payload: Payload};

/** How arrays and files are sent. */
export type Encoding = Pick<CloudArrays, 'view' | 'codec' | 'errorBound' | 'unit'>;

type Given = Record<string, unknown>;

/** What goes with each kind of cloud. */
const PARTS = {
  xyz: {xyz: true, rgb: true, width: true, height: true, view: true, codec: true, errorBound: true, unit: true},
  pcd: {pcd: true, view: true, unit: true},
  depth: {depth: true, color: true, intrinsics: true, depthScale: true, colorIntrinsics: true},
  payload: {payload: true},
} satisfies {
  xyz: Record<keyof CloudArrays, true>,
  pcd: Record<keyof PcdFile, true>,
  depth: Record<keyof RgbdImages, true>,
  payload: {payload: true},
};
type Kind = keyof typeof PARTS;
const KINDS = Object.keys(PARTS) as Kind[];

/** All names of parts of clouds. */
export const CLOUD_NAMES = {...PARTS.xyz, ...PARTS.pcd, ...PARTS.depth, ...PARTS.payload};

/**
 * Encodes a cloud once, for many calls.
 *
 * TypeError, RangeError: the arrays do not fit each other, or the codec cannot encode them. Error: Zstandard is missing.
 */
export function encode(cloud: CloudInput): Payload {
  refuseUnknown<CloudOrPayload>('cloud', cloud, CLOUD_NAMES);
  return payloadOf(cloud);
}

/** The payload that a caller gives or means, among other arguments. `usual`: what holds unless the cloud says otherwise. */
export function payloadOf(arguments_: CloudOrPayload, usual: Encoding = {}): Payload {
  const given = arguments_ as unknown as Given;
  const kind = kindOf(given);
  const cloud: Given = {};
  for (const name of Object.keys(PARTS[kind])) cloud[name] = given[name] ?? (usual as Given)[name];
  switch (kind) {
    case 'xyz':
      return encodeArrays(cloud as unknown as CloudArrays);
    case 'pcd':
      return encodePcdFile(cloud as unknown as PcdFile);
    case 'depth':
      return encodeRgbdImages(cloud as unknown as RgbdImages);
    case 'payload':
      if (!(cloud['payload'] instanceof Payload)) throw new TypeError('payload: it must come from encode()');
      return cloud['payload'];
  }
}

/** TypeError if there is no cloud, or parts of several. */
function kindOf(given: Given): Kind {
  const kinds = KINDS.filter((kind) => given[kind] !== undefined);
  if (kinds.length !== 1) {
    const found = kinds.length === 0 ? 'none of them' : kinds.join(' and ');
    throw new TypeError(`cloud: give one of ${KINDS.join(', ')}, not ${found}`);
  }
  const [kind] = kinds;
  const stranger = Object.keys(CLOUD_NAMES).find((name) => given[name] !== undefined && !Object.hasOwn(PARTS[kind], name));
  if (stranger !== undefined) throw new TypeError(`cloud: '${stranger}' does not go with '${kind}'`);
  return kind;
}
