// SPDX-License-Identifier: Apache-2.0
// The client for Node.
import {create} from '@bufbuild/protobuf';

import {type Encoding} from '../encode.js';
import {SegserveError, unavailableIfCancelled} from '../errors.js';
import {HealthCheckRequestSchema, HealthCheckResponse_ServingStatus as ServingStatus} from '../gen/health_pb.js';
import {GetServerInfoRequestSchema} from '../gen/segserve/v1/segmentation_service_pb.js';
import {type ServerInfo, serverInfo} from '../info.js';
import {type NamesOf, refuseUnknown} from '../names.js';
import {checkedOutputs, DEFAULT_OUTPUTS, optionsMessage, type Output, type Segmentation, SEGMENTATION_NAMES} from '../options.js';
import {type Prompts} from '../places.js';
import {repeated} from '../repetition.js';
import {type CallOptions, checkedTimeout, fitsMessage, requestMessage, resultOf, type SegmentArguments, segmentCall,
        type SegmentCall} from '../requests.js';
import {type Result} from '../result.js';
import {NAMES_OF_RULES, STREAM_DEFAULTS, streamRules, type StreamRules} from '../stream/frame.js';
import {streamTracking, type TrackRules} from '../tracking.js';
import {Channels} from './channels.js';
import {explained} from './handshake.js';
import {HEALTH, type Method, SEGMENT, SERVER_INFO} from './methods.js';
import {type ClientOptions, Settings} from './settings.js';
import {Stream} from './stream.js';

/** The rules of a stream, and what its frames have unless they say otherwise. */
export type StreamArguments = Partial<StreamRules> & Segmentation & Encoding & {
  /** The parts of the results; by default labels, supervoxels and tree. */
  outputs?: readonly Output[];
  /**
   * Asks for ids that objects keep, Result.tracks. The stream hands the state on from result to result, and takes the time
   * of a frame from its stamp or else from `captured`.
   */
  track?: boolean | TrackRules;
};

const STREAM_NAMES: Record<NamesOf<StreamArguments>, true> = {
  ...NAMES_OF_RULES,
  ...SEGMENTATION_NAMES,
  view: true,
  codec: true,
  errorBound: true,
  unit: true,
  outputs: true,
  track: true,
};

/**
 * Connections to one or more servers.
 *
 *     const client = new Client('robot-a:50051,robot-b:50051');
 *     const result = await client.segment({xyz, rgb, view: 'camera'});
 *     console.log(result.segmentCount, result.labels);
 *
 * A failed call rejects with a SegserveError: one of the server, UNAVAILABLE (no server is in reach), DEADLINE_EXCEEDED, or
 * INTERNAL (the answer is broken). Wrong arguments are a TypeError or a RangeError, before anything is sent.
 */
export class Client {
  readonly #settings: Settings;
  readonly #channels: Channels;
  readonly #streams = new Set<Stream>();

  /**
   * Does not wait for a server: health() does.
   *
   * `address`: HOST:PORT (without a port: 50051), or any other name that gRPC resolves. Several are separated by commas.
   * TypeError, RangeError: the settings make no sense. An error of the system if a file cannot be read.
   */
  constructor(address = '127.0.0.1:50051', options: ClientOptions = {}) {
    this.#settings = new Settings(address, options);
    this.#channels = new Channels(this.#settings);
  }

  /** Segments a cloud. One that is too large for a message goes by a stream, in chunks. */
  async segment(cloud: SegmentArguments): Promise<Result> {
    const call = segmentCall(cloud);
    if (!fitsMessage(call)) return this.#segmentByStream(call, cloud);
    return resultOf(await this.#call(SEGMENT, requestMessage(call), cloud), call);
  }

  /** Opens a stream of frames. Does not wait for a server. TypeError, RangeError: the rules make no sense. */
  stream(given: StreamArguments = {}): Stream {
    refuseUnknown<StreamArguments>('stream', given, STREAM_NAMES);
    const {view, codec, errorBound, unit, outputs = DEFAULT_OUTPUTS} = given;
    const options = {
      ...streamRules(given),
      options: optionsMessage(given),
      outputs: checkedOutputs(outputs),
      retry: this.#settings.retry,
      tracking: streamTracking(given.track),
    };
    return this.#opened(new Stream(this.#channels, options, {view, codec, errorBound, unit}));
  }

  /** What the server can do: version, codecs, limits, methods and options. */
  async info(options: CallOptions = {}): Promise<ServerInfo> {
    return serverInfo(await this.#call(SERVER_INFO, create(GetServerInfoRequestSchema), options));
  }

  /** Whether the server says SERVING (grpc.health.v1). UNAVAILABLE if no server answers, NOT_FOUND for an unknown service. */
  async health(service = '', options: CallOptions = {}): Promise<boolean> {
    const response = await this.#call(HEALTH, create(HealthCheckRequestSchema, {service}), options);
    return response.status === ServingStatus.SERVING;
  }

  /** Closes the streams, whose unfinished frames end as CANCELLED, and the connections when their calls have ended. */
  async close(): Promise<void> {
    await Promise.all([...this.#streams].map((stream) => stream.close()));
    this.#streams.clear();
    this.#channels.close();
  }

  #opened(stream: Stream): Stream {
    for (const other of this.#streams) {
      if (other.done) this.#streams.delete(other);
    }
    this.#streams.add(stream);
    return stream;
  }

  async #segmentByStream(call: SegmentCall, {timeoutMs, signal, prompts}: CallOptions & {prompts?: Prompts}): Promise<Result> {
    const frameTimeoutMs = checkedTimeout(timeoutMs ?? this.#settings.timeoutMs);
    const options = {
      ...STREAM_DEFAULTS,
      maxInFlight: 1,
      wantedBytes: call.payload.size,
      frameTimeoutMs,
      waitForServer: this.#settings.waitForServer,
      options: call.options,
      outputs: call.outputs,
      retry: this.#settings.retry,
      tracking: call.tracking && {request: call.tracking, isTimed: false},
    };
    const stream = this.#opened(new Stream(this.#channels, options, {}));
    const cancel = () => stream.cancel(1);
    signal?.addEventListener('abort', cancel, {once: true});
    try {
      await stream.send({payload: call.payload, prompts, ...call.echo});
      if (signal?.aborted) cancel();
      const outcome = await stream.next();
      if (outcome === undefined) throw new SegserveError('CANCELLED', 'the client was closed');
      return outcome.get();
    } finally {
      signal?.removeEventListener('abort', cancel);
      await stream.close();
    }
  }

  /** Makes a unary call, again and elsewhere while that may help. */
  async #call<Request, Response>(method: Method<Request, Response>, request: Request,
                                 {timeoutMs, signal, traceparent}: CallOptions): Promise<Response> {
    const {addresses, retry, waitForServer, tls} = this.#settings;
    const rules = {addresses: addresses.length, first: this.#settings.nextStart(), retry, waitForServer};
    const metadata = this.#settings.metadata(traceparent);
    return repeated(rules, checkedTimeout(timeoutMs ?? this.#settings.timeoutMs), signal, async (address, timeLeftMs) => {
      const channel = this.#channels.get(address);
      try {
        return await channel.unary(method, request, metadata, timeLeftMs, signal);
      } catch (error) {
        if (!(error instanceof SegserveError)) throw error;
        if (signal?.aborted) throw new SegserveError('CANCELLED', 'the caller cancelled the call');
        const isCut = error.code === 'UNAVAILABLE' && error.reason === '';
        if (isCut) this.#channels.renew(address, channel);  // the next attempt shall not wait for gRPC's own backoff
        throw await explained(unavailableIfCancelled(error), channel.address, tls);
      }
    });
  }
}
