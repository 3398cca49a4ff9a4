// SPDX-License-Identifier: Apache-2.0
// Addresses of servers: which to try next, and when. Times are milliseconds of any clock, which callers hand in.

/**
 * How frames and calls are repeated, which is always safe: results are pure functions of the bytes that are sent.
 *
 * The time before an address is tried again doubles from the first to the largest, and is shortened at random by up to a
 * half. It is never less than the server asked for.
 */
export interface Retry {
  readonly maxAttempts: number;
  readonly firstBackoffMs: number;
  readonly maxBackoffMs: number;
}

const DEFAULT_RETRY: Retry = {maxAttempts: 5, firstBackoffMs: 50, maxBackoffMs: 5000};
const MOST_ATTEMPTS = 1_000_000;
const DAY_MS = 86_400_000;
const MOST_DOUBLINGS = 20;

/** RangeError if a number makes no sense. */
export function checkedRetry(given: Partial<Retry> = {}): Retry {
  const retry = {...DEFAULT_RETRY, ...given};
  const {maxAttempts, firstBackoffMs, maxBackoffMs} = retry;
  if (!(Number.isInteger(maxAttempts) && maxAttempts >= 1 && maxAttempts <= MOST_ATTEMPTS)) {
    throw new RangeError(`retry.maxAttempts: ${maxAttempts} is not a whole number from 1 to ${MOST_ATTEMPTS}`);
  }
  if (!(firstBackoffMs >= 1 && firstBackoffMs <= maxBackoffMs && maxBackoffMs <= DAY_MS)) {
    throw new RangeError(`retry: the backoffs ${firstBackoffMs} and ${maxBackoffMs} ms are not 1 <= first <= max <= ${DAY_MS}`);
  }
  return retry;
}

/** A number in [0, 1) by chance. */
export type Random = () => number;

/** The time to wait before the `attempt`-th repetition, counted from 1. */
export function backoffMs(retry: Retry, attempt: number, askedForMs: number | undefined, random: Random): number {
  const doublings = Math.min(Math.max(attempt, 1) - 1, MOST_DOUBLINGS);
  const wait = Math.min(retry.firstBackoffMs * 2 ** doublings, retry.maxBackoffMs) * (1 - random() / 2);
  return Math.max(wait, askedForMs ?? 0);
}

/** An address to try, and when. */
export interface Choice {
  readonly address: number;
  readonly notBefore: number;
}

/** Chooses which of several addresses to try next, and when. */
export class AddressBook {
  readonly #failures: number[];  // since the address was reached last
  readonly #notBefore: number[];
  readonly #retry: Retry;
  readonly #random: Random;
  #turn: number;

  /** Begins with the address `first` modulo `count`. */
  constructor(count: number, first: number, retry: Retry, random: Random = Math.random) {
    this.#failures = Array<number>(count).fill(0);
    this.#notBefore = Array<number>(count).fill(-Infinity);
    this.#turn = first % count;
    this.#retry = retry;
    this.#random = random;
  }

  /** The address that may be tried soonest. If several may be tried at that time, the next in turn. */
  choose(now: number): Choice {
    const count = this.#failures.length;
    let best: Choice | undefined;
    for (let i = 0; i < count; ++i) {
      const address = (this.#turn + i) % count;
      const notBefore = Math.max(now, this.#notBefore[address]);
      if (best === undefined || notBefore < best.notBefore) best = {address, notBefore};
    }
    return best as Choice;
  }

  /** The server could not be reached, broke the connection or refuses us, and may have asked to wait. */
  failed(address: number, now: number, askedForMs?: number): void {
    this.#failures[address] += 1;
    this.#notBefore[address] = now + backoffMs(this.#retry, this.#failures[address], askedForMs, this.#random);
    this.moveOn(address);
  }

  /** The server answered. */
  reached(address: number): void {
    this.#failures[address] = 0;
    this.#notBefore[address] = -Infinity;
    this.#turn = address;
  }

  /** The server asks for another connection, best to another address: the turn goes on. */
  moveOn(address: number): void {
    this.#turn = (address + 1) % this.#failures.length;
  }

  /** Whether every address has failed since it was reached last. */
  nobodyInReach(): boolean {
    return this.#failures.every((failures) => failures > 0);
  }
}
