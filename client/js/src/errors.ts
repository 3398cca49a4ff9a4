// SPDX-License-Identifier: Apache-2.0
// The errors of calls and frames, with the details that the server gave.

/** The status codes of gRPC by number. */
export const STATUS_CODES = [
  'OK', 'CANCELLED', 'UNKNOWN', 'INVALID_ARGUMENT', 'DEADLINE_EXCEEDED', 'NOT_FOUND', 'ALREADY_EXISTS',
  'PERMISSION_DENIED', 'RESOURCE_EXHAUSTED', 'FAILED_PRECONDITION', 'ABORTED', 'OUT_OF_RANGE', 'UNIMPLEMENTED',
  'INTERNAL', 'UNAVAILABLE', 'DATA_LOSS', 'UNAUTHENTICATED',
] as const;

/** The code of an error, as gRPC names it. */
export type ErrorCode = Exclude<(typeof STATUS_CODES)[number], 'OK'>;

/** A wrong field of a request. */
export interface FieldViolation {
  /** Its path, such as "options.lambda". */
  readonly field: string;
  readonly description: string;
}

/** What programs may want to know of an error. */
export interface ErrorDetails {
  /** Why it failed, as segserve.v1.ErrorReason names it, such as "QUEUE_FULL". Empty if no server said so. */
  readonly reason?: string;
  /** Further facts by name, such as "limit", "allowed" and "actual". */
  readonly metadata?: Readonly<Record<string, string>>;
  /** Every wrong field of the request. */
  readonly fieldViolations?: readonly FieldViolation[];
  /** How long to wait before the next attempt, milliseconds. Undefined unless the server suggests it. */
  readonly retryDelayMs?: number | undefined;
}

/**
 * A call or a frame failed. Arguments that this package itself finds wrong are a TypeError or a RangeError instead,
 * before anything is sent.
 */
export class SegserveError extends Error {
  override readonly name: string = 'SegserveError';
  /** The status code, such as "INVALID_ARGUMENT". */
  readonly code: ErrorCode;
  readonly reason: string;
  readonly metadata: Readonly<Record<string, string>>;
  readonly fieldViolations: readonly FieldViolation[];
  readonly retryDelayMs: number | undefined;

  constructor(code: ErrorCode, message: string, details: ErrorDetails = {}) {
    super(message);
    this.code = code;
    this.reason = details.reason ?? '';
    this.metadata = details.metadata ?? {};
    this.fieldViolations = details.fieldViolations ?? [];
    this.retryDelayMs = details.retryDelayMs;
  }
}

/** A certificate is not believed, or one side does not speak TLS. Asking the same server again is in vain. */
export class TlsError extends SegserveError {
  override readonly name = 'TlsError';

  constructor(message: string) {
    super('UNAVAILABLE', message);
  }
}

/** No server has been in reach for the `longestOutageMs` of a stream. */
export class OutageError extends SegserveError {
  override readonly name = 'OutageError';

  constructor(message: string) {
    super('UNAVAILABLE', message);
  }
}

/** Whether another try may succeed. CANCELLED counts, because servers that shut down end calls so. */
export function isRetryable(error: SegserveError): boolean {
  switch (error.code) {
    case 'RESOURCE_EXHAUSTED':
      return error.reason !== 'LIMIT_EXCEEDED';  // a frame beyond a limit never fits
    case 'DEADLINE_EXCEEDED':
      return error.reason === 'UPLOAD_STALLED';
    default:
      return error.code === 'UNAVAILABLE' || error.code === 'ABORTED' || error.code === 'CANCELLED';
  }
}

/** Whether a stream that ended so may do better on another connection: not with errors that every server repeats. */
export function isWorthReconnecting(error: SegserveError): boolean {
  return !['INVALID_ARGUMENT', 'FAILED_PRECONDITION', 'UNIMPLEMENTED', 'UNAUTHENTICATED', 'PERMISSION_DENIED']
      .includes(error.code);
}

/** Replaces CANCELLED, with which servers that shut down end calls, for calls that this client did not cancel. */
export function unavailableIfCancelled(error: SegserveError): SegserveError {
  return error.code === 'CANCELLED' ? new SegserveError('UNAVAILABLE', 'the server ended the call') : error;
}

/** The error of an answer that is not what the API says. */
export function brokenAnswer(message: string): SegserveError {
  return new SegserveError('INTERNAL', `the answer is broken: ${message}`);
}
