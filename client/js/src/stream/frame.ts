// SPDX-License-Identifier: Apache-2.0
// The frames that go into a stream, the outcomes that come out of it, and the rules between.
import {type Retry} from '../address_book.js';
import {type SegserveError} from '../errors.js';
import {type SegmentOptions} from '../gen/segserve/v1/options_pb.js';
import {type Prompts} from '../gen/segserve/v1/prompts_pb.js';
import {type SegmentationResult} from '../gen/segserve/v1/result_pb.js';
import {type TrackRequest} from '../gen/segserve/v1/tracking_pb.js';
import {oneOf} from '../names.js';
import {type Output} from '../options.js';
import {type Payload} from '../payload.js';
import {type Echo, type Result} from '../result.js';
import {type Expected} from '../result_message.js';
import {type StreamTracking} from '../tracking.js';

const DAY_MS = 86_400_000;
const MOST_FRAMES = 1024;
const WHEN_BEHIND = ['block', 'drop_oldest', 'reject'] as const;
const ORDERS = ['sent', 'done'] as const;

/**
 * What happens to frames that come faster than they are segmented. "block": send() waits; nothing is lost but by a frame's
 * own deadline. "drop_oldest": the oldest frame that waits ends as DROPPED, for robots that want the newest scene.
 * "reject": send() fails with RESOURCE_EXHAUSTED.
 */
export type WhenBehind = (typeof WHEN_BEHIND)[number];
/** The order in which outcomes come: that of send(), or as soon as each is known. */
export type Order = (typeof ORDERS)[number];

/** The rules of a stream, by default those in STREAM_DEFAULTS. Times are milliseconds. */
export interface StreamRules {
  /** For the server's logs, at most 256 bytes. */
  readonly clientName: string;
  readonly order: Order;
  readonly whenBehind: WhenBehind;
  /** How many frames may be sent, or have a result that was not taken; 1 to 1024. The server may allow fewer. */
  readonly maxInFlight: number;
  /** How many frames may wait in this process until they may be sent; 1 to 1024. */
  readonly maxWaiting: number;
  /** How many bytes of payload in flight the server is asked for; 0: as it thinks fit. */
  readonly wantedBytes: number;
  /**
   * A frame without an outcome fails after this time with DEADLINE_EXCEEDED; 1 to a day. It fails earlier if others wait
   * and too little time is left for its answer.
   */
  readonly frameTimeoutMs: number;
  /** A connection without a sign of life for this time is given up; 2 to a day. */
  readonly progressTimeoutMs: number;
  /**
   * When no address is in reach: true, frames wait until one is or their time is over; false, they fail with UNAVAILABLE.
   */
  readonly waitForServer: boolean;
  /** When no address has been in reach for this time, all unfinished frames fail with an OutageError; 0: never. */
  readonly longestOutageMs: number;
}

export const STREAM_DEFAULTS: StreamRules = {
  clientName: '',
  order: 'sent',
  whenBehind: 'block',
  maxInFlight: 4,
  maxWaiting: 1,
  wantedBytes: 0,
  frameTimeoutMs: 30_000,
  progressTimeoutMs: 5000,
  waitForServer: true,
  longestOutageMs: 0,
};

export const NAMES_OF_RULES = Object.fromEntries(Object.keys(STREAM_DEFAULTS).map((name) => [name, true])) as
    Record<keyof StreamRules, true>;

/** The rules of a stream with what its frames have unless they say otherwise. */
export interface StreamOptions extends StreamRules {
  readonly options: SegmentOptions;
  readonly outputs: readonly Output[];
  readonly retry: Retry;
  readonly tracking?: StreamTracking;
}

/** The rules that a caller gives. RangeError, with all faults, if one of them makes no sense. */
export function streamRules(given: Partial<StreamRules>): StreamRules {
  const names = Object.keys(STREAM_DEFAULTS) as (keyof StreamRules)[];
  const set = names.filter((name) => given[name] !== undefined).map((name) => [name, given[name]]);
  const rules: StreamRules = {...STREAM_DEFAULTS, ...Object.fromEntries(set)};
  oneOf('whenBehind', rules.whenBehind, WHEN_BEHIND);
  oneOf('order', rules.order, ORDERS);
  const ranges = [['maxInFlight', 1, MOST_FRAMES], ['maxWaiting', 1, MOST_FRAMES],
                  ['wantedBytes', 0, Number.MAX_SAFE_INTEGER], ['frameTimeoutMs', 1, DAY_MS],
                  ['progressTimeoutMs', 2, DAY_MS], ['longestOutageMs', 0, DAY_MS]] as const;
  const faults = ranges.filter(([name, low, high]) => !(rules[name] >= low && rules[name] <= high))
                     .map(([name, low, high]) => `${name}: ${rules[name]} is not in [${low}, ${high}]`);
  for (const name of ['maxInFlight', 'maxWaiting', 'wantedBytes'] as const) {
    if (!Number.isInteger(rules[name])) faults.push(`${name}: ${rules[name]} is not a whole number`);
  }
  if (faults.length > 0) throw new RangeError(faults.join('; '));
  return rules;
}

/**
 * How a frame ended. RESULT: it was segmented. DROPPED: it made way for a newer frame. EXPIRED: its time to live was over,
 * or too little of it was left to compute the frame. CANCELLED: by cancel(), or because the stream was closed. FAILED:
 * because of an error.
 */
export type OutcomeKind = 'RESULT' | 'DROPPED' | 'EXPIRED' | 'CANCELLED' | 'FAILED';

/** A frame as it was handed over, with nothing left open. Times are those of performance.now(). */
export interface FrameRequest {
  readonly payload: Payload;
  readonly options: SegmentOptions;
  readonly outputs: readonly Output[];
  readonly echo: Echo;
  readonly captured: number;
  readonly timeoutMs: number;
  readonly timeToLiveMs?: number;
  readonly priority: number;
  readonly prompts?: Prompts;
  /** Its state is set when the frame is sent. */
  readonly tracking?: TrackRequest;
}

/** The times and costs of a frame. Times are those of performance.now(); undefined if they did not come. */
export interface FrameReport {
  handedOver: number;
  /** In the last attempt. */
  headerSent?: number;
  /** In the last attempt, its last byte was handed to gRPC. */
  payloadSent?: number;
  /** The first byte of the answer came. */
  outcomeBegun?: number;
  /** The last byte of the answer came, or the frame ended without one. */
  outcomeDone?: number;
  /** How often the frame was sent; 1 if all went well. */
  attempts: number;
  /** By all messages about the frame in the last attempt. */
  bytesSent: number;
  bytesReceived: number;
  /** Of the server that answered; empty: none did. */
  address: string;
}

/** The end of a frame. */
export class Outcome {
  kind: OutcomeKind = 'FAILED';
  /** Set for RESULT. */
  result?: Result;
  /** Set for all others: why there is no result. */
  error?: SegserveError;
  readonly report: FrameReport;
  readonly requestId: string;
  readonly frameId: string;
  readonly stamp?: Date;

  /** @internal */
  constructor(
      /** That send() returned. */
      readonly sequence: number, echo: Echo, handedOver: number) {
    this.requestId = echo.requestId ?? '';
    this.frameId = echo.frameId ?? '';
    this.stamp = echo.stamp;
    this.report = {handedOver, attempts: 0, bytesSent: 0, bytesReceived: 0, address: ''};
  }

  /** The result; throws the error if there is none. */
  get(): Result {
    if (this.result === undefined) throw this.error;
    return this.result;
  }
}

/** An outcome whose result is still a message: decoding takes long, and is done when the outcome is taken. */
export interface UndecodedOutcome {
  readonly outcome: Outcome;
  readonly expected: Expected;
  readonly echo: Echo;
  message?: SegmentationResult;
}
