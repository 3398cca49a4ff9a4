// SPDX-License-Identifier: Apache-2.0
// Errors of what servers send: google.rpc.Status and its details.
import {fromBinary} from '@bufbuild/protobuf';

import {type ErrorCode, type FieldViolation, SegserveError, STATUS_CODES} from './errors.js';
import {BadRequestSchema, ErrorInfoSchema, RetryInfoSchema} from './gen/google/rpc/error_details_pb.js';

/** A detail of an error: a message by the end of its type's URL. */
export interface Detail {
  readonly typeName: string;
  readonly value: Uint8Array;
}

interface FoundDetails {
  reason?: string;
  metadata?: Record<string, string>;
  fieldViolations?: FieldViolation[];
  retryDelayMs?: number;
}

const LONGEST_DELAY_MS = 86_400_000;  // a server that asks for more is not believed

function readDetail({typeName, value}: Detail, found: FoundDetails): void {
  if (typeName === 'google.rpc.ErrorInfo') {
    const info = fromBinary(ErrorInfoSchema, value);
    found.reason = info.reason;
    found.metadata = info.metadata;
  } else if (typeName === 'google.rpc.BadRequest') {
    found.fieldViolations = fromBinary(BadRequestSchema, value)
                                .fieldViolations.map(({field, description}) => ({field, description}));
  } else if (typeName === 'google.rpc.RetryInfo') {
    const delay = fromBinary(RetryInfoSchema, value).retryDelay;
    const ms = delay === undefined ? NaN : Number(delay.seconds) * 1000 + delay.nanos / 1e6;
    if (ms >= 0 && ms <= LONGEST_DELAY_MS) found.retryDelayMs = ms;
  }
}

/** Damaged and unknown details are skipped. */
function readDetails(details: readonly Detail[]): FoundDetails {
  const found: FoundDetails = {};
  for (const detail of details) {
    try {
      readDetail(detail, found);
    } catch {
      continue;
    }
  }
  return found;
}

/** The message with every wrong field, and the time to wait, for people. */
function readable(message: string, found: FoundDetails): string {
  let text = message;
  for (const {field, description} of found.fieldViolations ?? []) {
    if (!text.includes(field)) text += `; ${field}: ${description}`;
  }
  if (found.retryDelayMs !== undefined) text += ` (try again in ${found.retryDelayMs.toFixed()} ms)`;
  return text;
}

export function codeOf(number: number): ErrorCode {
  const name = STATUS_CODES[number];
  return name === undefined || name === 'OK' ? 'UNKNOWN' : name;
}

/** The error that a status with its details tells. */
export function fromStatus(code: ErrorCode, message: string, details: readonly Detail[]): SegserveError {
  const found = readDetails(details);
  return new SegserveError(code, readable(message, found), found);
}

/** The details of a google.rpc.Status. */
export function detailsOf(status: {details: readonly {typeUrl: string, value: Uint8Array}[]}): Detail[] {
  return status.details.map(({typeUrl, value}) => ({typeName: typeUrl.slice(typeUrl.lastIndexOf('/') + 1), value}));
}
