// SPDX-License-Identifier: Apache-2.0
// The ids of objects in results.
import {TrackEventKind as WireKind, type TrackResult} from './gen/segserve/v1/tracking_pb.js';

const MOST_STATE_BYTES = 96 << 10;

/**
 * What may become of an object. "born": it appeared. "split": it came off `other`, of which it was a part. "lost": it is out
 * of sight. "merged": it cannot be told from `other` any more, and is out of sight. "recovered": it was out of sight and is
 * seen again. "ended": it was out of sight for too long, and its id will not be used again.
 */
export type TrackEventKind = 'born' | 'split' | 'lost' | 'merged' | 'recovered' | 'ended';

/** Something that became of an object. */
export interface TrackEvent {
  readonly kind: TrackEventKind;
  /** The id of the object. */
  readonly track: number;
  /** The id of the other object of "split" and "merged"; else 0. */
  readonly other: number;
}

/** The objects in one cloud. */
export class Tracks {
  /** @internal */
  constructor(
      /** For `track.state` of the next cloud. It may be saved. */
      readonly state: Uint8Array,
      /** The entry k - 1 is the id of segment k, from 1; 0: it is not followed. */
      readonly ids: readonly number[],
      /** What became of objects, by ascending id. */
      readonly events: readonly TrackEvent[]) {}

  /** The id of every point by its label; 0: none. */
  ofPoints(labels: Uint32Array): Float64Array {
    return Float64Array.from(labels, (label) => (label === 0 ? 0 : this.ids[label - 1]));
  }
}

/** RangeError if the ids do not fit so many segments. */
export function tracksOf({state, trackIds, events}: TrackResult, segments: number): Tracks {
  if (trackIds.length !== segments) {
    throw new RangeError(`track_ids: there are those of ${trackIds.length} segments, but the result has ${segments}`);
  }
  const ids = trackIds.map(idOf);
  const given = ids.filter((id) => id > 0);
  if (new Set(given).size !== given.length) throw new RangeError('track_ids: two segments have the same id');
  if (state.length > MOST_STATE_BYTES) {
    throw new RangeError(`tracking.state: it has ${state.length} bytes, and at most ${MOST_STATE_BYTES} are accepted`);
  }
  const known = events.flatMap(({kind, track, other}) => {
    const name = eventKind(kind);
    return name === undefined ? [] : [{kind: name, track: idOf(track), other: idOf(other)}];
  });
  return new Tracks(new Uint8Array(state), ids, known);
}

/** Servers count ids from 1, so that larger ones come from a forged state only. */
function idOf(id: bigint): number {
  if (id > BigInt(Number.MAX_SAFE_INTEGER)) throw new RangeError(`tracking: the id ${id} is too large`);
  return Number(id);
}

/** Undefined if only a later version knows it. */
function eventKind(kind: WireKind): TrackEventKind | undefined {
  const name = WireKind[kind] as string | undefined;
  return kind === WireKind.UNSPECIFIED ? undefined : name?.toLowerCase() as TrackEventKind | undefined;
}
