// SPDX-License-Identifier: Apache-2.0
// Finds out why a connection failed that has to do with TLS, which gRPC hardly tells.
import tls from 'node:tls';

import {SegserveError, TlsError} from '../errors.js';
import {type Tls, tlsContents} from './credentials.js';

const PATIENCE_MS = 2000;  // for one handshake
const ADDRESS = /^(?:\[([^\]]+)\]|([^:/]+)):(\d+)$/;
const NOT_TLS = ['ERR_SSL_WRONG_VERSION_NUMBER', 'ERR_SSL_PACKET_LENGTH_TOO_LONG', 'ERR_SSL_RECORD_LAYER_FAILURE',
                 'ERR_SSL_UNEXPECTED_EOF_WHILE_READING', 'ERR_SSL_HTTP_REQUEST', 'ECONNRESET', 'EPIPE'];

/** How a handshake went. `ended`: the server ended the connection at once after it, as it does with a client that it refuses. */
type Handshake = {readonly kind: 'done' | 'ended' | 'unreachable'} |
                 {readonly kind: 'failed', readonly code: string, readonly message: string};

/** The error of a call to `address`, or a TlsError that tells the cause, if TLS is the cause. Takes some seconds at most. */
export async function explained(error: SegserveError, address: string, settings: Tls | undefined): Promise<SegserveError> {
  if (error.code !== 'UNAVAILABLE' || error.reason !== '' || error.message.includes('ECONNREFUSED')) return error;
  const found = ADDRESS.exec(address);
  if (found === null) return error;
  const place = {host: found[1] ?? found[2], port: Number(found[3])};
  const fault = settings === undefined ? await speaksTls(place) : await handshakeFault(place, settings);
  return fault === undefined ? error : new TlsError(`${address}: ${fault}`);
}

interface Place {
  readonly host: string;
  readonly port: number;
}

/** What is wrong with a handshake as gRPC makes it; undefined if it succeeds or nobody listens. */
async function handshakeFault(place: Place, settings: Tls): Promise<string | undefined> {
  const refusal = settings.cert === undefined ? 'it asks for a certificate' : `it does not believe the client's certificate`;
  let handshake: Handshake;
  try {
    handshake = await shakeHands({...place, ...tlsContents(settings), servername: settings.serverName ?? nameOf(place)});
  } catch (error) {
    return `the files of TLS cannot be used: ${(error as Error).message}`;
  }
  if (handshake.kind === 'ended') return `the server refuses the client: ${refusal}`;
  if (handshake.kind !== 'failed') return undefined;
  const {code, message} = handshake;
  if (NOT_TLS.includes(code)) return 'the server does not speak TLS';
  if (/ALERT.*(CERTIFICATE|_CA$)/.test(code)) return `the server refuses the client: ${refusal}`;
  if (code.startsWith('ERR_SSL')) return `the server refuses the handshake: ${message}`;
  return `the certificate of the server is not believed: ${message}`;
}

async function speaksTls(place: Place): Promise<string | undefined> {
  const handshake = await shakeHands({...place, servername: nameOf(place), rejectUnauthorized: false});
  // An alert, such as one that asks for a certificate, is TLS, too.
  const isTls = handshake.kind === 'done' || handshake.kind === 'ended' ||
                (handshake.kind === 'failed' && handshake.code.startsWith('ERR_SSL') && !NOT_TLS.includes(handshake.code));
  return isTls ? 'the server speaks TLS, and the client does not: use {tls: ..}' : undefined;
}

/** The name that is asked for; none for an IP address. */
function nameOf({host}: Place): string {
  return /^[\d.]+$|:/.test(host) ? '' : host;
}

/** Never rejects but for files that cannot be used. */
function shakeHands(options: tls.ConnectionOptions): Promise<Handshake> {
  return new Promise((resolve) => {
    let isSecure = false;
    const socket = tls.connect({...options, ALPNProtocols: ['h2'], timeout: PATIENCE_MS});
    const finish = (handshake: Handshake) => {
      socket.destroy();
      resolve(handshake);
    };
    socket.on('secureConnect', () => { isSecure = true; });
    socket.on('data', () => finish({kind: 'done'}));  // A server that is content begins with its settings.
    socket.on('end', () => finish({kind: isSecure ? 'ended' : 'unreachable'}));
    socket.on('timeout', () => finish({kind: isSecure ? 'done' : 'unreachable'}));
    socket.on('error', (error: NodeJS.ErrnoException) => {
      const isUnreachable = ['ECONNREFUSED', 'ENOTFOUND', 'EAI_AGAIN', 'EHOSTUNREACH', 'ENETUNREACH'].includes(error.code ?? '');
      if (isUnreachable) finish({kind: 'unreachable'});
      else finish({kind: 'failed', code: error.code ?? '', message: error.message});
    });
  });
}
