# SPDX-License-Identifier: Apache-2.0
"""A server of gRPC whose answers the test chooses. It knows the protocol, and segments nothing."""
import concurrent.futures
import threading
import zlib

import grpc

from segserve.rpc import error_details_pb2, health_pb2, status_pb2
from segserve.v1 import options_pb2, segmentation_service_pb2, stream_pb2
from stream_harness import opened


def fill_result(message, points):
    """Every point is in segment 1."""
    summary = message.summary
    summary.points = summary.finite_points = summary.segmented_points = points
    summary.supervoxels = summary.segments = 1
    summary.method, summary.view.kind = options_pb2.METHOD_BORDER, 1
    message.labels.count, message.labels.bytes_per_value = points, 1
    return b"\1" * points


class FakeServer:
    """`errors` are raised, one a call, before the calls after them succeed: (code, message, reason, retry in ms)."""

    def __init__(self, errors=(), credentials=None):
        self.errors = list(errors)
        self.metadata = []  # of every call
        self.requests = []
        self.headers = []  # of the frames of all streams
        self.on_frame = None  # called with the stream's send() and the header; None: a result
        self.silent = threading.Event()  # if it is set, probes get no answer
        self._server = grpc.server(concurrent.futures.ThreadPoolExecutor(8), options=[("grpc.so_reuseport", 0)])
        handlers = {
            "Segment":
                grpc.unary_unary_rpc_method_handler(self._segment, segmentation_service_pb2.SegmentRequest.FromString,
                                                    segmentation_service_pb2.SegmentResponse.SerializeToString),
            "GetServerInfo":
                grpc.unary_unary_rpc_method_handler(self._info,
                                                    segmentation_service_pb2.GetServerInfoRequest.FromString,
                                                    segmentation_service_pb2.GetServerInfoResponse.SerializeToString),
            "SegmentStream":
                grpc.stream_stream_rpc_method_handler(self._stream, stream_pb2.SegmentStreamRequest.FromString,
                                                      stream_pb2.SegmentStreamResponse.SerializeToString)
        }
        health = {"Check": grpc.unary_unary_rpc_method_handler(
            self._health, health_pb2.HealthCheckRequest.FromString, health_pb2.HealthCheckResponse.SerializeToString)}
        self._server.add_generic_rpc_handlers((
            grpc.method_handlers_generic_handler("segserve.v1.SegmentationService", handlers),
            grpc.method_handlers_generic_handler("grpc.health.v1.Health", health)))
        if credentials is None:
            port = self._server.add_insecure_port("127.0.0.1:0")
        else:
            port = self._server.add_secure_port("127.0.0.1:0", credentials)
        self.address = f"127.0.0.1:{port}"
        self._server.start()

    def close(self):
        self.silent.clear()
        self._server.stop(None).wait()

    def _note(self, context):
        self.metadata.append(dict(context.invocation_metadata()))
        if not self.errors:
            return
        code, message, reason, retry = self.errors.pop(0)
        if reason:
            status = status_pb2.Status(code=code.value[0], message=message)
            status.details.add(type_url="type.googleapis.com/google.rpc.ErrorInfo",
                               value=error_details_pb2.ErrorInfo(reason=reason).SerializeToString())
            delay = error_details_pb2.RetryInfo()
            delay.retry_delay.FromMilliseconds(retry)
            status.details.add(type_url="type.googleapis.com/google.rpc.RetryInfo", value=delay.SerializeToString())
            context.set_trailing_metadata([("grpc-status-details-bin", status.SerializeToString())])
        context.abort(code, message)

    def _segment(self, request, context):
        self._note(context)
        self.requests.append(request)
        response = segmentation_service_pb2.SegmentResponse()
        response.result.labels.data.data = fill_result(response.result, request.cloud.width * request.cloud.height)
        return response

    def _info(self, request, context):
        if self.silent.is_set():
            context.abort(grpc.StatusCode.UNAVAILABLE, "silent")
        self._note(context)
        return segmentation_service_pb2.GetServerInfoResponse(version="fake")

    def _health(self, request, context):
        self._note(context)
        return health_pb2.HealthCheckResponse(status=health_pb2.HealthCheckResponse.SERVING)

    def _stream(self, requests, context):
        self._note(context)
        missing, header = 0, None
        for request in requests:
            if request.HasField("open"):
                yield opened(size=64 << 20)
            elif request.HasField("frame"):
                header, missing = request.frame, request.frame.encoded_bytes
                self.headers.append(header)
            elif request.HasField("chunk"):
                missing -= len(request.chunk.data)
            if header is not None and missing == 0:
                yield from (self.on_frame or self.result)(header)
                header = None

    @staticmethod
    def result(header):
        """The messages of a result for a frame."""
        outcome = stream_pb2.FrameOutcome(sequence=header.sequence, kind=stream_pb2.OUTCOME_KIND_RESULT)
        data = fill_result(outcome.result, header.points)
        outcome.result.labels.data.encoded_bytes = outcome.encoded_bytes = len(data)
        outcome.crc32 = zlib.crc32(data)
        yield stream_pb2.SegmentStreamResponse(outcome=outcome)
        yield stream_pb2.SegmentStreamResponse(chunk=stream_pb2.ResultChunk(sequence=header.sequence, data=data))
