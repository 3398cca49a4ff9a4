// SPDX-License-Identifier: Apache-2.0
// Where the servers are, and how they are reached.
import {type ChannelOptions, Metadata} from '@grpc/grpc-js';

import {checkedRetry, type Retry} from '../address_book.js';
import {refuseUnknown} from '../names.js';
import {checkedTimeout, checkedTraceparent} from '../requests.js';
import {isLoopback, parseAddresses} from './addresses.js';
import {checkedTls, type Tls, TokenSource} from './credentials.js';

/** How servers are reached. */
export interface ClientOptions {
  /** A bearer token. It is sent over TLS or to this machine only, unless `unprotectedToken` is true. */
  token?: string;
  /** A file with a bearer token, which is read again when it changes. */
  tokenFile?: string;
  /** Connects by TLS. `true` believes the certificate authorities of Node. */
  tls?: Tls | boolean;
  /** Of a call with all its repetitions, if it sets none itself, milliseconds. By default 30,000. */
  timeoutMs?: number;
  /** When no address is in reach, a call waits for one until its timeout instead of failing with UNAVAILABLE. */
  waitForServer?: boolean;
  retry?: Partial<Retry>;
  /** Connections beyond this machine go through the proxy that the environment names. */
  useProxy?: boolean;
  unprotectedToken?: boolean;
}

const OPTION_NAMES: Record<keyof ClientOptions, true> = {
  token: true,
  tokenFile: true,
  tls: true,
  timeoutMs: true,
  waitForServer: true,
  retry: true,
  useProxy: true,
  unprotectedToken: true,
};
const DEFAULT_TIMEOUT_MS = 30_000;
const MOST_RECEIVED_BYTES = 64 << 20;
const FLOW_CONTROL_BYTES = 4 << 20;

/** The settings of a client, checked. */
export class Settings {
  readonly addresses: readonly string[];
  readonly timeoutMs: number;
  readonly waitForServer: boolean;
  readonly retry: Retry;
  readonly tls: Tls | undefined;
  readonly #useProxy: boolean;
  readonly #token: TokenSource;
  #starts = 0;

  /** TypeError, RangeError: the settings make no sense. An error of the system if a file cannot be read. */
  constructor(address: string, options: ClientOptions) {
    refuseUnknown('client', options, OPTION_NAMES);
    this.addresses = parseAddresses(address);
    this.timeoutMs = checkedTimeout(options.timeoutMs ?? DEFAULT_TIMEOUT_MS);
    this.waitForServer = options.waitForServer ?? false;
    this.retry = checkedRetry(options.retry);
    this.tls = checkedTls(options.tls);
    this.#useProxy = options.useProxy ?? false;
    this.#token = new TokenSource(options.token, options.tokenFile);
    const exposed = this.addresses.find((name) => !isLoopback(name));
    if (this.#token.token !== undefined && this.tls === undefined && !options.unprotectedToken && exposed !== undefined) {
      throw new RangeError(`token: it would cross the network to ${exposed} for everyone to read; use tls, or ` +
                           'unprotectedToken: true if the network itself is trusted');
    }
  }

  /** The address at which the next call or stream begins. */
  nextStart(): number {
    return this.#starts++;
  }

  /** The metadata of a call. RangeError if `traceparent` is none of the W3C's. */
  metadata(traceparent?: string): Metadata {
    const metadata = new Metadata();
    const {token} = this.#token;
    if (token !== undefined) metadata.set('authorization', `Bearer ${token}`);
    if (traceparent !== undefined) metadata.set('traceparent', checkedTraceparent(traceparent));
    return metadata;
  }

  /** The arguments of a channel of gRPC. Calls are repeated by this package, which must not wait for gRPC's own retries. */
  channelOptions(address: string): ChannelOptions {
    return {
      'grpc.enable_http_proxy': this.#useProxy && !isLoopback(address) ? 1 : 0,
      'grpc.enable_retries': 0,
      // Without a buffer, a write is done when HTTP/2's flow control has let it pass, which is a sign of life.
      'grpc.per_rpc_retry_buffer_size': 0,
      'grpc.max_receive_message_length': MOST_RECEIVED_BYTES,
      'grpc.max_send_message_length': -1,
      'grpc.use_local_subchannel_pool': 1,
      'grpc-node.flow_control_window': FLOW_CONTROL_BYTES,
      'grpc.service_config': JSON.stringify({loadBalancingConfig: [{round_robin: {}}]}),
      ...(this.tls?.serverName === undefined ? {} : {'grpc.ssl_target_name_override': this.tls.serverName}),
    };
  }
}
