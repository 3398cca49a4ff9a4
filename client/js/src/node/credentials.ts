// SPDX-License-Identifier: Apache-2.0
// Who the server is, and who the client is: TLS and bearer tokens.
import fs from 'node:fs';

import {type ChannelCredentials, credentials} from '@grpc/grpc-js';

import {checkedToken} from '../token.js';

/** PEM: the path of a file, or its bytes. */
export type Pem = string | Uint8Array;

/** How a connection by TLS is made. Files are read when a connection is made. */
export interface Tls {
  /** The certificates that are believed; by default those of Node. */
  ca?: Pem;
  /** The client's certificate, and its key, if the server asks for one (mutual TLS). */
  cert?: Pem;
  key?: Pem;
  /** The name in the server's certificate, if it is not the one in the address. */
  serverName?: string;
}

/** RangeError if certificate and key do not go together. An error of the system if a file cannot be read. */
export function checkedTls(tls: Tls | boolean | undefined): Tls | undefined {
  if (tls === undefined || tls === false) return undefined;
  const checked = tls === true ? {} : tls;
  if ((checked.cert === undefined) !== (checked.key === undefined)) throw new RangeError('tls: cert and key go together');
  tlsContents(checked);
  return checked;
}

/** The files' contents. */
export function tlsContents({ca, cert, key}: Tls): {ca?: Buffer, cert?: Buffer, key?: Buffer} {
  return {ca: content(ca), cert: content(cert), key: content(key)};
}

function content(pem: Pem | undefined): Buffer | undefined {
  if (pem === undefined) return undefined;
  return typeof pem === 'string' ? fs.readFileSync(pem) : Buffer.from(pem);
}

/** gRPC's credentials. An error of the system if a file cannot be read. */
export function channelCredentials(tls: Tls | undefined): ChannelCredentials {
  if (tls === undefined) return credentials.createInsecure();
  const {ca, cert, key} = tlsContents(tls);
  return credentials.createSsl(ca ?? null, key ?? null, cert ?? null);
}

/** A bearer token, by itself or in a file that is read again when it changes. */
export class TokenSource {
  readonly #file: string | undefined;
  #stamp = '';
  #token: string | undefined;

  /** RangeError if both are given, or the token is no token. An error of the system if the file cannot be read. */
  constructor(token: string | undefined, tokenFile: string | undefined) {
    if (token !== undefined && tokenFile !== undefined) throw new RangeError('token, tokenFile: one of them is enough');
    this.#token = token === undefined ? undefined : checkedToken(token);
    this.#file = tokenFile;
    this.#read();
  }

  /** Undefined if there is none. */
  get token(): string | undefined {
    this.#read();
    return this.#token;
  }

  #read(): void {
    if (this.#file === undefined) return;
    try {
      const {mtimeMs, size, ino} = fs.statSync(this.#file);
      const stamp = `${mtimeMs} ${size} ${ino}`;
      if (stamp === this.#stamp) return;
      this.#token = checkedToken(fs.readFileSync(this.#file, 'latin1').trim());
      this.#stamp = stamp;
    } catch (error) {
      // While the file is being replaced, the token before it is good.
      if (this.#token === undefined) throw error;
    }
  }
}
