// SPDX-License-Identifier: Apache-2.0
// The calls of the API, and how their messages become bytes and back.
import {type DescMessage, fromBinary, type MessageShape, toBinary} from '@bufbuild/protobuf';

import {HealthCheckRequestSchema, HealthCheckResponseSchema} from '../gen/health_pb.js';
import {GetServerInfoRequestSchema, GetServerInfoResponseSchema, SegmentRequestSchema,
        SegmentResponseSchema} from '../gen/segserve/v1/segmentation_service_pb.js';
import {type SegmentStreamResponse, SegmentStreamResponseSchema} from '../gen/segserve/v1/stream_pb.js';

export interface Method<Request, Response> {
  readonly path: string;
  readonly serialize: (request: Request) => Buffer;
  readonly parse: (bytes: Buffer) => Response;
}

function bufferOf(bytes: Uint8Array): Buffer {
  return Buffer.from(bytes.buffer, bytes.byteOffset, bytes.byteLength);
}

function method<Request extends DescMessage, Response extends DescMessage>(
    path: string, request: Request, response: Response): Method<MessageShape<Request>, MessageShape<Response>> {
  return {
    path,
    serialize: (message) => bufferOf(toBinary(request, message)),
    parse: (bytes) => fromBinary(response, bytes),
  };
}

const SERVICE = '/segserve.v1.SegmentationService/';
export const SEGMENT = method(`${SERVICE}Segment`, SegmentRequestSchema, SegmentResponseSchema);
export const SERVER_INFO = method(`${SERVICE}GetServerInfo`, GetServerInfoRequestSchema, GetServerInfoResponseSchema);
export const HEALTH = method('/grpc.health.v1.Health/Check', HealthCheckRequestSchema, HealthCheckResponseSchema);

/** A message with its size, bytes. */
export interface Received {
  readonly message: SegmentStreamResponse;
  readonly size: number;
}

/** Its requests are serialized already. */
export const STREAM: Method<Uint8Array, Received> = {
  path: `${SERVICE}SegmentStream`,
  serialize: bufferOf,
  parse: (bytes) => ({message: fromBinary(SegmentStreamResponseSchema, bytes), size: bytes.length}),
};
