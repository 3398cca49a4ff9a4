// SPDX-License-Identifier: Apache-2.0
// The frames of a stream whose outcome was not taken.
import {SegserveError} from '../errors.js';
import {type FrameReport, type FrameRequest, Outcome, type OutcomeKind, type StreamOptions,
        type UndecodedOutcome} from './frame.js';
import {errorOf} from './messages.js';

/** A frame from hand-over to outcome. */
export class QueuedFrame {
  /** WAITING: to be sent, or to be sent again. SENT: on `connection`, in part or as a whole. DONE: nobody has taken it. */
  state: 'WAITING' | 'SENT' | 'DONE' = 'WAITING';
  /** WAITING: not to be sent before. */
  readyAt: number;
  /** SENT: when that began, and where. */
  sentAt = 0;
  connection = 0;
  /** By the application, while it was SENT. */
  cancelled = false;
  /** Why it is sent again. */
  lastError: SegserveError | undefined;
  /** Undefined once the frame is DONE: its payload may be many megabytes. */
  request: FrameRequest | undefined;
  readonly undecoded: UndecodedOutcome;
  /** Of its outcome. */
  readonly deadline: number;
  /** When its time to live is over. */
  readonly expires: number;
  readonly priority: number;

  constructor(readonly sequence: number, request: FrameRequest, now: number) {
    this.request = request;
    this.readyAt = now;
    this.deadline = now + request.timeoutMs;
    this.expires = request.timeToLiveMs === undefined ? Infinity : request.captured + request.timeToLiveMs;
    this.priority = request.priority;
    const {echo, outputs, payload: {points, shape}, prompts, tracking} = request;
    const expected = {points, shape, outputs, isPrompted: prompts !== undefined, isTracked: tracking !== undefined};
    this.undecoded = {outcome: new Outcome(sequence, echo, now), expected, echo};
  }

  get report(): FrameReport {
    return this.undecoded.outcome.report;
  }

  /** Whether its use ends no later than its deadline. */
  canExpire(): boolean {
    return this.expires <= this.deadline;
  }

  /** From then on its result is of no use. */
  usefulUntil(): number {
    return Math.min(this.expires, this.deadline);
  }

  /** Whether it may be sent now. */
  isReady(now: number): boolean {
    return this.state === 'WAITING' && this.readyAt <= now && now < this.deadline;
  }

  /** Whether it takes a place in the window. Results that nobody has taken do, which bounds the memory in use. */
  isInFlight(): boolean {
    return this.state === 'SENT' || (this.state === 'DONE' && this.undecoded.outcome.kind === 'RESULT');
  }

  tooLate(connectionError: SegserveError | undefined): SegserveError {
    const cause = this.lastError ?? connectionError;
    const message = this.state === 'WAITING' ? 'the frame waited until it was too late to send it' : 'no answer came in time';
    return new SegserveError('DEADLINE_EXCEEDED',
                             message + (cause === undefined ? '' : `; the last error was: ${cause.message}`));
  }
}

/**
 * Which frames may enter, which goes next, how each ends, and in which order the outcomes come.
 *
 * Knows neither connections nor transport; time is handed in, milliseconds.
 */
export class FrameQueue {
  readonly #options: StreamOptions;
  readonly #frames = new Map<number, QueuedFrame>();  // by sequence, ascending
  readonly #done: number[] = [];                      // in the order in which they ended
  #lastSequence = 0;
  /** How many frames have got an outcome so far. */
  ended = 0;
  /** What the last result has left of the objects that are followed. */
  trackState: Uint8Array;

  constructor(options: StreamOptions) {
    this.#options = options;
    this.trackState = options.tracking?.request.state ?? new Uint8Array(0);
  }

  get size(): number {
    return this.#frames.size;
  }

  /** The frames that are to be sent. */
  waiting(): QueuedFrame[] {
    return [...this.#frames.values()].filter(({state}) => state === 'WAITING');
  }

  /** The frames that were sent and have no outcome. */
  sent(): QueuedFrame[] {
    return [...this.#frames.values()].filter(({state}) => state === 'SENT');
  }

  /** The frames without an outcome. */
  unfinished(): QueuedFrame[] {
    return [...this.#frames.values()].filter(({state}) => state !== 'DONE');
  }

  /** Takes a frame and returns its sequence: 1, 2, 3 and so on. If too many wait, the oldest of them is dropped. */
  accept(request: FrameRequest, now: number): number {
    const waiting = this.waiting();
    if (waiting.length >= this.#options.maxWaiting) this.end(waiting[0], 'DROPPED', errorOf('DROPPED'), now);
    this.#lastSequence += 1;
    this.#frames.set(this.#lastSequence, new QueuedFrame(this.#lastSequence, request, now));
    return this.#lastSequence;
  }

  /** Undefined for unknown frames and those whose outcome was taken. */
  find(sequence: number): QueuedFrame | undefined {
    return this.#frames.get(sequence);
  }

  /**
   * The waiting frame that goes next, if the window has room for one. In a stream that follows objects it is the oldest
   * frame without an outcome, and gets the state that the frames before it left.
   */
  nextToSend(now: number): QueuedFrame | undefined {
    if (this.#options.tracking !== undefined) return this.#nextInChain(now);
    if (this.#isFull()) {
      if (this.#options.order === 'done') return undefined;
      // Results that came before their turn fill the window, but must not shut out the frame they wait for.
      const oldest = this.#oldestUnfinished();
      return oldest?.isReady(now) ? oldest : undefined;
    }
    let best: QueuedFrame | undefined;
    for (const frame of this.#frames.values()) {
      if (frame.isReady(now) && (best === undefined || frame.priority > best.priority)) best = frame;
    }
    return best;
  }

  #nextInChain(now: number): QueuedFrame | undefined {
    const frame = this.#oldestUnfinished();
    if (!frame?.isReady(now) || this.#isFull()) return undefined;
    if (frame.request?.tracking !== undefined) frame.request.tracking.state = this.trackState;
    return frame;
  }

  #isFull(): boolean {
    return [...this.#frames.values()].filter((frame) => frame.isInFlight()).length >= this.#options.maxInFlight;
  }

  #oldestUnfinished(): QueuedFrame | undefined {
    return [...this.#frames.values()].find(({state}) => state !== 'DONE');
  }

  /** Gives the frame its outcome. */
  end(frame: QueuedFrame, kind: OutcomeKind, error: SegserveError | undefined, now: number): void {
    frame.state = 'DONE';
    frame.request = undefined;
    this.ended += 1;
    const {outcome} = frame.undecoded;
    outcome.kind = kind;
    outcome.error = error;
    outcome.report.outcomeDone = now;
    outcome.report.outcomeBegun ??= now;
    this.#done.push(frame.sequence);
  }

  /** Ends a frame whose result would come too late: as EXPIRED or FAILED, by which of its times is over first. */
  endLate(frame: QueuedFrame, connectionError: SegserveError | undefined, now: number): void {
    if (frame.canExpire()) this.end(frame, 'EXPIRED', errorOf('EXPIRED'), now);
    else this.end(frame, 'FAILED', frame.tooLate(connectionError), now);
  }

  /** Ends all frames without an outcome. */
  endAll(kind: OutcomeKind, error: SegserveError, now: number): void {
    for (const frame of this.unfinished()) this.end(frame, kind, error, now);
  }

  /** Ends all frames that are to be sent, as failed. */
  failWaiting(error: SegserveError, now: number): void {
    for (const frame of this.waiting()) this.end(frame, 'FAILED', error, now);
  }

  /** Ends the frames whose time is over. Returns those that were sent, so that their servers can be told. */
  endOverdue(connectionError: SegserveError | undefined, now: number): QueuedFrame[] {
    const told: QueuedFrame[] = [];
    for (const frame of this.unfinished()) {
      if (frame.state === 'WAITING' && frame.expires <= now) {
        this.end(frame, 'EXPIRED', errorOf('EXPIRED'), now);
      } else if (frame.deadline <= now) {
        if (frame.state === 'SENT') told.push(frame);
        this.end(frame, 'FAILED', frame.tooLate(connectionError), now);
      }
    }
    return told;
  }

  /** The frame waits again. It ends instead if it was cancelled, or was sent too often and the server had room. */
  sendAgain(frame: QueuedFrame, error: SegserveError, readyAt: number, now: number): void {
    const hasNoRoom = error.code === 'RESOURCE_EXHAUSTED';  // the frame waits, however long that takes
    if (frame.cancelled) {
      this.end(frame, 'CANCELLED', errorOf('CANCELLED'), now);
    } else if (frame.report.attempts >= this.#options.retry.maxAttempts && !hasNoRoom) {
      this.end(frame, 'FAILED', error, now);
    } else {
      frame.state = 'WAITING';
      frame.readyAt = readyAt;
      frame.lastError = error;
    }
  }

  /** When endOverdue() or nextToSend() have to be asked again, at the latest; Infinity if never. */
  nextChange(now: number): number {
    let next = Infinity;
    for (const frame of this.unfinished()) {
      next = Math.min(next, frame.deadline);
      if (frame.state !== 'WAITING') continue;
      next = Math.min(next, frame.expires);
      if (frame.readyAt > now) next = Math.min(next, frame.readyAt);
    }
    return next;
  }

  /** Whether an outcome can be taken now, by the order that was asked for. */
  hasOutcome(): boolean {
    if (this.#options.order === 'done') return this.#done.length > 0;
    return this.#oldest()?.state === 'DONE';
  }

  takeOutcome(): UndecodedOutcome | undefined {
    if (!this.hasOutcome()) return undefined;
    const sequence = this.#options.order === 'done' ? this.#done[0] : (this.#oldest() as QueuedFrame).sequence;
    this.#done.splice(this.#done.indexOf(sequence), 1);
    const {undecoded} = this.#frames.get(sequence) as QueuedFrame;
    this.#frames.delete(sequence);
    return undecoded;
  }

  #oldest(): QueuedFrame | undefined {
    return this.#frames.values().next().value;
  }
}
