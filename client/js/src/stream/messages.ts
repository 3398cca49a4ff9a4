// SPDX-License-Identifier: Apache-2.0
// Messages of the stream that are made of the caller's wishes.
import {create} from '@bufbuild/protobuf';
import {type Duration, DurationSchema, timestampFromDate} from '@bufbuild/protobuf/wkt';

import {SegserveError} from '../errors.js';
import {type FrameHeader, FrameHeaderSchema, OutcomeKind as WireKind, ResultOrder, type StreamOpen, StreamOpenSchema,
        WhenBehind as WireWhenBehind} from '../gen/segserve/v1/stream_pb.js';
import {outputsMessage} from '../options.js';
import {type FrameRequest, type OutcomeKind, type StreamOptions, type WhenBehind} from './frame.js';

const WHEN_BEHIND: Record<WhenBehind, WireWhenBehind> = {
  block: WireWhenBehind.BLOCK,
  drop_oldest: WireWhenBehind.DROP_OLDEST,
  reject: WireWhenBehind.REJECT,
};

function duration(ms: number): Duration {
  const whole = Math.floor(Math.max(ms, 0) / 1000);
  return create(DurationSchema, {seconds: BigInt(whole), nanos: Math.floor((Math.max(ms, 0) - whole * 1000) * 1e6)});
}

export function openMessage(options: StreamOptions): StreamOpen {
  // Frames may be sent twice, so that only this side can keep the order in which they were handed over.
  return create(StreamOpenSchema, {
    clientName: options.clientName,
    options: options.options,
    outputs: outputsMessage(options.outputs, false),
    order: ResultOrder.UNORDERED,
    whenBehind: WHEN_BEHIND[options.whenBehind],
    wanted: {frames: options.maxInFlight, bytes: BigInt(options.wantedBytes)},
  });
}

/** The header of a frame but for the fields of its payload. `usefulUntil`: when its result is of no use any more. */
export function headerMessage(request: FrameRequest, stream: StreamOptions, usefulUntil: number, now: number): FrameHeader {
  const {echo, payload} = request;
  return create(FrameHeaderSchema, {
    requestId: echo.requestId ?? '',
    frameId: echo.frameId ?? '',
    stamp: echo.stamp && timestampFromDate(echo.stamp),
    priority: request.priority,
    options: request.options === stream.options ? undefined : request.options,
    outputs: outputsMessage(request.outputs, payload.compressed),  // whether it may be compressed depends on the frame
    prompts: request.prompts,
    tracking: request.tracking,
    timeToLive: duration(usefulUntil - request.captured),
    age: duration(now - request.captured),
  });
}

export function outcomeKind(kind: WireKind): OutcomeKind {
  const name = WireKind[kind];
  return kind === WireKind.UNSPECIFIED || name === undefined ? 'FAILED' : name as OutcomeKind;
}

/** Why a frame has no result; undefined for RESULT and FAILED. */
export function errorOf(kind: OutcomeKind): SegserveError | undefined {
  switch (kind) {
    case 'DROPPED':
      return new SegserveError('RESOURCE_EXHAUSTED', 'a newer frame came');
    case 'EXPIRED':
      return new SegserveError('DEADLINE_EXCEEDED', `the frame's time to live was over, or too little of it was left`);
    case 'CANCELLED':
      return new SegserveError('CANCELLED', 'the frame was cancelled');
    default:
      return undefined;
  }
}
