// SPDX-License-Identifier: Apache-2.0
// Unary calls are made again, and elsewhere, while that may help.
import {AddressBook, type Choice, type Random, type Retry} from './address_book.js';
import {isRetryable, SegserveError, TlsError} from './errors.js';

/** How the calls of a client are repeated. */
export interface RepetitionRules {
  readonly addresses: number;
  readonly first: number;
  readonly retry: Retry;
  readonly waitForServer: boolean;
}

/** Decides where and when a unary call is tried next. Knows no clock: times are handed in, milliseconds. */
export class Repetition {
  readonly #rules: RepetitionRules;
  readonly #deadline: number;
  readonly #book: AddressBook;
  #tries = 0;
  #error: SegserveError | undefined;

  constructor(rules: RepetitionRules, deadline: number, random?: Random) {
    this.#rules = rules;
    this.#deadline = deadline;
    this.#book = new AddressBook(rules.addresses, rules.first, rules.retry, random);
  }

  /** The next attempt. Throws the last error if there is none. */
  next(now: number): Choice {
    if (this.#error !== undefined && !this.#isWorthAnother(this.#error)) throw this.#error;
    const choice = this.#book.choose(now);
    if (this.#error !== undefined && choice.notBefore >= this.#deadline) throw this.#error;
    this.#tries += 1;
    return choice;
  }

  failed({address}: Choice, error: SegserveError, now: number): void {
    this.#error = error;
    this.#book.failed(address, now, error.retryDelayMs);
  }

  #isWorthAnother(error: SegserveError): boolean {
    if (!isRetryable(error)) return false;
    if (error instanceof TlsError) return !this.#book.nobodyInReach();
    if (error.reason !== '') return this.#tries < this.#rules.retry.maxAttempts;  // a server said so
    return this.#rules.waitForServer || !this.#book.nobodyInReach();
  }
}

/** Makes a call until it succeeds, or another attempt would be in vain. */
export async function repeated<Answer>(rules: RepetitionRules, timeoutMs: number, signal: AbortSignal | undefined,
                                       attempt: (address: number, timeLeftMs: number) => Promise<Answer>): Promise<Answer> {
  const deadline = performance.now() + timeoutMs;
  const repetition = new Repetition(rules, deadline);
  for (;;) {
    const choice = repetition.next(performance.now());
    await sleep(choice.notBefore - performance.now(), signal);
    try {
      return await attempt(choice.address, deadline - performance.now());
    } catch (error) {
      if (!(error instanceof SegserveError) || signal?.aborted) throw error;
      repetition.failed(choice, error, performance.now());
    }
  }
}

/** SegserveError (CANCELLED) if the signal says so. */
async function sleep(ms: number, signal: AbortSignal | undefined): Promise<void> {
  const cancelled = () => new SegserveError('CANCELLED', 'the caller cancelled the call');
  if (signal?.aborted) throw cancelled();
  if (ms <= 0) return;
  await new Promise<void>((resolve, reject) => {
    const onAbort = () => {
      clearTimeout(timer);
      reject(cancelled());
    };
    const timer = setTimeout(() => {
      signal?.removeEventListener('abort', onAbort);
      resolve();
    }, ms);
    signal?.addEventListener('abort', onAbort, {once: true});
  });
}
