// SPDX-License-Identifier: Apache-2.0
// The parameters of a call, and the messages that are made of them.
import {create} from '@bufbuild/protobuf';
import {timestampFromDate} from '@bufbuild/protobuf/wkt';

import {CLOUD_NAMES, type CloudOrPayload, payloadOf} from './encode.js';
import {type SegmentOptions} from './gen/segserve/v1/options_pb.js';
import {type Prompts as PromptsMessage} from './gen/segserve/v1/prompts_pb.js';
import {type SegmentRequest, SegmentRequestSchema, type SegmentResponse} from './gen/segserve/v1/segmentation_service_pb.js';
import {type TrackRequest} from './gen/segserve/v1/tracking_pb.js';
import {type NamesOf, refuseUnknown} from './names.js';
import {checkedOutputs, DEFAULT_OUTPUTS, optionsMessage, type Output, outputsMessage, type Segmentation,
        SEGMENTATION_NAMES} from './options.js';
import {type Payload} from './payload.js';
import {type Prompts, promptsMessage} from './places.js';
import {type Echo, ECHO_NAMES, type Result} from './result.js';
import {decodeResult} from './result_message.js';
import {type Tracking, trackRequest} from './tracking.js';

/** How a call is made. */
export interface CallOptions {
  /** From now to the answer, all repetitions included, milliseconds. */
  timeoutMs?: number;
  /** Ends the call with CANCELLED. */
  signal?: AbortSignal;
  /** That of the W3C's Trace Context, for tracing. */
  traceparent?: string;
}

/** A cloud, how it is segmented, and what comes back. */
export type SegmentArguments = CloudOrPayload & Segmentation & Echo & CallOptions & {
  /** The parts of the result; by default labels, supervoxels and tree. */
  outputs?: readonly Output[];
  /** Places on an object and beside it, of which Result.selection tells what they select. */
  prompts?: Prompts;
  /** Asks for ids that objects keep, Result.tracks. True: of new objects. Its state is that of the cloud before. */
  track?: boolean | Tracking;
};

const CALL_NAMES: Record<keyof CallOptions, true> = {timeoutMs: true, signal: true, traceparent: true};
const SEGMENT_NAMES: Record<NamesOf<SegmentArguments>, true> =
    {...CLOUD_NAMES, ...SEGMENTATION_NAMES, ...ECHO_NAMES, ...CALL_NAMES, outputs: true, prompts: true, track: true};

/** A cloud with everything that belongs to its segmentation, checked. */
export interface SegmentCall {
  readonly payload: Payload;
  readonly options: SegmentOptions;
  readonly outputs: readonly Output[];
  readonly prompts?: PromptsMessage;
  readonly tracking?: TrackRequest;
  readonly echo: Echo;
}

/** The largest size of a request, bytes. */
export const MOST_REQUEST_BYTES = 8 << 20;
const SLACK_BYTES = 8 << 10;  // of everything in a request but the blocks and the state
const MOST_NAME_BYTES = 256;

/** TypeError, RangeError: the arguments make no sense. */
export function segmentCall(given: SegmentArguments): SegmentCall {
  refuseUnknown<SegmentArguments>('segment', given, SEGMENT_NAMES);
  return {
    payload: payloadOf(given),
    options: optionsMessage(given),
    outputs: checkedOutputs(given.outputs ?? DEFAULT_OUTPUTS),
    prompts: given.prompts && promptsMessage(given.prompts),
    tracking: trackRequest(given.track),
    echo: checkedEcho(given),
  };
}

/** RangeError if a name is too long. */
export function checkedEcho({requestId, frameId, stamp}: Echo): Echo {
  for (const [name, value] of Object.entries({requestId, frameId})) {
    if (value !== undefined && new TextEncoder().encode(value).length > MOST_NAME_BYTES) {
      throw new RangeError(`${name}: it has more than ${MOST_NAME_BYTES} bytes`);
    }
  }
  return {requestId, frameId, stamp};
}

/** Whether the request fits into one message. */
export function fitsMessage({payload, tracking}: SegmentCall): boolean {
  return payload.size + (tracking?.state.length ?? 0) <= MOST_REQUEST_BYTES - SLACK_BYTES;
}

export function requestMessage({payload, options, outputs, prompts, tracking, echo}: SegmentCall): SegmentRequest {
  return create(SegmentRequestSchema, {
    requestId: echo.requestId ?? '',
    frameId: echo.frameId ?? '',
    stamp: echo.stamp && timestampFromDate(echo.stamp),
    cloud: payload.message(),
    options,
    outputs: outputsMessage(outputs, payload.compressed),
    prompts,
    tracking,
  });
}

/** SegserveError (INTERNAL) if the answer is broken. */
export function resultOf(response: SegmentResponse, {payload, outputs, prompts, tracking, echo}: SegmentCall): Result {
  const {points, shape} = payload;
  const expected = {points, shape, outputs, isPrompted: prompts !== undefined, isTracked: tracking !== undefined};
  return decodeResult(response.result, expected, echo);
}

const TRACEPARENT = /^[0-9a-f]{2}-[0-9a-f]{32}-[0-9a-f]{16}-[0-9a-f]{2}$/;

/** RangeError if it is none of the W3C's. */
export function checkedTraceparent(traceparent: string): string {
  if (!TRACEPARENT.test(traceparent)) {
    throw new RangeError(`traceparent: '${traceparent}' is not VERSION-TRACE-PARENT-FLAGS in hexadecimal digits`);
  }
  return traceparent;
}

/** RangeError unless it is above 0. */
export function checkedTimeout(timeoutMs: number): number {
  if (!(timeoutMs > 0)) throw new RangeError(`timeoutMs: ${timeoutMs} ms is not above 0`);
  return timeoutMs;
}
