// SPDX-License-Identifier: Apache-2.0
// A server of gRPC whose answers the test chooses. It knows the protocol, and segments nothing.
import {ours, theirs} from './package.js';
import {chunk, opened, outcome, response, statusOf} from './stream_harness.js';

const grpc = await theirs('@grpc/grpc-js');
const {create, fromBinary, toBinary} = await theirs('@bufbuild/protobuf');
const {crc32} = await ours('crc32');
const {STATUS_CODES} = await ours('errors');
const {StatusSchema} = await ours('gen/google/rpc/status_pb');
const {HealthCheckRequestSchema, HealthCheckResponseSchema, HealthCheckResponse_ServingStatus: ServingStatus} =
    await ours('gen/health_pb');
const {ViewKind} = await ours('gen/segserve/v1/cloud_pb');
const {Method} = await ours('gen/segserve/v1/options_pb');
const {GetServerInfoRequestSchema, GetServerInfoResponseSchema, SegmentRequestSchema, SegmentResponseSchema} =
    await ours('gen/segserve/v1/segmentation_service_pb');
const {OutcomeKind, SegmentStreamRequestSchema, SegmentStreamResponseSchema} = await ours('gen/segserve/v1/stream_pb');

export {OutcomeKind, response};

/** A result in which every point is in segment 1, but for the bytes of the labels. */
export function emptyResult(points) {
  const count = BigInt(points);
  const summary = {points: count, finitePoints: count, segmentedPoints: count, supervoxels: 1, segments: 1,
                   method: Method.BORDER, view: {kind: ViewKind.CAMERA}};
  return {summary, labels: {count, bytesPerValue: 1, data: {}}};
}

export function labelBytes(points) {
  return new Uint8Array(points).fill(1);
}

/** The messages of a result for a frame. */
export function resultOf(header) {
  const data = labelBytes(Number(header.points));
  const number = Number(header.sequence);
  const encodedBytes = BigInt(data.length);
  const result = emptyResult(data.length);
  result.labels.data = {encodedBytes};
  return [outcome(number, OutcomeKind.RESULT, {result, encodedBytes, crc32: crc32(data)}), chunk(number, data)];
}

function handler(path, request, answer, isStream = false) {
  return {path, requestStream: isStream, responseStream: isStream,
          requestSerialize: (message) => Buffer.from(toBinary(request, message)),
          requestDeserialize: (bytes) => fromBinary(request, bytes),
          responseSerialize: (message) => (Buffer.isBuffer(message) ? message : Buffer.from(toBinary(answer, message))),
          responseDeserialize: (bytes) => fromBinary(answer, bytes)};
}

const SERVICE = '/segserve.v1.SegmentationService/';
const METHODS = {
  segment: handler(`${SERVICE}Segment`, SegmentRequestSchema, SegmentResponseSchema),
  info: handler(`${SERVICE}GetServerInfo`, GetServerInfoRequestSchema, GetServerInfoResponseSchema),
  stream: handler(`${SERVICE}SegmentStream`, SegmentStreamRequestSchema, SegmentStreamResponseSchema, true),
  health: handler('/grpc.health.v1.Health/Check', HealthCheckRequestSchema, HealthCheckResponseSchema),
};

export class FakeServer {
  errors = [];            // SegserveErrors or answers as bytes that the next calls get before those after them succeed
  metadata = [];          // of every call
  requests = [];          // of unary calls
  headers = [];           // of the frames of all streams
  onFrame = resultOf;     // the messages that a frame gets; may be a promise
  silent = false;         // probes get no answer
  #server = new grpc.Server();

  /** Resolves to a server that listens. */
  static async start(credentials = grpc.ServerCredentials.createInsecure()) {
    const server = new FakeServer();
    server.#server.addService(METHODS, {
      segment: (call, done) => server.#unary(call, done, (request) => ({result: server.result(request)})),
      info: (call, done) => (server.silent ? undefined : server.#unary(call, done, () => ({version: 'fake'}))),
      health: (call, done) => server.#unary(call, done, () => ({status: ServingStatus.SERVING})),
      stream: (call) => server.#stream(call),
    });
    const port = await new Promise((resolve, reject) => {
      server.#server.bindAsync('127.0.0.1:0', credentials, (error, bound) => (error ? reject(error) : resolve(bound)));
    });
    server.address = `127.0.0.1:${port}`;
    return server;
  }

  close() { this.#server.forceShutdown(); }

  /** The result of a unary call. */
  result({cloud}) {
    const points = cloud.width * cloud.height;
    const result = emptyResult(points);
    result.labels.data = {data: labelBytes(points)};
    return result;
  }

  #unary(call, done, answer) {
    this.metadata.push(call.metadata.getMap());
    const error = this.errors.shift();
    if (Buffer.isBuffer(error)) return done(null, error);
    if (error !== undefined) return done(failure(error));
    this.requests.push(call.request);
    return done(null, create(call.path.includes('Health') ? HealthCheckResponseSchema :
                             call.path.endsWith('Info')   ? GetServerInfoResponseSchema :
                                                            SegmentResponseSchema, answer(call.request)));
  }

  #stream(call) {
    this.metadata.push(call.metadata.getMap());
    const error = this.errors.shift();
    if (error !== undefined) {
      call.emit('error', failure(error));
      return;
    }
    let header, missing = 0;
    call.on('error', () => {});
    call.on('end', () => call.end());
    call.on('data', ({kind}) => {
      if (kind.case === 'open') call.write(opened(4, 64 << 20));
      if (kind.case === 'frame') {
        header = kind.value;
        missing = Number(header.encodedBytes);
        this.headers.push(header);
      }
      if (kind.case === 'chunk') missing -= kind.value.data.length;
      if (header !== undefined && missing === 0) {
        void this.#answer(call, header);
        header = undefined;
      }
    });
  }

  async #answer(call, header) {
    for (const message of await this.onFrame(header)) call.write(message);
  }
}

/** What grpc-js makes an error of a call of. */
function failure(error) {
  const metadata = new grpc.Metadata();
  if (error.reason !== '') {
    metadata.set('grpc-status-details-bin', Buffer.from(toBinary(StatusSchema, create(StatusSchema, statusOf(error)))));
  }
  return Object.assign(new Error(error.message), {code: STATUS_CODES.indexOf(error.code), details: error.message, metadata});
}
