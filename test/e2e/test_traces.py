# SPDX-License-Identifier: Apache-2.0
"""Every frame is a trace in OpenTelemetry's collector, and a bad collector costs no frame anything."""
import json
import pathlib
import re
import shutil
import socket
import tempfile
import time
import unittest

import grpc

from certificates import Authority
from collector import Collector, attributes, times
from harness import BAD_INPUT, SUCCESS, Server, segctl
from messages import file_request

UNARY = "/segserve.v1.SegmentationService/Segment"
TRACE_ID, SPAN_ID = "4bf92f3577b34da6a3ce929d0e0e4736", "00f067aa0ba902b7"
TRACEPARENT = f"00-{TRACE_ID}-{SPAN_ID}-01"
STAGES = ["voxels", "normals", "supervoxels", "graph", "merging", "labels"]
ROUNDING = 1e-6  # seconds


class Traces(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-traces-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.scene = cls.folder / "scene.pcd"
        done = segctl("synth", "-o", cls.scene, "--quiet", "--width", "160", "--height", "120")
        assert done.returncode == SUCCESS, done.stderr

    def start(self, *flags, endpoint=None, environment=None, **collector):
        if endpoint is None:
            self.collector = Collector(**collector)
            self.addCleanup(self.collector.close)
            endpoint = self.collector.endpoint
        self.log = self.folder / f"{self.id()}.log"
        self.server = Server(self.folder, "--otlp-endpoint", endpoint, "--log-level", "warn", "--log-format", "json", *flags,
                             log=self.log, environment=environment)
        self.addCleanup(self.server.close)

    def segment(self, *flags, scene=None):
        done = segctl("segment", scene or self.scene, "--server", self.server.address, "--quiet", *flags)
        self.assertEqual(done.returncode, SUCCESS, done.stderr)
        return done

    def lines(self):
        return [json.loads(line) for line in self.log.read_text().splitlines()]

    def stop(self):
        """Stops the server, which sends all traces before. Returns how long that took, seconds."""
        begin = time.monotonic()
        self.assertEqual(self.server.terminate(), 0)
        return time.monotonic() - begin

    def check_nesting(self, root, steps):
        """The children of the root are these steps, one after the other within its time."""
        begin, end = times(root)
        children = self.collector.children(root)
        self.assertEqual([child["name"] for child in children], steps)
        last = begin
        for child in children:
            child_begin, child_end = times(child)
            self.assertGreaterEqual(child_begin, last - ROUNDING, child)
            self.assertLessEqual(child_begin, child_end)
            last = child_end
        self.assertLessEqual(last, end + ROUNDING)
        segment, = [child for child in children if child["name"] == "segment"]
        stages = self.collector.children(segment)
        self.assertEqual([stage["name"] for stage in stages], STAGES)
        sum_of_stages = sum(times(stage)[1] - times(stage)[0] for stage in stages)
        self.assertLessEqual(sum_of_stages, times(segment)[1] - times(segment)[0] + ROUNDING)
        self.assertGreater(sum_of_stages, 0)

    def test_a_unary_call_is_a_trace(self):
        self.start(environment={"OTEL_SERVICE_NAME": "vision", "OTEL_EXPORTER_OTLP_HEADERS": "authorization=Bearer%20secret"})
        begin = time.time()
        self.segment("--request-id", "scan 7", "--traceparent", TRACEPARENT)
        end = time.time()
        self.stop()
        root, = self.collector.roots()
        self.assertEqual((root["traceId"], root["parentSpanId"], root["kind"]), (TRACE_ID, SPAN_ID, 2))
        self.assertTrue(all(span["traceId"] == TRACE_ID for span in self.collector.spans))
        self.check_nesting(root, ["queue", "decode", "segment", "encode"])
        self.assertGreater(times(root)[0], begin - 0.1)
        self.assertLess(times(root)[1], end + 0.1)
        told = attributes(root)
        self.assertEqual((told["rpc.system"], told["rpc.service"], told["rpc.method"], told["rpc.grpc.status_code"]),
                         ("grpc", "segserve.v1.SegmentationService", "Segment", 0))
        self.assertEqual((told["segserve.outcome"], told["segserve.request_id"]), ("RESULT", "scan 7"))
        self.assertEqual((told["segserve.points"], told["network.peer.address"]), (160 * 120, "127.0.0.1"))
        resource = self.collector.resources[0]
        self.assertEqual((resource["service.name"], resource["telemetry.sdk.language"]), ("vision", "cpp"))
        _, path, headers, _ = self.collector.requests[0]
        self.assertEqual((path, headers["Content-Type"], headers["authorization"]),
                         ("/v1/traces", "application/json", "Bearer secret"))
        self.assertEqual(self.lines(), [])

    def test_every_frame_of_a_stream_is_a_span_of_the_clients_trace(self):
        scenes = self.folder / "scenes"
        scenes.mkdir()
        for i in range(5):
            shutil.copy(self.scene, scenes / f"{i}.pcd")
        self.start()
        told = self.segment("--out-dir", self.folder / "out", "--traceparent", "new", scene=scenes)
        self.stop()
        trace_id, span_id = re.search(r"traceparent 00-(\w{32})-(\w{16})-01", told.stderr.decode()).groups()
        roots = self.collector.roots()
        self.assertEqual(sorted(attributes(root)["segserve.sequence"] for root in roots), [1, 2, 3, 4, 5])
        self.assertEqual(len({root["spanId"] for root in roots}), 5)
        for root in roots:
            self.assertEqual((root["traceId"], root["parentSpanId"]), (trace_id, span_id))
            self.assertEqual(attributes(root)["rpc.method"], "SegmentStream")
            self.check_nesting(root, ["upload", "queue", "decode", "segment", "encode", "deliver"])

    def test_a_frame_that_fails_says_why(self):
        self.start()
        with grpc.insecure_channel(self.server.address) as channel:
            with self.assertRaises(grpc.RpcError):
                channel.unary_unary(UNARY)(file_request(b"no cloud"))
        self.stop()
        root, = self.collector.roots()
        told = attributes(root)
        self.assertEqual((told["error.type"], told["rpc.grpc.status_code"], told["segserve.outcome"]),
                         ("MALFORMED_PAYLOAD", grpc.StatusCode.INVALID_ARGUMENT.value[0], "FAILED"))
        self.assertNotIn("status", root, "the fault is the client's")

    def test_the_client_decides_what_is_recorded_and_the_server_for_others(self):
        self.start("--otlp-sample-ratio", "0")
        self.segment()
        self.segment("--traceparent", TRACEPARENT[:-1] + "0")
        self.segment("--traceparent", TRACEPARENT)
        self.stop()
        self.assertEqual([root["traceId"] for root in self.collector.roots()], [TRACE_ID])
        self.start()
        self.segment()
        self.segment("--traceparent", TRACEPARENT[:-1] + "0")
        self.stop()
        root, = self.collector.roots()
        self.assertNotIn("parentSpanId", root)

    def test_a_busy_collector_is_asked_again(self):
        self.start(answers=[503, (429, {"Retry-After": "1"}, b"")])
        self.segment()
        deadline = time.monotonic() + 30
        while not self.collector.roots():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.05)
        self.stop()
        self.assertEqual(len(self.collector.roots()), 1)
        moments = [moment for moment, *_ in self.collector.requests]
        self.assertEqual([status for *_, status in self.collector.requests], [503, 429, 200])
        self.assertGreaterEqual(moments[1] - moments[0], 0.45)
        self.assertGreaterEqual(moments[2] - moments[1], 0.95)
        self.assertEqual([line["error"] for line in self.lines()], ["the collector answers with HTTP 503"])

    def test_a_collector_that_refuses_is_not_asked_again(self):
        self.start(answers=[400, (200, {}, b'{"partialSuccess":{"rejectedSpans":"3","errorMessage":"too old"}}')])
        self.segment()
        deadline = time.monotonic() + 30
        while not self.collector.requests:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.05)
        self.stop()
        self.assertEqual([status for *_, status in self.collector.requests], [400])
        self.assertEqual([line["message"] for line in self.lines()],
                         ["the collector of traces does not take them all", "traces of frames were lost"])
        self.assertEqual(self.lines()[1]["frames"], 1)

    def test_nothing_is_lost_at_the_end(self):
        self.start()
        request = file_request(self.scene.read_bytes())
        with grpc.insecure_channel(self.server.address) as channel:
            for future in [channel.unary_unary(UNARY).future(request) for _ in range(40)]:
                future.result()
        self.stop()
        self.assertEqual(len(self.collector.roots()), 40)

    def test_a_collector_by_tls_must_have_a_certificate_that_is_trusted(self):
        certificate, key = Authority(self.folder, "authority").sign("collector")
        other = Authority(self.folder, "other").certificate
        for trusted, frames in ((self.folder / "authority.crt", 1), (other, 0)):
            with self.subTest(trusted):
                self.start(environment={"OTEL_EXPORTER_OTLP_CERTIFICATE": str(trusted)}, certificate=certificate, key=key)
                self.segment()
                self.stop()
                self.assertEqual(len(self.collector.roots()), frames)
                errors = [line["error"] for line in self.lines() if "error" in line]
                self.assertEqual(["certificate" in error for error in errors], [] if frames else [True])

    def frame_seconds(self):
        """How long the fastest of some calls takes."""
        request = file_request(self.scene.read_bytes())
        best = float("inf")
        with grpc.insecure_channel(self.server.address) as channel:
            for _ in range(10):
                begin = time.monotonic()
                channel.unary_unary(UNARY)(request)
                best = min(best, time.monotonic() - begin)
        return best

    def test_a_collector_that_is_down_or_silent_costs_frames_nothing(self):
        with socket.create_server(("127.0.0.1", 0)) as deaf:  # takes connections, and never says anything
            silent = f"http://127.0.0.1:{deaf.getsockname()[1]}"
            for endpoint in ("http://127.0.0.1:1", silent):
                with self.subTest(endpoint):
                    self.start(endpoint=endpoint)
                    self.assertLess(self.frame_seconds(), 1)  # the collector's timeouts are longer
                    self.assertLess(self.stop(), 8)
                    messages = [line["message"] for line in self.lines()]
                    self.assertIn("traces of frames were lost", messages)
                    self.assertEqual(sum(line.get("frames", 0) for line in self.lines()), 10)

    def test_wrong_settings_are_refused(self):
        for flags, environment in ((["--otlp-endpoint", "127.0.0.1:4318"], {}),
                                   (["--otlp-endpoint", "http://a", "--otlp-sample-ratio", "1.5"], {}),
                                   (["--otlp-endpoint", "http://a"], {"OTEL_EXPORTER_OTLP_HEADERS": "hunter2"})):
            with self.assertRaises(RuntimeError) as failure:
                Server(self.folder, *flags, environment=environment, log=self.folder / "log")
            self.assertIn(f"exit code {BAD_INPUT}", str(failure.exception))
            self.assertNotIn("hunter2", (self.folder / "log").read_text())


if __name__ == "__main__":
    unittest.main()
