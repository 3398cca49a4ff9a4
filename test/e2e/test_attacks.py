# SPDX-License-Identifier: Apache-2.0
"""A few bytes from a hostile client cost the server little memory, and an honest client next to it gets its labels."""
import array
import os
import queue
import threading
import time
import unittest

import grpc

from harness import EndToEnd
from messages import MIB, OPEN, UNKNOWN, delimited, file_request, varint, zstd_of_repeated

BUDGET = 256 * MIB
BOUNDS_MEMORY = os.environ.get("BOUNDS_MEMORY", "1") == "1"
BEYOND_BUDGET = 128 * MIB  # gRPC's buffers, the program itself, and memory that malloc has not given back
UNARY = "/segserve.v1.SegmentationService/Segment"
STREAM = "/segserve.v1.SegmentationService/SegmentStream"


def lone_points(path, side, step):
    """A cloud whose points stand alone in their voxels."""
    points = array.array("f")
    for i in range(side ** 3):
        points.extend((i % side * step, i // side % side * step, i // side ** 2 * step + 1))
    header = ("VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
              f"WIDTH {side ** 3}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {side ** 3}\nDATA binary\n")
    path.write_bytes(header.encode() + points.tobytes())


class Attacks(EndToEnd):
    server_flags = ("--memory", "256MiB", "--workers", "2")

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = cls.folder / "scene.pcd"
        cls().run_well("synth", "-o", cls.scene, "--quiet", "--width", "320", "--height", "240")

    def setUp(self):
        self.channel = grpc.insecure_channel(self.server.address)
        self.addCleanup(self.channel.close)
        self.unary = self.channel.unary_unary(UNARY)
        self.stream = self.channel.stream_stream(STREAM)

    def tearDown(self):
        if BOUNDS_MEMORY:
            self.assertLess(self.memory("VmHWM"), BUDGET + BEYOND_BUDGET)
        labels, _ = self.segment(self.scene)
        self.assertEqual(labels, self.segment_locally(self.scene)[0])

    def memory(self, what):
        """Bytes of memory of the server: VmRSS now, VmHWM at most so far."""
        with open(f"/proc/{self.server.process.pid}/status", encoding="ascii") as status:
            for line in status:
                if line.startswith(what + ":"):
                    return 1024 * int(line.split()[1])
        raise AssertionError(f"no {what}")

    def refusals(self, request, count):
        """Sends the request `count` times at once; the status codes and texts of the answers."""
        calls = [self.unary.future(request, timeout=60) for _ in range(count)]
        errors = [call.exception() for call in calls]
        return {(error.code(), error.details()) for error in errors}

    def end_of_stream(self, *messages):
        """Sends the messages on one stream; the status that ends it."""
        call = self.stream(iter(messages), timeout=60)
        try:
            for _ in call:
                pass
        except grpc.RpcError as error:
            return error.code(), error.details()
        return grpc.StatusCode.OK, ""

    def test_unknown_fields_in_calls_are_not_built(self):
        told = self.refusals(UNKNOWN * (7 * MIB // 3), 26)
        self.assertTrue(all(code in (grpc.StatusCode.INVALID_ARGUMENT, grpc.StatusCode.RESOURCE_EXHAUSTED)
                            for code, _ in told), told)
        self.assertTrue(any("more than 4096 values" in text for _, text in told), told)

    def test_empty_fields_of_a_strided_cloud_are_not_built(self):
        empty_fields = b"\x1a\x00" * (3 * MIB)
        told = self.refusals(delimited(16, b"".join(delimited(n, empty_fields[:64]) for n in range(5, 16))), 2)
        self.assertTrue(all(code == grpc.StatusCode.INVALID_ARGUMENT for code, _ in told), told)
        for number in range(5, 16):  # one of them is the strided payload
            for code, _ in self.refusals(delimited(16, delimited(number, empty_fields)), 1):
                self.assertIn(code, (grpc.StatusCode.INVALID_ARGUMENT, grpc.StatusCode.RESOURCE_EXHAUSTED))

    def test_unknown_fields_on_streams_are_not_built(self):
        for _ in range(10):
            code, text = self.end_of_stream(OPEN, delimited(2, UNKNOWN * MIB))
            self.assertEqual(code, grpc.StatusCode.INVALID_ARGUMENT)
            self.assertIn("more than 4096 values", text)

    def test_garbage_on_a_stream_is_a_violation_of_the_protocol(self):
        code, text = self.end_of_stream(OPEN, b"\xff\xff\xff\xff")
        self.assertEqual(code, grpc.StatusCode.INVALID_ARGUMENT)
        self.assertIn("no serialized SegmentStreamRequest", text)

    def test_idle_streams_lock_nobody_out(self):
        done = queue.Queue()
        streams = []
        for _ in range(100):
            more = threading.Event()
            self.addCleanup(more.set)

            def messages(more=more):
                yield delimited(1, delimited(6, b"\x08\x40\x10" + varint(512 * MIB)))  # wants 64 frames, 512 MiB
                more.wait()

            streams.append(self.stream(messages()))
            done.put(next(streams[-1]))
        self.assertEqual(done.qsize(), 100)
        labels, _ = self.segment(self.scene)
        self.assertTrue(labels)
        for stream in streams:
            stream.cancel()

    def test_compressed_messages_are_refused(self):
        call = self.unary.future(bytes(5 * MIB), timeout=60, compression=grpc.Compression.Gzip)
        self.assertEqual(call.exception().code(), grpc.StatusCode.UNIMPLEMENTED)

    def test_lone_points_are_refused_with_a_resolution_that_fits(self):
        cloud = self.path("lone.pcd")
        lone_points(cloud, 100, 0.02)
        line = self.run_badly(1, "segment", cloud, "--server", self.server.address, "-o", self.path("out.pcd"),
                              "--voxel-resolution", "0.0075")
        self.assertRegex(line, r"more than memory_bytes = 268435456; a voxel_resolution of [0-9.]+ m would fit")
        resolution = line.split("a voxel_resolution of ")[1].split()[0]
        self.run_well("segment", cloud, "--server", self.server.address, "-o", self.path("out.pcd"), "--quiet",
                      "--voxel-resolution", resolution, "--seed-resolution", str(4 * float(resolution)))

    def test_headers_of_files_have_a_length(self):
        for size in (100 * MIB, 500 * MIB):
            began = time.monotonic()
            for code, _ in self.refusals(file_request(zstd_of_repeated(b"\n", size), size), 4):
                self.assertIn(code, (grpc.StatusCode.INVALID_ARGUMENT, grpc.StatusCode.RESOURCE_EXHAUSTED))
            self.assertLess(time.monotonic() - began, 10)
        many_fields = b"VERSION 0.7\nFIELDS " + b"a " * (3 * MIB)
        began = time.monotonic()
        for code, text in self.refusals(file_request(many_fields), 4):
            self.assertEqual(code, grpc.StatusCode.INVALID_ARGUMENT, text)
        self.assertLess(time.monotonic() - began, 5)

    def test_a_header_of_megabytes_is_refused(self):
        name = delimited(1, b"n" * (4 * MIB))
        code, text = self.end_of_stream(OPEN, delimited(2, b"\x08\x01" + delimited(5, delimited(18, delimited(1, name)))))
        self.assertEqual(code, grpc.StatusCode.INVALID_ARGUMENT)
        self.assertIn("the header of frame 1 has more than 163840 bytes", text)

    def test_unknown_fields_for_server_info_are_not_parsed(self):
        info = self.channel.unary_unary("/segserve.v1.SegmentationService/GetServerInfo")
        for call in [info.future(b"\x7a\0" * (4 * MIB), timeout=60) for _ in range(8)]:
            self.assertIn(b"border", call.result())

    def test_an_upload_that_claims_much_and_sends_little_makes_way(self):
        claim = delimited(2, b"\x08\x01" + delimited(5, delimited(17, delimited(1, b"\x20" + varint(120 * MIB)))) +
                          b"\x30" + varint(120 * MIB))
        wants_much = delimited(1, delimited(6, b"\x10" + varint(512 * MIB)))
        more = threading.Event()

        def messages():
            yield from (wants_much, claim)
            while not more.wait(1):
                yield delimited(3, b"\x08\x01" + delimited(2, b"x"))

        stream = self.stream(messages())
        next(stream)
        self.segment(self.scene, "--timeout", "15")  # after some refusals
        more.set()
        stream.cancel()

    def test_a_frame_header_alone_holds_no_memory(self):
        header = delimited(2, b"\x08\x01" + delimited(5, b"") + b"\x30" + varint(30 * MIB))
        before = self.memory("VmRSS")
        calls = [self.stream(iter((OPEN, header)), timeout=60) for _ in range(20)]
        for call in calls:
            next(call)
        if BOUNDS_MEMORY:
            self.assertLess(self.memory("VmRSS"), before + 64 * MIB)
        for call in calls:
            call.cancel()


class MaximumTime(EndToEnd):
    server_flags = ("--max-frame-seconds", "0.2")

    def test_a_frame_that_takes_too_long_is_told_so(self):
        cloud = self.path("lone.pcd")
        lone_points(cloud, 60, 0.02)
        line = self.run_badly(1, "segment", cloud, "--server", self.server.address, "-o", self.path("out.pcd"),
                              "--voxel-resolution", "0.0075")
        self.assertIn("takes longer than max_frame_seconds = 0.2", line)


if __name__ == "__main__":
    unittest.main()
