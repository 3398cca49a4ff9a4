// SPDX-License-Identifier: Apache-2.0
// A channel of gRPC to each address, made when it is needed first.
import {Client as GrpcClient, type ClientDuplexStream, type Metadata, type ServiceError} from '@grpc/grpc-js';

import {SegserveError} from '../errors.js';
import {channelCredentials} from './credentials.js';
import {callError} from './grpc_status.js';
import {type Method} from './methods.js';
import {type Settings} from './settings.js';

/** A channel, which closes when it is retired and its last call has ended. */
export class Channel {
  #calls = 0;
  #retired = false;

  constructor(readonly address: string, private readonly client: GrpcClient) {}

  /** Makes a unary call. SegserveError if it fails. */
  unary<Request, Response>(method: Method<Request, Response>, request: Request, metadata: Metadata, timeLeftMs: number,
                           signal?: AbortSignal): Promise<Response> {
    const deadline = Date.now() + timeLeftMs;
    this.#calls += 1;
    return new Promise<Response>((resolve, reject) => {
      const call = this.client.makeUnaryRequest(
          method.path, method.serialize, method.parse, request, metadata, {deadline},
          (error: ServiceError | null, response?: Response) => {
            signal?.removeEventListener('abort', cancel);
            this.#ended();
            if (error !== null) reject(callError(error, this.address));
            else resolve(response as Response);
          });
      const cancel = () => call.cancel();
      signal?.addEventListener('abort', cancel, {once: true});
      if (signal?.aborted) cancel();
    });
  }

  /** Opens a call with messages both ways. */
  duplex<Request, Response>(method: Method<Request, Response>, metadata: Metadata): ClientDuplexStream<Request, Response> {
    this.#calls += 1;
    const call = this.client.makeBidiStreamRequest(method.path, method.serialize, method.parse, metadata);
    call.once('status', () => this.#ended());
    return call;
  }

  /** No more calls will be made. */
  retire(): void {
    this.#retired = true;
    if (this.#calls === 0) this.client.close();
  }

  #ended(): void {
    this.#calls -= 1;
    if (this.#retired && this.#calls === 0) this.client.close();
  }
}

export class Channels {
  readonly settings: Settings;
  readonly #channels = new Map<number, Channel>();
  #closed = false;

  constructor(settings: Settings) {
    this.settings = settings;
  }

  /** SegserveError (FAILED_PRECONDITION) after close(). An error of the system if a file of TLS cannot be read. */
  get(address: number): Channel {
    if (this.#closed) throw new SegserveError('FAILED_PRECONDITION', 'the client was closed');
    const existing = this.#channels.get(address);
    if (existing !== undefined) return existing;
    const name = this.settings.addresses[address];
    const client = new GrpcClient(name, channelCredentials(this.settings.tls), this.settings.channelOptions(name));
    const channel = new Channel(name, client);
    this.#channels.set(address, channel);
    return channel;
  }

  /** A channel is cut, or shall be used no more: the next call makes a new one, and calls on it go on. */
  renew(address: number, cut: Channel): void {
    if (this.#channels.get(address) !== cut) return;
    this.#channels.delete(address);
    cut.retire();
  }

  close(): void {
    this.#closed = true;
    for (const channel of this.#channels.values()) channel.retire();
    this.#channels.clear();
  }
}
