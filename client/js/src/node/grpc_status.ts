// SPDX-License-Identifier: Apache-2.0
// Errors of what grpc-js says.
import {fromBinary} from '@bufbuild/protobuf';
import {status, type StatusObject} from '@grpc/grpc-js';

import {SegserveError} from '../errors.js';
import {StatusSchema} from '../gen/google/rpc/status_pb.js';
import {codeOf, type Detail, detailsOf, fromStatus} from '../status.js';

/** The error with which a call to `address` ended. */
export function callError(error: StatusObject, address: string): SegserveError {
  const known = fromStatus(codeOf(error.code), error.details, detailsOfTrailer(error));
  const isLocal = error.code === status.UNAVAILABLE || error.code === status.DEADLINE_EXCEEDED;
  if (!isLocal || known.reason !== '') return known;
  const hint = error.code === status.UNAVAILABLE ? '; is segserve running there?' : '';
  return new SegserveError(known.code, `no answer from ${address}: ${cause(error.details)}${hint}`);
}

/** Damaged details are skipped. */
function detailsOfTrailer({metadata}: StatusObject): Detail[] {
  try {
    return metadata.get('grpc-status-details-bin').flatMap((value) => detailsOf(fromBinary(StatusSchema, value as Buffer)));
  } catch {
    return [];
  }
}

/** The cause of a failed connection, without the names of gRPC's parts around it. */
function cause(message: string): string {
  const last = message.split('Last error: ').at(-1) as string;
  return last.replace(/^Error: /, '').replace(/\.? ?Resolution note:.*$/s, '');
}
