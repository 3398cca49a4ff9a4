// SPDX-License-Identifier: Apache-2.0
// All that a stream decides.
import {backoffMs, type Random} from '../address_book.js';
import {isRetryable, OutageError, SegserveError, TlsError, unavailableIfCancelled} from '../errors.js';
import {type FrameOutcome, type SegmentStreamResponse} from '../gen/segserve/v1/stream_pb.js';
import {codeOf, detailsOf, fromStatus} from '../status.js';
import {type FrameRequest, type StreamOptions, type UndecodedOutcome} from './frame.js';
import {FrameQueue, type QueuedFrame} from './frame_queue.js';
import {type Action, type Link, Links} from './links.js';
import {errorOf, headerMessage, outcomeKind} from './messages.js';
import {type Event, type Outgoing, type OutcomeEvent} from './protocol.js';
import {ServiceTime} from './service_time.js';

/** Whether a frame may be accepted now. */
export type Admission = 'OPEN' | 'WAIT' | 'REFUSED';

/** What is due. */
export interface Tick {
  readonly actions: readonly Action[];
  /** The next tick is due then, and after any change. */
  readonly wakeAt: number;
}

const HOUR_MS = 3_600_000;

/**
 * Which frame goes to which server and when, what is sent again and what is given up.
 *
 * A frame that was accepted has exactly one outcome, whatever connections do. Knows no transport and no clock: a shell
 * brings the time, and the calls that carry the messages. Times are milliseconds of any clock.
 */
export class StreamScheduler {
  readonly #options: StreamOptions;
  readonly #frames: FrameQueue;
  readonly #links: Links;
  readonly #serviceTime = new ServiceTime();
  readonly #random: Random;
  #finishedSending = false;
  #closed = false;
  #outageBegan: number | undefined;     // undefined: a server is in reach, or still computes frames of this stream
  #fatal: SegserveError | undefined;    // why no server will ever take a frame of this stream

  /** `firstAddress` is where to begin, and `random` makes waits random. */
  constructor(options: StreamOptions, addresses: readonly string[], firstAddress = 0, random: Random = Math.random) {
    this.#options = options;
    this.#frames = new FrameQueue(options);
    this.#links = new Links(options, addresses, firstAddress, random);
    this.#random = random;
  }

  // The application's calls.

  /** Whether accept() may be called. */
  admission(): Admission {
    if (this.#closed || this.#finishedSending || this.#fatal !== undefined) return 'REFUSED';
    const {maxWaiting, whenBehind} = this.#options;
    if (this.#frames.waiting().length < maxWaiting || whenBehind === 'drop_oldest') return 'OPEN';
    return whenBehind === 'reject' ? 'REFUSED' : 'WAIT';
  }

  /** Why admission() is REFUSED. */
  refusal(): SegserveError {
    if (this.#fatal !== undefined) return this.#fatal;
    if (this.#closed || this.#finishedSending) {
      return new SegserveError('FAILED_PRECONDITION', 'the stream takes no more frames: finish() or close() was called');
    }
    return new SegserveError('RESOURCE_EXHAUSTED', `${this.#options.maxWaiting} frames wait already`);
  }

  /** Takes a frame, if admission() is OPEN, and returns its sequence: 1, 2, 3 and so on. */
  accept(request: FrameRequest, now: number): number {
    return this.#frames.accept(request, now);
  }

  /** The frame ends as CANCELLED unless its result is faster. Unknown and finished frames are left alone. */
  cancel(sequence: number, now: number): void {
    const frame = this.#frames.find(sequence);
    if (frame === undefined || frame.state === 'DONE') return;
    if (frame.state !== 'SENT') {
      this.#frames.end(frame, 'CANCELLED', errorOf('CANCELLED'), now);
      return;
    }
    frame.cancelled = true;
    this.#links.find(frame.connection)?.protocol.cancel(sequence);
  }

  /** No more frames will come. */
  finishSending(): void {
    this.#finishedSending = true;
  }

  /** All frames without an outcome end as CANCELLED, and the connections break at the next tick. */
  close(now: number): void {
    this.#closed = true;
    this.#frames.endAll('CANCELLED', new SegserveError('CANCELLED', 'the stream was closed'), now);
  }

  hasOutcome(): boolean {
    return this.#frames.hasOutcome();
  }

  takeOutcome(): UndecodedOutcome | undefined {
    return this.#frames.takeOutcome();
  }

  /** True if no outcome will ever come. */
  exhausted(): boolean {
    return (this.#finishedSending || this.#closed || this.#fatal !== undefined) && this.#frames.size === 0;
  }

  /** How many frames have got an outcome so far. A call of nextMessage() may end some that come too late. */
  get ended(): number {
    return this.#frames.ended;
  }

  // The passing of time.

  tick(now: number): Tick {
    for (const frame of this.#frames.endOverdue(this.#links.lastError, now)) {
      this.#serviceTime.addAtLeast(now - frame.sentAt);
      this.#links.find(frame.connection)?.protocol.cancel(frame.sequence);
    }
    const mayWait = this.#options.waitForServer && !(this.#links.lastError instanceof TlsError);
    if (this.#links.outOfReach() && !mayWait) {
      const nobody = new SegserveError('UNAVAILABLE', 'no server is in reach');
      this.#frames.failWaiting(this.#links.lastError ?? nobody, now);
    }
    let wakeAt = now + HOUR_MS;
    if (this.#closed) {
      this.#links.breakAll();
    } else {
      if (this.#finishedSending && this.#frames.unfinished().length === 0) this.#links.endAll();
      wakeAt = Math.min(wakeAt, this.#links.checkSilence(now), this.#checkOutage(now));
      if (this.#fatal === undefined && (!this.#finishedSending || this.#frames.waiting().length > 0)) {
        wakeAt = Math.min(wakeAt, this.#links.openIfNeeded(now));
      }
    }
    return {actions: this.#links.takeActions(), wakeAt: Math.min(wakeAt, this.#frames.nextChange(now))};
  }

  /** Ends the stream if no server was in reach for too long. Returns when to call again. */
  #checkOutage(now: number): number {
    const limit = this.#options.longestOutageMs;
    if (limit <= 0 || this.#fatal !== undefined || !this.#links.outOfReach() || this.#frames.sent().length > 0) {
      this.#outageBegan = undefined;
      return Infinity;
    }
    this.#outageBegan ??= now;
    if (now < this.#outageBegan + limit) return this.#outageBegan + limit;
    const cause = this.#links.lastError?.message ?? 'no answer';
    this.#fatal = new OutageError(`no server has been in reach for ${limit / 1000} s (${cause})`);
    this.#frames.endAll('FAILED', this.#fatal, now);
    return Infinity;
  }

  // Reports of the transport. Unknown connections are ignored.

  /** The next message of a connection; undefined if there is none now. */
  nextMessage(connection: number, now: number): Outgoing | undefined {
    const link = this.#links.find(connection);
    if (link === undefined) return undefined;
    if (link.protocol.hasTurn()) this.#beginFrame(link, now);
    const outgoing = link.protocol.next();
    const frame = outgoing?.sequence === undefined ? undefined : this.#frames.find(outgoing.sequence);
    if (outgoing !== undefined && frame?.connection === connection) {
      frame.report.bytesSent += outgoing.data.length;
      if (outgoing.kind === 'frame') frame.report.headerSent = now;
      if (outgoing.completesPayload) frame.report.payloadSent = now;
    }
    return outgoing;
  }

  /** Starts to send the next frame, if there is one and the credit has room for it. */
  #beginFrame(link: Link, now: number): void {
    const frame = this.#nextInTime(now);
    if (frame?.request === undefined) return;
    const {request} = frame;
    const {size} = request.payload;
    const fit = link.protocol.fit(size);
    if (fit === 'LATER') return;  // smaller frames must not overtake it for ever
    if (fit === 'NEVER') {
      const allowed = link.protocol.creditBytes;
      const metadata = {limit: 'credit.bytes', allowed: String(allowed), actual: String(size)};
      const message = `the frame has ${size} bytes, and at most ${allowed} are allowed (credit.bytes)`;
      const error = new SegserveError('INVALID_ARGUMENT', message, {reason: 'LIMIT_EXCEEDED', metadata});
      this.#frames.end(frame, 'FAILED', error, now);
      return;
    }
    if (link.protocol.inFlight === 0) link.lastSignOfLife = now;  // an idle server is silent with good reason
    frame.state = 'SENT';
    frame.connection = link.connection;
    frame.sentAt = now;
    frame.report.attempts += 1;
    frame.report.bytesSent = frame.report.bytesReceived = 0;
    const header = headerMessage(request, this.#options, frame.usefulUntil(), now);
    link.protocol.begin(frame.sequence, header, request.payload);
  }

  /**
   * The next frame to send.
   *
   * Frames that would come too late, judged by how long the last ones took, end instead if others wait: a server that is
   * behind would otherwise be late with all of them.
   */
  #nextInTime(now: number): QueuedFrame | undefined {
    for (;;) {
      const frame = this.#frames.nextToSend(now);
      if (frame === undefined) return undefined;
      const othersWait = this.#frames.waiting().length > 1;
      // Without any frame under way, nothing would tell that the server is faster again.
      const isLate = now + this.#serviceTime.bound() > frame.usefulUntil() && this.#frames.sent().length > 0;
      if (!othersWait || !isLate) return frame;
      this.#frames.endLate(frame, this.#links.lastError, now);
    }
  }

  /** Whether nothing will be sent on the connection any more. */
  wantsHalfClose(connection: number): boolean {
    return this.#links.find(connection)?.protocol.wantsHalfClose() ?? false;
  }

  onSignOfLife(connection: number, now: number): void {
    this.#links.onSignOfLife(connection, now);
  }

  /** `size`: of the message, bytes. Returns true if there may be something for the application or a tick to do. */
  onMessage(connection: number, message: SegmentStreamResponse, size: number, now: number): boolean {
    const link = this.#links.find(connection);
    if (link === undefined) return false;
    this.#links.onSignOfLife(connection, now);
    if (message.kind.case === 'outcome') link.outcomeBytes = 0;
    link.outcomeBytes += size;
    let event: Event;
    try {
      event = link.protocol.receive(message);
    } catch (error) {
      if (!(error instanceof SegserveError)) throw error;
      this.#links.breakLink(link, 'BREAK', error, now);
      return true;
    }
    this.#onEvent(link, event, now);
    return event.kind !== 'NOTHING' && event.kind !== 'BEGUN';
  }

  #onEvent(link: Link, event: Event, now: number): void {
    switch (event.kind) {
      case 'OPENED':
        return this.#links.onOpened(link);
      case 'DRAINING':
        return this.#links.onDraining(link, now);
      case 'OLD':
        return this.#links.onOld(link);
      case 'BEGUN': {
        const frame = this.#frames.find(event.sequence);
        if (frame !== undefined) frame.report.outcomeBegun = now;
        return undefined;
      }
      case 'OUTCOME':
        return this.#onOutcome(link, event, now);
      default:
        return undefined;
    }
  }

  #onOutcome(link: Link, {sequence, outcome, isIntact}: OutcomeEvent, now: number): void {
    const frame = this.#frames.find(sequence);
    if (frame?.state !== 'SENT' || frame.connection !== link.connection) return;  // the frame has ended here before
    frame.report.bytesReceived = link.outcomeBytes;
    frame.report.address = this.#links.addressOf(link);
    const kind = outcomeKind(outcome.kind);
    const took = now - frame.sentAt;
    if (kind === 'EXPIRED') {
      this.#serviceTime.addAtLeast(took);
      this.#frames.endLate(frame, this.#links.lastError, now);
      return;
    }
    if (kind === 'FAILED') {
      this.#onFailedFrame(link, frame, outcome, now);
      return;
    }
    if (kind === 'RESULT') this.#serviceTime.add(took);
    if (!isIntact) {
      const message = 'the bytes of the result do not have the checksum that was announced';
      this.#frames.sendAgain(frame, new SegserveError('ABORTED', message, {reason: 'CHECKSUM'}), now, now);
      return;
    }
    if (kind === 'RESULT') {
      frame.undecoded.message = outcome.result;
      if (outcome.result?.tracking !== undefined) this.#frames.trackState = outcome.result.tracking.state;
    }
    this.#frames.end(frame, kind, errorOf(kind), now);
  }

  #onFailedFrame(link: Link, frame: QueuedFrame, {status}: FrameOutcome, now: number): void {
    const error = status === undefined || status.code === 0 ?
        new SegserveError('INTERNAL', 'the server failed the frame and did not say why') :
        unavailableIfCancelled(fromStatus(codeOf(status.code), status.message, detailsOf(status)));
    if (error.code === 'UNAUTHENTICATED' && link.protocol.ending) {
      // The time of the stream's token is over. The next stream may have a newer one; if not, that stream fails.
      this.#frames.sendAgain(frame, error, now, now);
      return;
    }
    const isRejected = error.code === 'RESOURCE_EXHAUSTED' && this.#options.whenBehind === 'reject';
    if (isRejected || !isRetryable(error)) {
      this.#frames.end(frame, 'FAILED', error, now);
      return;
    }
    const wait = backoffMs(this.#options.retry, frame.report.attempts, error.retryDelayMs, this.#random);
    this.#frames.sendAgain(frame, error, now + wait, now);
  }

  /** A connection has ended, with an error or, if it is undefined, with OK. */
  onClosed(connection: number, status: SegserveError | undefined, now: number): void {
    const end = this.#links.onClosed(connection, status, now);
    if (end === undefined) return;
    if (end.isFatal) {
      this.#fatal = end.why;
      this.#frames.endAll('FAILED', end.why, now);
      return;
    }
    for (const frame of this.#frames.sent()) {
      if (frame.connection === connection) this.#frames.sendAgain(frame, end.why, now, now);
    }
  }
}
