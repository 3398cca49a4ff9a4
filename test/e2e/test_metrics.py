# SPDX-License-Identifier: Apache-2.0
"""The metrics of a server add up with what its clients saw, frame by frame, and nobody who reads them harms a frame."""
import json
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import threading
import time
import unittest

import grpc

from certificates import Authority
from harness import BAD_INPUT, FAILED, SEGSERVE, EndToEnd, Server
from messages import MIB, OPEN, delimited, file_request, varint
from scrape import Prometheus, Scrape, get
from test_attacks import lone_points

ROOT = pathlib.Path(__file__).parents[2]
OPERATIONS = ROOT / "docs" / "operations.md"
ALERTS = ROOT / "deploy" / "prometheus"
CODECS = {"planar": "planar", "planar-zstd": "planar", "strided": "strided", "quantised": "quantised", "pcd": "pcd_file",
          "rgbd": "rgbd"}
SMALL = ("--size", "160x120", "--scenes", "2")
STAGES = ("decode", "voxels", "normals", "supervoxels", "graph", "merging", "labels", "segments", "encode")
UNARY = "/segserve.v1.SegmentationService/Segment"
STREAM = "/segserve.v1.SegmentationService/SegmentStream"


def claim(size):
    """The header of a frame whose payload, a PCD file of so many bytes, is still to come."""
    return delimited(2, b"\x08\x01" + delimited(5, delimited(17, delimited(1, b"\x20" + varint(size)))) +
                     b"\x30" + varint(size))


class MeasuredServer(Server):
    """A server with metrics."""

    def __init__(self, folder, *flags):
        port_file = pathlib.Path(folder) / f"metrics-port-{time.monotonic_ns()}"
        super().__init__(folder, "--metrics-listen", "127.0.0.1:0", "--metrics-port-file", str(port_file), *flags)
        self.metrics_port = int(port_file.read_text())

    def scrape(self):
        return Scrape(self.metrics_port)


class MetricsCase(EndToEnd):
    """Tests that start a server each."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server.close()
        cls.scene = cls.folder / "scene.pcd"
        cls().run_well("synth", "-o", cls.scene, "--quiet", "--width", "320", "--height", "240")

    def start(self, *flags):
        self.server = MeasuredServer(self.folder, *flags)
        self.addCleanup(self.server.close)
        self.channel = grpc.insecure_channel(self.server.address)
        self.addCleanup(self.channel.close)
        self.unary = self.channel.unary_unary(UNARY)
        return self.server

    def bench(self, *flags):
        done = self.run_well("bench", "--server", self.server.address, "--warm-up", "0", "--json", "-", *flags)
        return json.loads(done.stdout)

    def reasons(self, *calls):
        """How the calls ended: OK, or the reason of the error."""
        ends = []
        for call in calls:
            error = call.exception()
            details = b"" if error is None else dict(error.trailing_metadata()).get("grpc-status-details-bin", b"")
            reason = re.search(rb"([A-Z_]+)\x12\x08segserve", details)  # the first two fields of ErrorInfo
            ends.append("OK" if error is None else reason[1].decode() if reason else error.details())
        return ends

    def open_stream(self, *messages):
        """A stream with these messages after the first, that stays open until the event is set, and the event."""
        more = threading.Event()
        self.addCleanup(more.set)

        def sent():
            yield OPEN
            yield from messages
            more.wait()

        stream = self.channel.stream_stream(STREAM)(sent())
        next(stream)
        return stream, more

    def wait_for(self, condition):
        deadline = time.monotonic() + 30
        while not condition():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.02)


class Metrics(MetricsCase):
    @unittest.skipUnless(Prometheus.installed, "there is no Prometheus")
    def test_a_real_prometheus_sees_what_the_clients_saw(self):
        server = self.start("--max-voxels", "80000")
        large = self.synth("--width", "640", "--height", "480", name="large.pcd")
        prometheus = Prometheus(self.folder, server.metrics_port)
        self.addCleanup(prometheus.close)
        results, bytes_up, bytes_down, points = {}, {}, {}, 0
        for codec, kind in CODECS.items():
            told = self.bench(*SMALL, "--codec", codec, "--clients", "2", "--duration", "0.7")
            self.assertEqual(told["errors"], {})
            results[kind] = results.get(kind, 0) + told["frames"]["results"]
            bytes_up[kind] = bytes_up.get(kind, 0) + told["bytes_up"]
            bytes_down[kind] = bytes_down.get(kind, 0) + told["bytes_down"]
            points += told["frames"]["results"] * 160 * 120
        seconds = os.environ.get("FLEET_SLACK", "1")  # a sanitizer makes frames of both clouds take their time
        mixed = self.bench("--input", self.scene, large, "--voxel-resolution", "0.001", "--duration", seconds,
                           "--objective", "errors<=100%")
        failed = mixed["errors"].pop("FAILED RESOURCE_EXHAUSTED LIMIT_EXCEEDED")
        self.assertEqual(mixed["errors"], {})
        results["planar"] += mixed["frames"]["results"]
        bytes_up["planar"] += mixed["bytes_up"]
        points += mixed["frames"]["results"] * 320 * 240
        unary = self.unary(file_request(self.scene.read_bytes()), timeout=60)
        self.assertGreater(len(unary), 320 * 240)
        points += 320 * 240

        streamed = sum(results.values())
        expected = {
            'segserve_frames_total{call="stream",outcome="result"}': streamed,
            'segserve_frames_total{call="stream",outcome="failed"}': failed,
            'segserve_frames_total{call="unary",outcome="result"}': 1,
            'sum(segserve_frames_total)': streamed + failed + 1,
            'segserve_frame_failures_total{code="RESOURCE_EXHAUSTED",reason="LIMIT_EXCEEDED"}': failed,
            'sum(segserve_frame_failures_total)': failed,
            'sum(segserve_refusals_total)': 0,
            'sum(segserve_frame_duration_seconds_count)': streamed + 1,
            'segserve_frame_duration_seconds_bucket{call="stream",le="+Inf"}': streamed,
            'segserve_frame_upload_seconds_count': streamed + failed,
            'segserve_frame_queue_wait_seconds_count': streamed + failed + 1,
            'segserve_frame_delivery_seconds_count': streamed + failed + 1,
            'segserve_frame_points_sum': points + failed * 640 * 480,
            'segserve_stream_ends_total{code="OK",reason="UNSPECIFIED"}': 2 * len(CODECS) + 1,
            'segserve_streams': 0, 'segserve_unary_calls': 0, 'segserve_queue_frames': 0, 'segserve_workers_busy': 0,
            'sum(segserve_memory_leased_bytes)': 0,
        }
        for stage in STAGES:
            decoded_only = stage == "decode"
            expected[f'segserve_frame_stage_seconds_count{{stage="{stage}"}}'] = streamed + 1 + failed * decoded_only
        for kind in set(results) - {"planar", "pcd_file"}:  # the frames that failed, and the unary call, are of these
            expected[f'segserve_received_bytes_total{{codec="{kind}"}}'] = bytes_up[kind]
            expected[f'segserve_sent_bytes_total{{codec="{kind}"}}'] = bytes_down[kind]
        for query, value in expected.items():
            self.assertEqual(prometheus.wait_for(query, value), value, query)
        self.assertEqual(prometheus.value('up{job="segserve"}'), 1)
        received = server.scrape().sum("segserve_received_bytes_total", codec="planar")
        self.assertGreater(received, bytes_up["planar"] + failed * 640 * 480 * 15)
        self.assertGreater(server.scrape().sum("segserve_sent_bytes_total", codec="pcd_file"), len(unary))
        self.assertGreater(prometheus.value('histogram_quantile(0.5, sum by (le) '
                                            '(segserve_frame_duration_seconds_bucket))'), 0)

    def start_with_all_metrics(self):
        authority = Authority(self.folder, "authority")
        certificate, key = authority.sign("server")
        return self.start("--tls-cert", str(certificate), "--tls-key", str(key), "--tls-client-ca",
                          str(authority.certificate))

    def test_the_ends_of_certificates_are_told(self):
        scraped = self.start_with_all_metrics().scrape()
        for which, days in (("server", 10), ("client_ca", 30)):
            end = scraped.sum("segserve_tls_certificate_end_timestamp_seconds", certificate=which)
            self.assertAlmostEqual(end, time.time() + days * 86400, delta=3600)

    @unittest.skipUnless(Prometheus.installed, "there is no promtool")
    def test_promtool_finds_nothing_to_say(self):
        scraped = self.start_with_all_metrics().scrape()
        done = subprocess.run(["promtool", "check", "metrics"], input=scraped.text, capture_output=True, text=True,
                              timeout=60)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    @unittest.skipUnless(Prometheus.installed, "there is no promtool")
    def test_the_alerts_work_and_are_about_metrics_that_exist(self):
        done = subprocess.run(["promtool", "test", "rules", ALERTS / "alerts_test.yml"], capture_output=True, text=True,
                              timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        types = self.start_with_all_metrics().scrape().types
        used = set(re.findall(r"\b(?:segserve|process)_\w+", (ALERTS / "alerts.yml").read_text()))
        self.assertGreater(len(used), 5)
        self.assertEqual({name for name in used if re.sub("_bucket$", "", name) not in types}, set())

    def test_the_documents_list_every_metric_and_no_other(self):
        scraped = self.start_with_all_metrics().scrape()
        section = OPERATIONS.read_text().split("\n## Metrics\n")[1].split("\n## ")[0]
        listed = {name: (kind, set(re.findall(r"`(\w+)`", labels)))
                  for name, kind, labels in re.findall(r"^\| `(\w+)` \| (\w+) \| (.*?) \|", section, re.M)}
        shown = {name: (kind, scraped.labels[name]) for name, kind in scraped.types.items()}
        self.assertEqual(listed, shown)

    def test_it_serves_metrics_and_nothing_else(self):
        port = self.start().metrics_port
        for path in ("/", "/etc/passwd", "/metrics/..", "/../etc/passwd", "/favicon.ico"):
            with self.assertRaises(OSError) as caught:
                get(f"http://127.0.0.1:{port}{path}")
            self.assertEqual(caught.exception.code, 404, path)
            caught.exception.close()

    def test_wrong_addresses_are_refused_with_a_reason(self):
        taken = self.start().metrics_port
        for address, code, text in (("nowhere", BAD_INPUT, "'nowhere' is no address to listen on"),
                                    ("unix:/tmp/m", BAD_INPUT, "metrics are not served on a unix socket"),
                                    (f"127.0.0.1:{taken}", FAILED, "Address already in use")):
            done = subprocess.run([SEGSERVE, "--listen", "127.0.0.1:0", "--metrics-listen", address, "--log-level", "off"],
                                  capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(text, done.stderr)


class Refusals(MetricsCase):
    """Every refusal is counted by its cause."""

    def test_a_full_queue_and_malformed_payloads(self):
        server = self.start("--workers", "1", "--queue", "1")
        request = file_request(self.scene.read_bytes())
        ends = self.reasons(*(self.unary.future(request, timeout=60) for _ in range(16)))
        self.assertEqual(set(ends), {"OK", "QUEUE_FULL"})
        self.assertEqual(self.reasons(self.unary.future(file_request(b"garbage"), timeout=60)), ["MALFORMED_PAYLOAD"])
        scraped = server.scrape()
        self.assertEqual(scraped.sum("segserve_frames_total", call="unary", outcome="result"), ends.count("OK"))
        self.assertEqual(scraped.sum("segserve_refusals_total", cause="queue_frames"), ends.count("QUEUE_FULL"))
        self.assertEqual(scraped.sum("segserve_refusals_total"), ends.count("QUEUE_FULL"))
        self.assertEqual(scraped.sum("segserve_frame_failures_total", reason="QUEUE_FULL"), ends.count("QUEUE_FULL"))
        self.assertEqual(scraped.sum("segserve_frame_failures_total", reason="MALFORMED_PAYLOAD"), 1)
        self.assertEqual(scraped.sum("segserve_frames_total"), 17)

    def test_a_call_that_makes_way_for_another_client(self):
        server = self.start("--workers", "1", "--queue", "2")
        cloud = self.path("lone.pcd")
        lone_points(cloud, 60, 0.02)  # takes a while
        request = file_request(cloud.read_bytes())
        with grpc.insecure_channel(server.address, options=[("grpc.use_local_subchannel_pool", 1)]) as other:
            grpc.channel_ready_future(other).result(timeout=60)
            mine = [self.unary.future(request, timeout=60) for _ in range(3)]
            self.wait_for(lambda: server.scrape().sum("segserve_queue_frames") == 2)
            ends = self.reasons(other.unary_unary(UNARY).future(request, timeout=60), *mine)
        scraped = server.scrape()
        self.assertEqual(ends[0], "OK")
        self.assertEqual(scraped.sum("segserve_refusals_total", cause="eviction"), ends.count("QUEUE_FULL"))
        self.assertEqual(scraped.sum("segserve_refusals_total"), ends.count("QUEUE_FULL"))

    def test_short_memory(self):
        server = self.start("--memory", "64MiB")
        stream, more = self.open_stream(claim(30 * MIB))
        self.wait_for(lambda: server.scrape().sum("segserve_memory_leased_bytes", kind="waiting") == 30 * MIB)
        call = self.unary.future(file_request(bytes(5 * MIB)), timeout=60)
        self.assertEqual(self.reasons(call), ["QUEUE_FULL"])
        scraped = server.scrape()
        self.assertEqual(scraped.sum("segserve_refusals_total", cause="memory"), 1)
        self.assertEqual(scraped.sum("segserve_refusals_total"), 1)
        self.assertEqual(scraped.sum("segserve_memory_refusals_total"), 1)
        self.assertEqual(scraped.sum("segserve_memory_short"), 1)
        more.set()
        stream.cancel()

    def test_draining(self):
        server = self.start()
        stream, more = self.open_stream(claim(MIB))
        self.wait_for(lambda: server.scrape().sum("segserve_streams") == 1)
        server.process.send_signal(signal.SIGTERM)
        self.wait_for(lambda: server.scrape().sum("segserve_draining") == 1)
        late = self.unary.future(file_request(b"late"), timeout=60)
        self.assertEqual(self.reasons(late, self.channel.stream_stream(STREAM)(iter((OPEN,)), timeout=60)),
                         ["DRAINING", "DRAINING"])
        scraped = server.scrape()
        self.assertEqual(scraped.sum("segserve_refusals_total", cause="draining"), 2)
        self.assertEqual(scraped.sum("segserve_stream_ends_total", reason="DRAINING"), 1)
        self.assertEqual(scraped.sum("segserve_frame_failures_total", reason="DRAINING"), 1)
        more.set()  # the payload never comes complete
        self.assertEqual(server.process.wait(timeout=60), 0)

    def test_tokens_and_quotas(self):
        tokens, token = self.path("tokens.toml"), self.path("robot.token")
        self.run_well("token", "robot", "--output", token, "--tokens", tokens, "--frames-per-second", "0.01")
        server = self.start("--tokens", str(tokens))
        request = file_request(self.scene.read_bytes())
        mine = [("authorization", f"Bearer {token.read_text().strip()}")]
        ends = self.reasons(*(self.unary.future(request, timeout=60, metadata=metadata)
                              for metadata in (None, [("authorization", "Bearer wrong")], mine)))
        self.assertEqual(ends, ["TOKEN_MISSING", "TOKEN_INVALID", "OK"])
        self.assertEqual(self.reasons(self.unary.future(request, timeout=60, metadata=mine)), ["QUOTA_EXCEEDED"])
        self.assertEqual(self.reasons(self.channel.stream_stream(STREAM)(iter((OPEN,)), timeout=60)), ["TOKEN_MISSING"])
        scraped = server.scrape()
        self.assertEqual(scraped.sum("segserve_refusals_total", cause="token"), 3)
        self.assertEqual(scraped.sum("segserve_refusals_total", cause="quota"), 1)
        self.assertEqual(scraped.sum("segserve_refusals_total"), 4)
        self.assertEqual(scraped.sum("segserve_frames_total", call="unary"), 4)
        self.assertEqual(scraped.sum("segserve_stream_ends_total", reason="TOKEN_MISSING"), 1)
        self.assertNotIn("robot", scraped.text)
        with tokens.open("a") as file:
            file.write("broken\n")
        self.wait_for(lambda: server.scrape().sum("segserve_access_reloads_total", outcome="refused") == 1)

    def test_streams_that_break(self):
        server = self.start()
        vanished, _ = self.open_stream(claim(MIB))
        self.wait_for(lambda: server.scrape().sum("segserve_memory_leased_bytes") == MIB)
        vanished.cancel()
        unruly = self.channel.stream_stream(STREAM)(iter((OPEN, OPEN)), timeout=60)
        self.assertEqual(self.reasons(unruly), ["PROTOCOL_VIOLATION"])
        self.wait_for(lambda: server.scrape().sum("segserve_streams") == 0)
        scraped = server.scrape()
        self.assertEqual(scraped.sum("segserve_frames_total", call="stream", outcome="cancelled"), 1)
        self.assertEqual(scraped.sum("segserve_frames_total"), 1)
        self.assertEqual(scraped.sum("segserve_stream_ends_total", code="CANCELLED"), 1)
        self.assertEqual(scraped.sum("segserve_stream_ends_total", reason="PROTOCOL_VIOLATION"), 1)


class HostileScrapers(MetricsCase):
    def test_they_harm_no_frame_and_no_stop(self):
        server = self.start()
        slow = [socket.create_connection(("127.0.0.1", server.metrics_port)) for _ in range(60)]
        for number, connection in enumerate(slow):
            self.addCleanup(connection.close)
            if number % 3 == 1:
                connection.sendall(b"GET /met")
            if number % 3 == 2:
                connection.sendall(b"GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n")  # and it never reads the answer
        told = self.bench(*SMALL, "--clients", "2", "--duration", "1")
        self.assertEqual(told["errors"], {})
        self.assertGreater(told["frames"]["results"], 0)
        began = time.monotonic()
        self.assertEqual(server.terminate(), 0)
        self.assertLess(time.monotonic() - began, 10)

    def test_they_are_cut_off_so_that_others_get_their_turn(self):
        server = self.start()
        slow = [socket.create_connection(("127.0.0.1", server.metrics_port)) for _ in range(6)]
        for connection in slow:
            self.addCleanup(connection.close)
            connection.sendall(b"GET /met")
        self.assertEqual(server.scrape().sum("segserve_frames_total"), 0)

    def test_garbage_and_early_ends_are_borne(self):
        server = self.start()
        for sent in (b"\0" * 100_000, b"POST /metrics HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n", b"GET " + b"/" * 70_000,
                     b"GET /metrics HTTP/1.0\r\n\r\n"):
            for _ in range(5):
                connection = socket.create_connection(("127.0.0.1", server.metrics_port))
                try:
                    connection.sendall(sent)
                    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # ends by reset
                except ConnectionError:
                    pass
                connection.close()
        self.assertEqual(server.scrape().sum("segserve_frames_total"), 0)
        self.assertEqual(server.terminate(), 0)


if __name__ == "__main__":
    unittest.main()
