// SPDX-License-Identifier: Apache-2.0
// Frames as callers hand them over.
import {CLOUD_NAMES, type CloudOrPayload, type Encoding, payloadOf} from '../encode.js';
import {type NamesOf, refuseUnknown} from '../names.js';
import {checkedOutputs, optionsMessage, type Output, type Segmentation, SEGMENTATION_NAMES} from '../options.js';
import {type Prompts, promptsMessage} from '../places.js';
import {checkedEcho, checkedTimeout} from '../requests.js';
import {type Echo, ECHO_NAMES} from '../result.js';
import {frameTracking, type Pose} from '../tracking.js';
import {type FrameRequest, type StreamOptions} from './frame.js';

/** A cloud, and what is special about its frame. */
export type FrameArguments = CloudOrPayload & Segmentation & Echo & {
  outputs?: readonly Output[];
  /** Places on an object and beside it, of which Result.selection tells what they select. */
  prompts?: Prompts;
  /** When the cloud was taken, by performance.now(); by default now. */
  captured?: number;
  /** The result is of no use later than so many milliseconds after that; the frame then ends as EXPIRED. */
  timeToLiveMs?: number;
  /** Among frames that wait, those of higher priority go first. */
  priority?: number;
  /** From now to the outcome, all repetitions included, milliseconds. */
  timeoutMs?: number;
  /** Of a stream with `track`: from the frame of the cloud to one that is fixed to the world. */
  pose?: Pose;
};

const FRAME_NAMES: Record<NamesOf<FrameArguments>, true> = {
  ...CLOUD_NAMES,
  ...SEGMENTATION_NAMES,
  ...ECHO_NAMES,
  outputs: true,
  prompts: true,
  captured: true,
  timeToLiveMs: true,
  priority: true,
  timeoutMs: true,
  pose: true,
};
const MOST_PRIORITY = 2 ** 31 - 1;

/**
 * A frame as it is handed over; what it leaves out is as the stream has it. TypeError, RangeError: the arguments make no sense.
 */
export function frameRequest(frame: FrameArguments, stream: StreamOptions, encoding: Encoding, now: number): FrameRequest {
  refuseUnknown<FrameArguments>('frame', frame, FRAME_NAMES);
  const {method, preset, threshold, regions, options, outputs, captured = now, timeToLiveMs, priority = 0, timeoutMs} = frame;
  const hasOwn = [method, preset, threshold, regions, options].some((value) => value !== undefined);
  if (timeToLiveMs !== undefined && !(timeToLiveMs >= 0)) {
    throw new RangeError(`timeToLiveMs: ${timeToLiveMs} ms is not 0 or more`);
  }
  if (!Number.isInteger(priority) || Math.abs(priority) > MOST_PRIORITY) {
    throw new RangeError(`priority: ${priority} is no whole number of 32 bits`);
  }
  const taken = Math.min(captured, now);
  return {
    payload: payloadOf(frame, encoding),
    options: hasOwn ? optionsMessage(frame) : stream.options,
    outputs: outputs === undefined ? stream.outputs : checkedOutputs(outputs),
    echo: checkedEcho(frame),
    captured: taken,
    timeoutMs: timeoutMs === undefined ? stream.frameTimeoutMs : checkedTimeout(timeoutMs),
    timeToLiveMs,
    priority,
    prompts: frame.prompts && promptsMessage(frame.prompts),
    tracking: frameTracking(stream.tracking, frame.pose, secondsSince1970(frame.stamp, taken)),
  };
}

/** The stamp, or else the time of performance.now(), which begins anew with each process. A saved state outlives it. */
function secondsSince1970(stamp: Date | undefined, taken: number): number {
  return (stamp?.getTime() ?? performance.timeOrigin + taken) / 1000;
}
