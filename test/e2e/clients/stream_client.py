# SPDX-License-Identifier: Apache-2.0
"""A client of SegmentStream that shares no code with segserve: it uses Python's gRPC and the .proto files alone.

    stream_client.py GENERATED ADDRESS FOLDER...

GENERATED holds what protoc --python_out makes of proto/. Each FOLDER is a cloud in the camera's view: x.f32, y.f32, z.f32
and rgb.u8 (planar raw) and shape ("WIDTH HEIGHT"). Its labels are written there, labels.u32, and so are the cuts
that this client makes of its merge tree, regions-7.u32, threshold-0.2.u32 and so on. All clouds go through one stream,
within the credit that the server grants.
"""
import bisect
import itertools
import pathlib
import queue
import struct
import sys
import zlib

sys.path.insert(0, sys.argv[1])
import grpc  # noqa: E402
from segserve.v1 import block_pb2, cloud_pb2, options_pb2, stream_pb2  # noqa: E402

PLANES = ("x.f32", "y.f32", "z.f32", "rgb.u8")


def frame_messages(sequence, folder, chunk_bytes):
    """The messages of a cloud, its header and its chunks, and the bytes of credit that it takes."""
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


def integers(array, data):
    """The values of an IntegerArray."""
    return struct.unpack(f"<{array.count}{ {1: 'B', 2: 'H', 4: 'I'}[array.bytes_per_value] }", data)


def read_result(responses, outcome):
    """Reads what follows an outcome: labels, supervoxels and the columns of the tree."""
    assert outcome.kind == stream_pb2.OUTCOME_KIND_RESULT, outcome
    payload = b""
    while len(payload) < outcome.encoded_bytes:
        payload += next(responses).chunk.data
    assert zlib.crc32(payload) == outcome.crc32, "the result was damaged"

    def take(block):
        nonlocal payload
        assert block.compression == block_pb2.COMPRESSION_NONE, "we did not accept any"
        data, payload = payload[:block.encoded_bytes], payload[block.encoded_bytes:]
        return data

    tree = outcome.result.tree
    arrays = (outcome.result.labels, outcome.result.supervoxels, tree.leaf_points, tree.left, tree.right)
    labels, supervoxels, *columns = [integers(array, take(array.data)) for array in arrays]
    weight = take(tree.weight)
    return labels, supervoxels, *columns, struct.unpack(f"<{len(weight) // 8}d", weight)


def cut(supervoxels, leaf_points, left, right, rows):
    """The segment of every point after the first rows of the tree, numbered as result.proto says."""
    points = list(leaf_points)
    for a, b in zip(left, right):
        points.append(points[a] + points[b])
    root = list(range(len(leaf_points) + rows))
    for row in reversed(range(rows)):
        root[left[row]] = root[right[row]] = root[len(leaf_points) + row]
    smallest = {}
    for leaf in range(len(leaf_points)):
        smallest.setdefault(root[leaf], leaf)
    order = sorted(smallest, key=lambda node: (-points[node], smallest[node]))
    number = {node: i for i, node in enumerate(order, start=1)}
    return [number[root[supervoxel - 1]] if supervoxel > 0 else 0 for supervoxel in supervoxels]


def write_result(folder, responses, outcome):
    """Writes the labels, and the cuts that this client makes."""
    labels, supervoxels, leaf_points, left, right, weight = read_result(responses, outcome)
    height = list(itertools.accumulate(weight, max))
    rows = {"regions-7": max(len(leaf_points) - 7, 0),
            "regions-1": max(len(leaf_points) - 1, 0),
            "threshold-0.2": min(outcome.result.tree.merged_rows, bisect.bisect_left(height, 0.2)),
            "threshold-1": min(outcome.result.tree.merged_rows, bisect.bisect_left(height, 1))}
    arrays = {name: cut(supervoxels, leaf_points, left, right, rows[name]) for name in rows} | {"labels": labels}
    for name, values in arrays.items():
        (folder / f"{name}.u32").write_bytes(struct.pack(f"<{len(values)}I", *values))


def main():
    folders = [pathlib.Path(name) for name in sys.argv[3:]]
    outgoing = queue.Queue()
    with grpc.insecure_channel(sys.argv[2]) as channel:
        call = channel.stream_stream("/segserve.v1.SegmentationService/SegmentStream",
                                     request_serializer=stream_pb2.SegmentStreamRequest.SerializeToString,
                                     response_deserializer=stream_pb2.SegmentStreamResponse.FromString)
        responses = call(iter(outgoing.get, None), timeout=100)
        outgoing.put(stream_pb2.SegmentStreamRequest(open=stream_pb2.StreamOpen(
            client_name="python", outputs=options_pb2.Outputs(labels=True, supervoxels=True, tree=True))))
        opened = next(responses).opened
        frames, credit = opened.credit.frames, opened.credit.bytes
        on_their_way = {}

        def take_outcome():
            nonlocal frames, credit
            outcome = next(responses).outcome
            folder, cost = on_their_way.pop(outcome.sequence)
            write_result(folder, responses, outcome)
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
