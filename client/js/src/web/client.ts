// SPDX-License-Identifier: Apache-2.0
// The client for browsers: unary calls by the Connect protocol, over the web entrance of a server (`segserve --http`).
import {type CallOptions as ConnectOptions, type Client as ConnectClient, createClient} from '@connectrpc/connect';
import {createConnectTransport} from '@connectrpc/connect-web';

import {checkedRetry, type Retry} from '../address_book.js';
import {unavailableIfCancelled} from '../errors.js';
import {SegmentationService} from '../gen/segserve/v1/segmentation_service_pb.js';
import {type ServerInfo, serverInfo} from '../info.js';
import {refuseUnknown} from '../names.js';
import {repeated} from '../repetition.js';
import {type CallOptions, checkedTimeout, checkedTraceparent, fitsMessage, MOST_REQUEST_BYTES, requestMessage, resultOf,
        type SegmentArguments, segmentCall} from '../requests.js';
import {type Result} from '../result.js';
import {checkedToken} from '../token.js';
import {webError} from './connect_status.js';
import {isProtected, parseUrls} from './urls.js';

/** How servers are reached. */
export interface ClientOptions {
  /** A bearer token. It is sent by https or to this machine only, unless `unprotectedToken` is true. */
  token?: string;
  /** Of a call with all its repetitions, if it sets none itself, milliseconds. By default 30,000. */
  timeoutMs?: number;
  /** When no address is in reach, a call waits for one until its timeout instead of failing with UNAVAILABLE. */
  waitForServer?: boolean;
  retry?: Partial<Retry>;
  unprotectedToken?: boolean;
  /** Makes the requests instead of the platform's fetch. */
  fetch?: typeof globalThis.fetch;
}

const OPTION_NAMES: Record<keyof ClientOptions, true> =
    {token: true, timeoutMs: true, waitForServer: true, retry: true, unprotectedToken: true, fetch: true};
const DEFAULT_TIMEOUT_MS = 30_000;

/**
 * Calls one or more servers over their web entrance.
 *
 *     const client = new Client('https://robots.example:8443');
 *     const result = await client.segment({xyz, rgb, view: 'camera'});
 *     console.log(result.segmentCount, result.labels);
 *
 * A failed call rejects with a SegserveError: one of the server, UNAVAILABLE (no server is in reach, or it does not allow
 * the origin of the page), DEADLINE_EXCEEDED, or INTERNAL (the answer is broken). Wrong arguments are a TypeError or a
 * RangeError, before anything is sent. Streams need the client for Node.
 */
export class Client {
  readonly #urls: readonly string[];
  readonly #servers: readonly ConnectClient<typeof SegmentationService>[];
  readonly #token: string | undefined;
  readonly #timeoutMs: number;
  readonly #waitForServer: boolean;
  readonly #retry: Retry;
  #starts = 0;

  /**
   * `url`: where the web entrance is, such as "https://robots.example:8443". Several are separated by commas. TypeError,
   * RangeError: the settings make no sense.
   */
  constructor(url: string, options: ClientOptions = {}) {
    refuseUnknown('client', options, OPTION_NAMES);
    this.#urls = parseUrls(url);
    this.#token = options.token === undefined ? undefined : checkedToken(options.token);
    const exposed = this.#urls.find((each) => !isProtected(each));
    if (this.#token !== undefined && exposed !== undefined && !options.unprotectedToken) {
      throw new RangeError(`token: it would cross the network to ${exposed} for everyone to read; use https, or ` +
                           'unprotectedToken: true if the network itself is trusted');
    }
    this.#timeoutMs = checkedTimeout(options.timeoutMs ?? DEFAULT_TIMEOUT_MS);
    this.#waitForServer = options.waitForServer ?? false;
    this.#retry = checkedRetry(options.retry);
    this.#servers = this.#urls.map((baseUrl) => createClient(
        SegmentationService, createConnectTransport({baseUrl, useBinaryFormat: true, fetch: options.fetch})));
  }

  /** Segments a cloud. RangeError if it is too large for a message of 8 MiB. */
  async segment(cloud: SegmentArguments): Promise<Result> {
    const call = segmentCall(cloud);
    if (!fitsMessage(call)) {
      throw new RangeError(`cloud: it has ${call.payload.size} bytes, and at most ${MOST_REQUEST_BYTES} fit into a message; ` +
                           `the codec 'quantised' makes it smaller, and the client for Node sends larger ones`);
    }
    const request = requestMessage(call);
    return resultOf(await this.#call((server, options) => server.segment(request, options), cloud), call);
  }

  /** What the server can do: version, codecs, limits, methods and options. */
  async info(options: CallOptions = {}): Promise<ServerInfo> {
    return serverInfo(await this.#call((server, how) => server.getServerInfo({}, how), options));
  }

  /** Makes a call, again and elsewhere while that may help. */
  async #call<Response>(
      call: (server: ConnectClient<typeof SegmentationService>, options: ConnectOptions) => Promise<Response>,
      {timeoutMs, signal, traceparent}: CallOptions): Promise<Response> {
    const headers: Record<string, string> = {};
    if (this.#token !== undefined) headers['authorization'] = `Bearer ${this.#token}`;
    if (traceparent !== undefined) headers['traceparent'] = checkedTraceparent(traceparent);
    const rules = {addresses: this.#urls.length, first: this.#starts++, retry: this.#retry, waitForServer: this.#waitForServer};
    return repeated(rules, checkedTimeout(timeoutMs ?? this.#timeoutMs), signal, async (address, timeLeftMs) => {
      try {
        return await call(this.#servers[address], {headers, timeoutMs: Math.max(Math.ceil(timeLeftMs), 1), signal});
      } catch (error) {
        const known = webError(error, this.#urls[address]);
        throw signal?.aborted ? known : unavailableIfCancelled(known);
      }
    });
  }
}
