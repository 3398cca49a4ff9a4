// SPDX-License-Identifier: Apache-2.0

/** A bearer token. RangeError, which does not tell the token, unless it is one line of visible ASCII. */
export function checkedToken(token: string): string {
  if (typeof token !== 'string' || !/^[!-~]+$/.test(token)) {
    throw new RangeError('token: it must be one line of visible ASCII characters');
  }
  return token;
}
