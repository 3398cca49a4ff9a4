# SPDX-License-Identifier: Apache-2.0
"""The server's log tells an operator what the server is and why clients are refused, and hurts nobody."""
import collections
import json
import os
import pathlib
import shutil
import signal
import tempfile
import time
import unittest

import grpc

from harness import SUCCESS, Server, segctl
from messages import OPEN, delimited, file_request, varint

UNARY = "/segserve.v1.SegmentationService/Segment"
STREAM = "/segserve.v1.SegmentationService/SegmentStream"
TRACE_ID, SPAN_ID = "4bf92f3577b34da6a3ce929d0e0e4736", "00f067aa0ba902b7"
TRACEPARENT = f"00-{TRACE_ID}-{SPAN_ID}-01"


class Logs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-logs-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.scene = cls.folder / "scene.pcd"
        done = segctl("synth", "-o", cls.scene, "--quiet", "--width", "160", "--height", "120")
        assert done.returncode == SUCCESS, done.stderr

    def start(self, *flags):
        self.log = self.folder / f"{self.id()}.log"
        self.server = Server(self.folder, *flags, log=self.log)
        self.addCleanup(self.server.close)

    def segment(self, *flags):
        done = segctl("segment", self.scene, "--server", self.server.address, "--quiet", *flags)
        self.assertEqual(done.returncode, SUCCESS, done.stderr)

    def lines(self, message=None):
        """The objects of a log in JSON, or those with this message."""
        found = [json.loads(line) for line in self.log.read_bytes().decode().splitlines()]
        return [line for line in found if message is None or line["message"] == message]

    def wait_for(self, message, count=1):
        deadline = time.monotonic() + 20
        while len(self.lines(message)) < count:
            self.assertLess(time.monotonic(), deadline, f"{message} x {count}: {self.log.read_text()}")
            time.sleep(0.02)
        return self.lines(message)

    def test_tells_what_the_server_is_and_when_it_stops(self):
        self.start("--log-format", "json", "--log-level", "info", "--workers", "2", "--queue", "5", "--memory", "512MiB")
        self.segment()
        self.assertEqual(self.server.terminate(), 0)
        serves, = self.lines("segserve serves")
        self.assertEqual(serves["address"], self.server.address)
        self.assertRegex(serves["time"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d$")
        self.assertRegex(serves["version"], r"^\d+\.\d+\.\d+$")
        limits, = self.lines("limits")
        self.assertEqual((limits["workers"], limits["queue"], limits["memory_bytes"]), (2, 5, 512 << 20))
        stopping, = self.lines("stopping")
        self.assertEqual((stopping["signal"], stopping["calls"]), ("TERM", 0))
        self.assertEqual(self.lines()[-1]["message"], "stopped")
        self.assertFalse([line for line in self.lines() if line["level"] not in ("info",)])

    def test_writes_a_line_for_each_frame_at_debug(self):
        self.start("--log-format", "json", "--log-level", "debug")
        self.segment("--request-id", "call", "--traceparent", TRACEPARENT)
        self.segment("--out-dir", self.folder / "out", "--traceparent", TRACEPARENT)
        self.assertEqual(self.server.terminate(), 0)
        unary, streamed = self.lines("frame")
        self.assertEqual(unary["call"], "Segment")
        self.assertEqual(unary["request_id"], "call")
        self.assertEqual(streamed["call"], "SegmentStream")
        self.assertEqual(streamed["client"], "segctl segment")
        self.assertEqual(streamed["sequence"], 1)
        for line in (unary, streamed):
            self.assertEqual((line["level"], line["outcome"]), ("debug", "RESULT"))
            self.assertEqual((line["trace_id"], line["span_id"]), (TRACE_ID, SPAN_ID))
            self.assertEqual(line["points"], 160 * 120)
            self.assertGreater(line["received_bytes"], 0)
            parts = sum(line[part] for part in ("queue_ms", "decode_ms", "segment_ms", "encode_ms"))
            self.assertGreater(line["segment_ms"], 0)
            self.assertLessEqual(parts, line["total_ms"] + 0.01)
        self.assertEqual(self.lines("stream")[0]["frames"], 1)

    def test_ignores_a_traceparent_that_is_not_valid(self):
        self.start("--log-format", "json", "--log-level", "debug")
        with grpc.insecure_channel(self.server.address) as channel:
            for bad in ("", "00", TRACEPARENT.upper(), TRACEPARENT + "-1", "x" * 10_000):
                with self.assertRaises(grpc.RpcError) as failure:
                    channel.unary_unary(UNARY)(b"", metadata=(("traceparent", bad),))
                self.assertEqual(failure.exception.code(), grpc.StatusCode.INVALID_ARGUMENT)
        self.assertEqual(self.server.terminate(), 0)
        self.assertEqual(len([line for line in self.lines() if line.get("call") == "Segment"]), 5)
        self.assertFalse([line for line in self.lines() if "trace_id" in line])

    def test_each_frame_of_a_stream_has_a_trace_of_its_own(self):
        self.start("--log-format", "json", "--log-level", "debug")
        other = TRACEPARENT.replace(TRACE_ID, TRACE_ID[::-1])

        def header(sequence, traceparent):
            return delimited(2, b"\x08" + varint(sequence) + delimited(15, traceparent.encode()))

        messages = (OPEN, header(1, other), header(2, ""), header(3, "no traceparent"), header(4, "0" * 60_000))
        with grpc.insecure_channel(self.server.address) as channel:
            list(channel.stream_stream(STREAM)(iter(messages), metadata=(("traceparent", TRACEPARENT),), timeout=60))
        self.assertEqual(self.server.terminate(), 0)
        told = {line["sequence"]: line.get("trace_id") for line in self.lines("frame failed")}
        self.assertEqual(told, {1: TRACE_ID[::-1], 2: TRACE_ID, 3: None, 4: None})

    def test_hostile_names_stay_in_their_place(self):
        hostile = 'x"\n{"level":"error","message":"forged"}\n\x1b[31m subject=admin \\'
        for log_format in ("json", "text"):
            with self.subTest(log_format):
                self.start("--log-format", log_format, "--log-level", "debug")
                self.segment("--request-id", hostile)
                self.assertEqual(self.server.terminate(), 0)
                text = self.log.read_bytes()
                self.assertNotIn(b"\x1b", text)
                if log_format == "json":
                    frame, = self.lines("frame")
                    self.assertEqual(frame["request_id"], hostile)
                    self.assertFalse(self.lines("forged"))
                else:
                    self.assertFalse([line for line in text.splitlines() if line.startswith(b"{")])
                    self.assertIn(rb'request_id="x\"\x0a{\"level\"', text)

    def test_the_level_changes_at_run_time(self):
        self.start("--log-format", "json", "--log-level", "warn")
        self.segment()
        for level in ("info", "debug"):
            self.server.process.send_signal(signal.SIGUSR1)
            self.wait_for(f"the level of this log is now {level}")
        self.segment()
        self.wait_for("frame")
        self.server.process.send_signal(signal.SIGUSR2)
        self.wait_for("the level of this log is now info", 2)
        self.segment()
        self.assertEqual(self.server.terminate(), 0)
        self.assertEqual(len(self.lines("frame")), 1)

    def test_a_flood_of_bad_frames_leaves_a_small_log(self):
        self.start("--log-format", "json", "--log-level", "info")
        with grpc.insecure_channel(self.server.address) as channel:
            for _ in range(500):
                with self.assertRaises(grpc.RpcError):
                    channel.unary_unary(UNARY)(file_request(b"no cloud"))
        self.assertEqual(self.server.terminate(), 0)
        first, = self.lines("frame failed")
        self.assertEqual((first["level"], first["code"], first["reason"]), ("info", "INVALID_ARGUMENT", "MALFORMED_PAYLOAD"))
        self.assertTrue(first["error"])
        self.assertTrue(first["peer"])
        summaries = [line for line in self.lines() if line["message"].startswith("frame failed: ")]
        self.assertEqual(sum(line["count"] for line in summaries), 499)
        self.assertTrue(all(line["reason"] == "MALFORMED_PAYLOAD" for line in summaries))
        self.assertLess(self.log.stat().st_size, 10_000)

    def test_every_refusal_is_counted(self):
        self.start("--log-format", "json", "--log-level", "info", "--workers", "1", "--queue", "1")
        request = file_request(self.scene.read_bytes())
        reasons = collections.Counter()
        with grpc.insecure_channel(self.server.address) as channel:
            call = channel.unary_unary(UNARY)
            for future in [call.future(request) for _ in range(40)]:
                reasons[future.code()] += 1
        refused = reasons[grpc.StatusCode.RESOURCE_EXHAUSTED]
        self.assertGreater(refused, 1, reasons)
        self.assertEqual(self.server.terminate(), 0)
        told = [line for line in self.lines() if line.get("reason") == "QUEUE_FULL"]
        self.assertEqual(sum(line.get("count", 1) for line in told), refused)
        self.assertEqual((told[0]["message"], told[0]["limit"]), ("frame refused", "max_queue"))

    def test_a_log_that_nobody_reads_stops_nobody(self):
        reader, writer = os.pipe()
        self.addCleanup(os.close, reader)
        self.server = Server(self.folder, log=writer)
        self.addCleanup(self.server.close)
        with grpc.insecure_channel(self.server.address) as channel:
            for _ in range(600):  # some 200 KB, and the pipe holds 64
                with self.assertRaises(grpc.RpcError):
                    channel.unary_unary(UNARY)(file_request(b"no cloud"), timeout=20)
        begin = time.monotonic()
        self.assertEqual(self.server.terminate(), 0)
        self.assertLess(time.monotonic() - begin, 10)

    def test_the_server_outlives_the_reader_of_its_log(self):
        reader, writer = os.pipe()
        self.server = Server(self.folder, log=writer)
        self.addCleanup(self.server.close)
        os.close(reader)
        for _ in range(3):
            self.segment()
        self.assertEqual(self.server.terminate(), 0)


if __name__ == "__main__":
    unittest.main()
