"""A client of SegmentStream that shares no code with ours: Python's gRPC and nothing but the .proto files.

    stream_client.py GENERATED ADDRESS FOLDER..

GENERATED holds what protoc --python_out made of proto/. Each FOLDER is a cloud in the camera's view: x.f32, y.f32, z.f32
and rgb.u8 (planar raw) and shape ("WIDTH HEIGHT"); its labels are written there, labels.u32. All clouds go through one
stream, within the server's credit.
"""
import pathlib
import queue
import struct
import sys
import zlib

sys.path.insert(0, sys.argv[1])
import grpc  # noqa: E402
from segserve.v1alpha1 import block_pb2, cloud_pb2, stream_pb2  # noqa: E402

PLANES = ("x.f32", "y.f32", "z.f32", "rgb.u8")


def frame_messages(sequence, folder, chunk_bytes):
    """The header and the chunks of a cloud; also the bytes of credit that it takes."""
    planes = [(folder / name).read_bytes() for name in PLANES]
    width, height = map(int, (folder / "shape").read_text().split())
    blocks = [block_pb2.Block(compression=block_pb2.COMPRESSION_NONE, decoded_bytes=len(plane), encoded_bytes=len(plane))
              for plane in planes]
    payload = b"".join(planes)
    header = stream_pb2.FrameHeader(
        sequence=sequence, encoded_bytes=len(payload), points=width * height, crc32=zlib.crc32(payload),
        cloud=cloud_pb2.Cloud(width=width, height=height, view=cloud_pb2.View(kind=cloud_pb2.VIEW_KIND_CAMERA),
                              planar=cloud_pb2.PlanarCloud(x=blocks[0], y=blocks[1], z=blocks[2], rgb=blocks[3])))
    messages = [stream_pb2.SegmentStreamRequest(frame=header)]
    for start in range(0, len(payload), chunk_bytes):
        chunk = stream_pb2.FrameChunk(sequence=sequence, data=payload[start:start + chunk_bytes])
        messages.append(stream_pb2.SegmentStreamRequest(chunk=chunk))
    return messages, len(payload)


def read_result(responses, outcome):
    """The labels that follow an outcome, 4 bytes each."""
    assert outcome.kind == stream_pb2.OUTCOME_KIND_RESULT, outcome
    payload = b""
    while len(payload) < outcome.encoded_bytes:
        payload += next(responses).chunk.data
    assert zlib.crc32(payload) == outcome.crc32, "the result was damaged"
    labels = outcome.result.labels
    kind = {1: "B", 2: "H", 4: "I"}[labels.bytes_per_label]
    return struct.pack(f"<{labels.count}I", *struct.unpack(f"<{labels.count}{kind}", payload))


def main():
    folders = [pathlib.Path(name) for name in sys.argv[3:]]
    outgoing = queue.Queue()
    with grpc.insecure_channel(sys.argv[2]) as channel:
        call = channel.stream_stream("/segserve.v1alpha1.SegmentationService/SegmentStream",
                                     request_serializer=stream_pb2.SegmentStreamRequest.SerializeToString,
                                     response_deserializer=stream_pb2.SegmentStreamResponse.FromString)
        responses = call(iter(outgoing.get, None), timeout=100)
        outgoing.put(stream_pb2.SegmentStreamRequest(open=stream_pb2.StreamOpen(client_name="python")))
        opened = next(responses).opened
        frames, credit = opened.credit.frames, opened.credit.bytes
        on_their_way = {}

        def take_outcome():
            nonlocal frames, credit
            outcome = next(responses).outcome
            folder, cost = on_their_way.pop(outcome.sequence)
            (folder / "labels.u32").write_bytes(read_result(responses, outcome))
            frames, credit = frames + 1, credit + cost

        for sequence, folder in enumerate(folders, start=1):
            messages, cost = frame_messages(sequence, folder, opened.max_chunk_bytes)
            while frames == 0 or credit < cost:
                take_outcome()
            frames, credit = frames - 1, credit - cost
            on_their_way[sequence] = folder, cost
            for message in messages:
                outgoing.put(message)
        outgoing.put(None)
        while on_their_way:
            take_outcome()
        assert next(responses, None) is None, "something came after the last outcome"


main()
