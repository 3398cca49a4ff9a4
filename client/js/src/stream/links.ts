// SPDX-License-Identifier: Apache-2.0
// The connections of a stream.
import {AddressBook, type Random} from '../address_book.js';
import {isWorthReconnecting, SegserveError, unavailableIfCancelled} from '../errors.js';
import {type StreamOptions} from './frame.js';
import {openMessage} from './messages.js';
import {StreamProtocol} from './protocol.js';

/**
 * An order to the transport. OPEN: connect to `address`. RENEW: use the call's channel for no other call, so that the next
 * one makes a new connection. PROBE: ask the server for a sign of life. BREAK: cancel the call. BREAK_SILENT: cancel the
 * call, and never use its channel again, because the network has cut it.
 */
export interface Action {
  readonly kind: 'OPEN' | 'RENEW' | 'PROBE' | 'BREAK' | 'BREAK_SILENT';
  readonly connection: number;
  readonly address: number;
}

/** A connection to a server, or the attempt to make one. */
export class Link {
  /** Undefined: there was a sign of life since the last probe. */
  probedAt: number | undefined;
  /** Set: given up, and only its end is awaited. */
  broken: SegserveError | undefined;
  /** Of the messages since the last FrameOutcome, that one included. */
  outcomeBytes = 0;
  /** Shall be replaced, and takes frames until it is. */
  isOld = false;

  constructor(readonly connection: number, readonly address: number, readonly protocol: StreamProtocol,
              public lastSignOfLife: number) {}

  /** Also true of a connection that is still being made. */
  takesFrames(): boolean {
    return this.broken === undefined && !this.protocol.ending;
  }
}

/** How a connection ended. */
export interface End {
  readonly why: SegserveError;
  /** Every server would say so again. */
  readonly isFatal: boolean;
}

/**
 * Which server to connect to and when, and which connection is dead.
 *
 * One connection at a time takes new frames; others may still owe outcomes. Knows neither transport nor clock: times are
 * milliseconds of any clock, and Infinity is never.
 */
export class Links {
  readonly #options: StreamOptions;
  readonly #addresses: readonly string[];
  readonly #book: AddressBook;
  readonly #links = new Map<number, Link>();
  #lastConnection = 0;
  #actions: Action[] = [];
  /** Of a connection. */
  lastError: SegserveError | undefined;

  constructor(options: StreamOptions, addresses: readonly string[], firstAddress: number, random?: Random) {
    this.#options = options;
    this.#addresses = addresses;
    this.#book = new AddressBook(addresses.length, firstAddress, options.retry, random);
  }

  /** Undefined for unknown connections and those that were given up. */
  find(connection: number): Link | undefined {
    const link = this.#links.get(connection);
    return link?.broken === undefined ? link : undefined;
  }

  addressOf(link: Link): string {
    return this.#addresses[link.address];
  }

  /** Whether every address has failed since it was reached last, and no connection takes frames. */
  outOfReach(): boolean {
    const oneTakesFrames = [...this.#links.values()].some((link) => link.takesFrames() && link.protocol.opened);
    return !oneTakesFrames && this.#book.nobodyInReach();
  }

  /** Makes a connection unless there is one that takes frames. Returns when to call again. */
  openIfNeeded(now: number): number {
    if ([...this.#links.values()].some((link) => link.takesFrames() && !link.isOld)) return Infinity;
    const {address, notBefore} = this.#book.choose(now);
    if (notBefore > now) return notBefore;
    this.#lastConnection += 1;
    const link = new Link(this.#lastConnection, address, new StreamProtocol(openMessage(this.#options)), now);
    this.#links.set(link.connection, link);
    this.#request('OPEN', link);
    return now + this.#options.progressTimeoutMs / 2;
  }

  /**
   * Probes the connections that owe an answer and are silent, and gives up those whose probe had no answer. Returns when
   * to call again.
   */
  checkSilence(now: number): number {
    const patience = this.#options.progressTimeoutMs / 2;  // for a sign of life, and then for the answer to a probe
    let due = Infinity;
    for (const link of this.#links.values()) {
      const {protocol} = link;
      const owesUs = !protocol.opened || protocol.inFlight > 0 || protocol.ending;
      if (link.broken !== undefined || !owesUs) continue;
      if (link.probedAt !== undefined && now >= link.probedAt + patience) {
        const message = `${this.addressOf(link)} showed no sign of life for ${this.#options.progressTimeoutMs} ms`;
        this.breakLink(link, 'BREAK_SILENT', new SegserveError('UNAVAILABLE', message), now);
        continue;
      }
      if (link.probedAt === undefined && now >= link.lastSignOfLife + patience) {
        link.probedAt = now;
        this.#request('PROBE', link);
      }
      due = Math.min(due, (link.probedAt ?? link.lastSignOfLife) + patience);
    }
    return due;
  }

  /** Half-closes all connections once their uploads are through: no more frames will come. */
  endAll(): void {
    for (const link of this.#links.values()) link.protocol.end();
  }

  /** Gives up all connections, which is nobody's fault: the stream was closed. */
  breakAll(): void {
    for (const link of this.#links.values()) {
      if (link.broken !== undefined) continue;
      link.broken = new SegserveError('CANCELLED', 'the stream was closed');
      this.#request('BREAK', link);
    }
  }

  /** Gives up a connection whose server is at fault. */
  breakLink(link: Link, kind: 'BREAK' | 'BREAK_SILENT', why: SegserveError, now: number): void {
    link.broken = this.lastError = why;
    this.#request(kind, link);
    this.#book.failed(link.address, now);
  }

  onSignOfLife(connection: number, now: number): void {
    const link = this.#links.get(connection);
    if (link === undefined) return;
    link.lastSignOfLife = now;
    link.probedAt = undefined;
  }

  /** The server has granted credit. The connection takes the place of old ones, which finish what they have. */
  onOpened(link: Link): void {
    this.#book.reached(link.address);
    for (const other of this.#links.values()) {
      if (other.isOld) other.protocol.end();
    }
  }

  /** The server asks for another connection. New frames go to the old one until there is another. */
  onOld(link: Link): void {
    if (link.isOld) return;
    link.isOld = true;
    this.#book.moveOn(link.address);
    this.#request('RENEW', link);
  }

  /** The server takes no more frames. */
  onDraining(link: Link, now: number): void {
    this.#book.failed(link.address, now);
    this.lastError = new SegserveError('UNAVAILABLE', `${this.addressOf(link)} is about to stop`);
  }

  /** The transport says that a connection has ended; undefined is the status OK. Returns undefined if it is unknown. */
  onClosed(connection: number, status: SegserveError | undefined, now: number): End | undefined {
    const link = this.#links.get(connection);
    if (link === undefined) return undefined;
    this.#links.delete(connection);
    if (link.broken !== undefined) return {why: link.broken, isFatal: false};
    const closed = new SegserveError('UNAVAILABLE', `${this.addressOf(link)} closed the stream`);
    const why = unavailableIfCancelled(status ?? closed);
    if (link.protocol.ending && link.protocol.inFlight === 0) return {why, isFatal: false};
    if (!isWorthReconnecting(why)) return {why, isFatal: true};
    this.lastError = why;
    if (!link.protocol.ending) this.#book.failed(link.address, now, why.retryDelayMs);
    return {why, isFatal: false};
  }

  /** The orders to the transport since the last call. */
  takeActions(): Action[] {
    const actions = this.#actions;
    this.#actions = [];
    return actions;
  }

  #request(kind: Action['kind'], {connection, address}: Link): void {
    this.#actions.push({kind, connection, address});
  }
}
