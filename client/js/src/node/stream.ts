// SPDX-License-Identifier: Apache-2.0
// The stream of frames, in Node.
import {create} from '@bufbuild/protobuf';
import {type ClientDuplexStream, status, type StatusObject} from '@grpc/grpc-js';

import {type Encoding} from '../encode.js';
import {SegserveError} from '../errors.js';
import {GetServerInfoRequestSchema} from '../gen/segserve/v1/segmentation_service_pb.js';
import {decodeResult} from '../result_message.js';
import {type Outcome, type StreamOptions, type UndecodedOutcome} from '../stream/frame.js';
import {type FrameArguments, frameRequest} from '../stream/frame_request.js';
import {type Action} from '../stream/links.js';
import {StreamScheduler} from '../stream/scheduler.js';
import {type Channel, type Channels} from './channels.js';
import {callError} from './grpc_status.js';
import {explained} from './handshake.js';
import {type Received, SERVER_INFO, STREAM} from './methods.js';

const LONGEST_TIMER_MS = 2 ** 31 - 1;

/** The call of a stream to one server. */
interface Connection {
  readonly channel: Channel;
  readonly call: ClientDuplexStream<Uint8Array, Received>;
  isWriting: boolean;
  isHalfClosed: boolean;
}

/**
 * A stream of frames to whichever server is in reach, made by Client.stream().
 *
 *     const stream = client.stream({view: 'camera', whenBehind: 'drop_oldest'});
 *     await stream.send({xyz, rgb, timeToLiveMs: 500});
 *     stream.finish();
 *     for await (const outcome of stream) use(outcome);
 *
 * Every frame that send() accepts ends in exactly one Outcome, also when the server stops, the connection breaks or the
 * network goes silent. Unfinished frames then go to another server, which is safe because a result is a pure function of
 * the frame.
 *
 * Who both sends and takes outcomes must take some before maxInFlight + maxWaiting frames more were sent than taken, or use
 * map(): with whenBehind "block", send() would otherwise wait in vain until the timeout.
 */
export class Stream implements AsyncIterable<Outcome> {
  readonly #channels: Channels;
  readonly #options: StreamOptions;
  readonly #encoding: Encoding;
  readonly #scheduler: StreamScheduler;
  readonly #connections = new Map<number, Connection>();
  readonly #waiters = new Set<() => void>();
  #timer: NodeJS.Timeout | undefined;
  #turnIsDue = false;
  #closing = false;

  /** `encoding`: how clouds are sent, unless a frame says otherwise. @internal */
  constructor(channels: Channels, options: StreamOptions, encoding: Encoding) {
    this.#channels = channels;
    this.#options = options;
    this.#encoding = encoding;
    this.#scheduler = new StreamScheduler(options, channels.settings.addresses, channels.settings.nextStart());
    this.#notify();
  }

  /**
   * Hands a frame over, of which the stream keeps a copy, and resolves to its sequence: 1, 2, 3 and so on. What the frame
   * leaves out is as the stream has it; if one of method, threshold, regions and options is given, they replace those of
   * the stream as a whole.
   *
   * TypeError, RangeError: the arguments make no sense. RESOURCE_EXHAUSTED: too many frames wait ("reject").
   * DEADLINE_EXCEEDED: too many frames waited for the timeout of this one ("block"). FAILED_PRECONDITION: finish() or
   * close() was called. Any other SegserveError is one for which no server will ever take a frame of this stream.
   */
  async send(frame: FrameArguments): Promise<number> {
    const handedOver = performance.now();
    const request = frameRequest(frame, this.#options, this.#encoding, handedOver);
    while (this.#scheduler.admission() === 'WAIT') {
      if (!await this.#change(handedOver + request.timeoutMs) && this.#scheduler.admission() === 'WAIT') {
        throw new SegserveError('DEADLINE_EXCEEDED',
                                `${this.#options.maxWaiting} frames wait already, and none of them was sent in time`);
      }
    }
    if (this.#scheduler.admission() === 'REFUSED') throw this.#scheduler.refusal();
    const sequence = this.#scheduler.accept(request, performance.now());
    this.#notify();
    return sequence;
  }

  /**
   * Waits for the next outcome, without limit unless `timeoutMs` is given. Undefined if that time is over, or if finish()
   * or close() was called and every outcome was taken.
   */
  async next(timeoutMs = Infinity): Promise<Outcome | undefined> {
    const until = performance.now() + timeoutMs;
    while (!this.#scheduler.hasOutcome() && !this.#scheduler.exhausted()) {
      if (!await this.#change(until) && !this.#scheduler.hasOutcome()) return undefined;
    }
    const undecoded = this.#scheduler.takeOutcome();
    this.#notify();  // there may be room for another frame, and this may have been the last outcome
    return undecoded && decoded(undecoded);
  }

  /** The outcomes, until finish() was called and every one was taken. */
  async* [Symbol.asyncIterator](): AsyncGenerator<Outcome, void, undefined> {
    for (let outcome = await this.next(); outcome !== undefined; outcome = await this.next()) yield outcome;
  }

  /** Sends frames while it yields outcomes, and finishes the stream. */
  async* map(frames: Iterable<FrameArguments> | AsyncIterable<FrameArguments>): AsyncGenerator<Outcome, void, undefined> {
    let fault: {readonly error: unknown} | undefined;
    const sending = this.#sendAll(frames).catch((error: unknown) => { fault = {error}; });
    try {
      yield* this;
    } finally {
      this.finish();  // also when the caller wants no more outcomes
    }
    await sending;
    if (fault !== undefined) throw fault.error;
  }

  async #sendAll(frames: Iterable<FrameArguments> | AsyncIterable<FrameArguments>): Promise<void> {
    try {
      for await (const frame of frames) await this.send(frame);
    } finally {
      this.finish();
    }
  }

  /** The frame is not wanted any more: it ends as CANCELLED, unless its result is faster. */
  cancel(sequence: number): void {
    this.#scheduler.cancel(sequence, performance.now());
    this.#notify();
  }

  /** No more frames will be sent. Those that were sent end as usual. */
  finish(): void {
    this.#scheduler.finishSending();
    this.#notify();
  }

  /** True once finish() or close() was called and every outcome was taken. */
  get done(): boolean {
    return this.#scheduler.exhausted();
  }

  /** Ends the unfinished frames as CANCELLED, and resolves when the connections have ended. */
  async close(): Promise<void> {
    this.#closing = true;
    this.#scheduler.close(performance.now());
    this.#notify();
    while (this.#connections.size > 0 || this.#turnIsDue) await this.#change(Infinity);
    clearTimeout(this.#timer);
  }

  // The event loop.

  /** Something has changed: there will be a turn soon. */
  #notify(): void {
    if (this.#turnIsDue) return;
    this.#turnIsDue = true;
    setImmediate(() => this.#takeTurn());
  }

  #takeTurn(): void {
    this.#turnIsDue = false;
    clearTimeout(this.#timer);
    const now = performance.now();
    const {actions, wakeAt} = this.#scheduler.tick(now);
    for (const action of actions) this.#perform(action);
    for (const [number, connection] of this.#connections) this.#write(number, connection);
    if (!this.#closing && !this.#scheduler.exhausted()) {
      this.#timer = setTimeout(() => this.#notify(), Math.max(wakeAt - now, 0));
    }
    for (const wake of [...this.#waiters]) wake();
  }

  /** Waits for a turn. False if the time is over. */
  #change(until: number): Promise<boolean> {
    const left = until - performance.now();
    if (left <= 0) return Promise.resolve(false);
    return new Promise((resolve) => {
      const wake = () => finish(true);
      const timer = Number.isFinite(left) ? setTimeout(() => finish(false), Math.min(left, LONGEST_TIMER_MS)) : undefined;
      const finish = (changed: boolean) => {
        clearTimeout(timer);
        this.#waiters.delete(wake);
        resolve(changed);
      };
      this.#waiters.add(wake);
    });
  }

  #perform(action: Action): void {
    if (action.kind === 'OPEN') {
      this.#open(action);
      return;
    }
    const connection = this.#connections.get(action.connection);
    if (connection === undefined) return;
    if (action.kind === 'PROBE') {
      void this.#probe(action.connection, connection);
      return;
    }
    if (action.kind !== 'BREAK') this.#channels.renew(action.address, connection.channel);
    if (action.kind !== 'RENEW') connection.call.cancel();
  }

  #open({connection: number, address}: Action): void {
    const name = this.#channels.settings.addresses[address];
    let channel: Channel;
    try {
      channel = this.#channels.get(address);
      const call = channel.duplex(STREAM, this.#channels.settings.metadata());
      this.#connections.set(number, {channel, call, isWriting: false, isHalfClosed: false});
      this.#listen(number, address, channel, call);
    } catch (error) {
      // The client was closed, or a file of TLS or of the token cannot be read.
      const known = error instanceof SegserveError ? error :
                                                     new SegserveError('UNAVAILABLE', `${name}: ${(error as Error).message}`);
      this.#onClosed(number, known);
    }
  }

  #listen(number: number, address: number, channel: Channel, call: Connection['call']): void {
    let heard = false;  // anything from the server
    call.on('data', ({message, size}: Received) => {
      heard = true;
      if (this.#scheduler.onMessage(number, message, size, performance.now())) this.#notify();
    });
    call.on('error', () => {});  // The status says the same.
    call.on('status', (end: StatusObject) => {
      if (end.code !== status.OK) this.#channels.renew(address, channel);  // so that gRPC's own backoff holds nobody up
      // Messages that came before the status are read by then.
      setImmediate(() => void this.#onStatus(number, channel.address, end, heard));
    });
  }

  async #onStatus(number: number, address: string, end: StatusObject, heard: boolean): Promise<void> {
    if (end.code === status.OK) return this.#onClosed(number, undefined);
    const error = callError(end, address);
    return this.#onClosed(number, heard || this.#closing ? error : await explained(error, address, this.#channels.settings.tls));
  }

  #onClosed(connection: number, error: SegserveError | undefined): void {
    this.#scheduler.onClosed(connection, error, performance.now());
    this.#connections.delete(connection);
    this.#notify();
  }

  /** Sends what there is to send, one message after the other. */
  #write(number: number, connection: Connection): void {
    if (connection.isWriting || connection.isHalfClosed) return;
    const {ended} = this.#scheduler;
    const outgoing = this.#scheduler.nextMessage(number, performance.now());
    // Fewer frames wait, or there is an outcome.
    if (outgoing?.kind === 'frame' || this.#scheduler.ended !== ended) this.#notify();
    if (outgoing === undefined) {
      if (!this.#scheduler.wantsHalfClose(number)) return;
      connection.isHalfClosed = true;
      connection.call.end();
      return;
    }
    connection.isWriting = true;
    connection.call.write(outgoing.data, (error?: Error | null) => {
      connection.isWriting = false;
      if (error) return;  // the call ends with its own error
      this.#scheduler.onSignOfLife(number, performance.now());
      this.#write(number, connection);
    });
  }

  /** Asks the server something that any living one answers at once, even while it computes. */
  async #probe(number: number, {channel}: Connection): Promise<void> {
    try {
      await channel.unary(SERVER_INFO, create(GetServerInfoRequestSchema), this.#channels.settings.metadata(),
                          this.#options.progressTimeoutMs / 2);
    } catch {
      return;  // it does not answer
    }
    this.#scheduler.onSignOfLife(number, performance.now());
    this.#notify();
  }
}

/** Decodes the result. The outcome becomes FAILED if the server's result is broken. */
function decoded({outcome, expected, echo, message}: UndecodedOutcome): Outcome {
  if (outcome.kind !== 'RESULT') return outcome;
  try {
    outcome.result = decodeResult(message, expected, echo);
  } catch (error) {
    if (!(error instanceof SegserveError)) throw error;
    outcome.kind = 'FAILED';
    outcome.error = error;
  }
  return outcome;
}
