// SPDX-License-Identifier: Apache-2.0
// A StreamScheduler whose application, clock, transport and servers are the test.
import {ours, theirs} from './package.js';

const {create, fromBinary, toBinary} = await theirs('@bufbuild/protobuf');
const {encode} = await ours('index');
const {checkedRetry} = await ours('address_book');
const {STATUS_CODES} = await ours('errors');
const {optionsMessage} = await ours('options');
const {STREAM_DEFAULTS, streamRules} = await ours('stream/frame');
const {StreamScheduler} = await ours('stream/scheduler');
const {frameTracking, streamTracking} = await ours('tracking');
const {ErrorInfoSchema, RetryInfoSchema} = await ours('gen/google/rpc/error_details_pb');
const {DrainReason, OutcomeKind, SegmentStreamRequestSchema, SegmentStreamResponseSchema} =
    await ours('gen/segserve/v1/stream_pb');

/** A flat cloud with colors: 15 bytes a point, in the blocks x, y, z and rgb. */
export function payloadOf(width = 10, height = 10) {
  const xyz = Float32Array.from({length: 3 * width * height}, (_, i) => (i % 3 === 2 ? 1 : i));
  return encode({xyz, rgb: new Uint8Array(xyz.length), width, height, view: 'camera', codec: 'planar'});
}

export function response(kind, value) {
  return create(SegmentStreamResponseSchema, {kind: {case: kind, value}});
}

export function opened(frames = 4, bytes = 1_000_000, maxChunkBytes = 256 << 10) {
  return response('opened', {credit: {frames, bytes: BigInt(bytes)}, maxChunkBytes});
}

export function outcome(number, kind = OutcomeKind.RESULT, more = {}) {
  return response('outcome', {sequence: BigInt(number), kind, ...more});
}

/** An outcome whose labels have so many bytes. */
export function announced(number, bytes, crc32) {
  const encodedBytes = BigInt(bytes);
  return outcome(number, OutcomeKind.RESULT, {encodedBytes, crc32, result: {labels: {data: {encodedBytes}}}});
}

export function chunk(number, data) {
  return response('chunk', {sequence: BigInt(number), data});
}

export const OLD = response('draining', {reason: DrainReason.STREAM_AGE});
export const DRAINING = response('draining', {});

/** The google.rpc.Status of an error. */
export function statusOf(error) {
  const details = [{typeUrl: 'type.googleapis.com/google.rpc.ErrorInfo',
                    value: toBinary(ErrorInfoSchema, create(ErrorInfoSchema, {reason: error.reason, domain: 'segserve'}))}];
  if (error.retryDelayMs !== undefined) {
    const nanos = (error.retryDelayMs % 1000) * 1e6, seconds = BigInt(Math.floor(error.retryDelayMs / 1000));
    details.push({typeUrl: 'type.googleapis.com/google.rpc.RetryInfo',
                  value: toBinary(RetryInfoSchema, create(RetryInfoSchema, {retryDelay: {seconds, nanos}}))});
  }
  return {code: STATUS_CODES.indexOf(error.code), message: error.message, details};
}

/** Functions without a connection talk about the newest one. */
export class StreamHarness {
  now = 3_600_000;
  actions = [];      // all so far
  connections = [];  // all so far
  last = undefined;  // the outcome that was taken last
  #payload = payloadOf();

  constructor({addresses = ['a', 'b'], retry, track, ...rules} = {}) {
    this.options = {...streamRules({...STREAM_DEFAULTS, ...rules}), options: optionsMessage({}), outputs: ['labels'],
                    retry: checkedRetry(retry), tracking: streamTracking(track)};
    this.scheduler = new StreamScheduler(this.options, addresses, 0);
  }

  /** Hands a frame of 100 points over: 1500 bytes. Returns its sequence. */
  send({timeoutMs = this.options.frameTimeoutMs, captured = this.now, timeToLiveMs, priority = 0, pose} = {}) {
    const {options, outputs} = this.options;
    const tracking = frameTracking(this.options.tracking, pose, captured / 1000);
    const request = {payload: this.#payload, options, outputs, echo: {}, captured, timeoutMs, timeToLiveMs, priority, tracking};
    return this.scheduler.accept(request, this.now);
  }

  /** Ticks, and notes what the scheduler asks of the transport. */
  act() {
    const tick = this.scheduler.tick(this.now);
    this.actions.push(...tick.actions);
    this.connections.push(...tick.actions.filter(({kind}) => kind === 'OPEN').map(({connection}) => connection));
    return tick;
  }

  passTime(ms) {
    this.now += ms;
    this.act();
  }

  get newest() { return this.connections.at(-1); }
  get kinds() { return this.actions.map(({kind}) => kind); }

  /** All messages that a connection sends now. */
  sent(connection = this.newest) {
    const messages = [];
    for (let next; (next = this.scheduler.nextMessage(connection, this.now)) !== undefined;) {
      messages.push(fromBinary(SegmentStreamRequestSchema, next.data).kind);
    }
    return messages;
  }

  /** How many frames begin now. */
  begun(connection = this.newest) {
    return this.sent(connection).filter((message) => message.case === 'frame').length;
  }

  /** Returns the size of the message. */
  answer(message, connection = this.newest) {
    const size = toBinary(SegmentStreamResponseSchema, message).length;
    this.scheduler.onMessage(connection, message, size, this.now);
    return size;
  }

  /** Makes a connection on which the server grants this credit. */
  open(frames = 4, bytes = 1_000_000) {
    this.act();
    this.sent();
    this.answer(opened(frames, bytes));
  }

  /** The server ends the frame that has this number on the wire. */
  end(number, kind = OutcomeKind.RESULT, connection = this.newest) { this.answer(outcome(number, kind), connection); }
  fail(number, error) { this.answer(outcome(number, OutcomeKind.FAILED, {status: statusOf(error)})); }

  /** The connection ends. */
  close(error, connection = this.newest) { this.scheduler.onClosed(connection, error, this.now); }

  /** Takes all outcomes that there are: sequence and kind of each. */
  taken() {
    const ends = [];
    for (let next; (next = this.scheduler.takeOutcome()) !== undefined;) {
      this.last = next.outcome;
      ends.push(`${next.outcome.sequence} ${next.outcome.kind}`);
    }
    return ends;
  }
}
