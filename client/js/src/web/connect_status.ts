// SPDX-License-Identifier: Apache-2.0
// Errors of what the Connect protocol says.
import {Code, ConnectError} from '@connectrpc/connect';

import {SegserveError} from '../errors.js';
import {codeOf, type Detail, fromStatus} from '../status.js';

/** The error with which a call to `url` ended. */
export function webError(error: unknown, url: string): SegserveError {
  const failure = ConnectError.from(error, Code.Unavailable);
  const isLocal = failure.cause instanceof TypeError;  // that of fetch
  if (isLocal) {
    return new SegserveError('UNAVAILABLE', `no answer from ${url}: ${failure.rawMessage}; is segserve --http running there, ` +
                                                'and does it allow the origin of this page?');
  }
  return fromStatus(codeOf(failure.code), failure.rawMessage, detailsOf(failure));
}

/** Those that came from the server; others are this library's own. */
function detailsOf({details}: ConnectError): Detail[] {
  return details.flatMap((detail) => ('value' in detail && detail.value instanceof Uint8Array ?
                                          [{typeName: (detail as {type: string}).type, value: detail.value}] : []));
}
