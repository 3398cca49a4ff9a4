# SPDX-License-Identifier: Apache-2.0
"""The web entrance: plain HTTP, health, metrics and errors, as curl and Python use it."""
import gzip
import http.client
import json
import pathlib
import shutil
import signal
import socket
import ssl
import subprocess
import tempfile
import threading
import time
import unittest
import urllib.request

import numpy

from certificates import Authority
from harness import EndToEnd, SUCCESS, segctl
from http_client import WebServer
import pcd

WIDTH, HEIGHT = 160, 120
SECURITY = {"x-content-type-options": "nosniff", "x-frame-options": "DENY", "referrer-policy": "no-referrer",
            "cross-origin-opener-policy": "same-origin", "cross-origin-resource-policy": "same-origin",
            "cache-control": "no-store"}


class Http(EndToEnd):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-http-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.server = WebServer(cls.folder, "--metrics-listen", "127.0.0.1:0")
        cls.addClassCleanup(cls.server.close)
        cls.scene = cls.folder / "scene.pcd"
        assert segctl("synth", "-o", cls.scene, "-q", "--width", WIDTH, "--height", HEIGHT,
                      "--seed", 5).returncode == SUCCESS

    def error(self, status, *arguments, **options):
        """The error of an answer with this status."""
        got, headers, body = self.server.segment(*arguments, **options)
        self.assertEqual((got, headers["content-type"]), (status, "application/json"), body)
        return json.loads(body)["error"]

    def test_answers_what_segctl_writes(self):
        labels, summary = self.segment_locally(self.scene, "--segments", "--threshold", "0.4")
        told = self.server.segment_well(self.scene, "threshold=0.4&outputs=segments,labels")
        self.assertEqual(told.pop("labels"), list(labels))
        for name in ("timings_ms", "server"):
            told.pop(name), summary.pop(name)
        self.assertEqual(told, summary)

    def test_curl_gets_labels_as_bytes(self):
        labels, summary = self.segment_locally(self.scene)
        output = self.path("labels")
        done = subprocess.run(["curl", "-sS", "--fail", "-o", output, "-D", "-", "-H", "Accept: application/octet-stream",
                               "--data-binary", f"@{self.scene}", f"http://127.0.0.1:{self.server.http_port}/v1/segment"],
                              capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(numpy.fromfile(output, "<u4").tolist(), list(labels))
        headers = done.stdout.decode().lower()
        for line in ("content-type: application/octet-stream", "segserve-array: uint32, little-endian",
                     f"segserve-points: {len(labels)}", f"segserve-width: {WIDTH}", f"segserve-height: {HEIGHT}",
                     f"segserve-segments: {summary['segments']}"):
            self.assertIn(line, headers)

    def test_all_formats_give_the_labels_of_segctl(self):
        compressed = self.path("scene.pcd.gz")
        compressed.write_bytes(gzip.compress(self.scene.read_bytes()))
        paths = [compressed, *(self.path(f"scene.{end}") for end in ("ply", "las", "xyz", "npy"))]
        for path in paths[1:]:
            # Formats that cannot hold all that the file has warn of that.
            self.assertEqual(segctl("segment", self.scene, "--local", "-q", "-o", path).returncode, SUCCESS)
        for path in paths:
            with self.subTest(path.suffix):
                expected, _ = self.segment_locally(path, "--view", "camera")
                self.assertGreater(max(expected), 1)
                status, _, body = self.server.segment(path, "view=camera", accept="application/octet-stream")
                self.assertEqual(status, 200, body[:300])
                self.assertEqual(numpy.frombuffer(body, "<u4").tolist(), list(expected))

    def test_images_of_a_camera_come_as_a_form(self):
        depth, color = self.path("depth.png"), self.path("color.png")
        camera = f"{WIDTH},{WIDTH},{(WIDTH - 1) / 2},{(HEIGHT - 1) / 2}"
        rows = numpy.full((HEIGHT, WIDTH), 1200, numpy.uint16)
        rows[30:80, 40:100] = 900
        depth.write_bytes(f"P5\n{WIDTH} {HEIGHT}\n65535\n".encode() + rows.astype(">u2").tobytes())
        shades = numpy.full((HEIGHT, WIDTH, 3), 90, numpy.uint8)
        shades[30:80, 40:100] = (200, 30, 30)
        color.write_bytes(f"P6\n{WIDTH} {HEIGHT}\n255\n".encode() + shades.tobytes())
        output = self.path("labeled.pcd")
        self.run_well("segment", "--depth", depth, "--rgb", color, "--intrinsics", camera, "--local", "-q", "-o", output)
        labels = pcd.read_labels(output)
        address = f"http://127.0.0.1:{self.server.http_port}/v1/segment?outputs=labels&intrinsics={camera}"
        done = subprocess.run(["curl", "-sS", "--fail-with-body", "-F", f"depth=@{depth}", "-F", f"color=@{color}", address],
                              capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(json.loads(done.stdout)["labels"], list(labels))
        done = subprocess.run(["curl", "-sS", "-F", f"color=@{color}", "-F", "other=1", address.split("?")[0]],
                              capture_output=True, timeout=60)
        error = json.loads(done.stdout)["error"]
        self.assertEqual([field["field"] for field in error["fields"]], ["other", "depth", "intrinsics"])

    def test_who_uploads_images_is_told_of_parts_and_parameters(self):
        depth = self.path("depth.pgm")
        depth.write_bytes(f"P5\n{WIDTH} {HEIGHT}\n65535\n".encode() + bytes(2 * WIDTH * HEIGHT))
        address = f"http://127.0.0.1:{self.server.http_port}/v1/segment"
        for said, query, *parts in (("intrinsics is a parameter of the query, and no part of the form", "", "intrinsics=1,1,1,1"),
                                    ("rgb_intrinsics does not go without the part color", "?intrinsics=9,9,9,9&rgb_intrinsics=9,9,9,9")):
            forms = [word for part in (f"depth=@{depth}", *parts) for word in ("-F", part)]
            done = subprocess.run(["curl", "-sS", *forms, address + query], capture_output=True, timeout=60, check=True)
            self.assertIn(said, json.loads(done.stdout)["error"]["message"].replace(": ", " "))
        error = self.error(400, self.scene, "intrinsics=9,9,9,9&depth_scale=0.001")
        self.assertEqual({field["field"]: field["description"] for field in error["fields"]},
                         dict.fromkeys(["intrinsics", "depth_scale"], "is for images, which come in a form with the parts depth and color"))
        message = self.error(400, b"\x89PNG\r\n\x1a\n" + bytes(100))["message"]
        self.assertIn("HTTP a form with the parts depth and color, and the parameter intrinsics", message)
        dense = pcd.binary_file([(x / 1e6, y / 1e6, 1.0) for x in range(50) for y in range(40)])
        told = self.server.segment_well(dense, "view=world&voxel_resolution=0.01")
        self.assertIn("the unit of the coordinates (unit, or depth_scale of a depth image)", told["warnings"][0]["message"])
        self.assertNotIn("--", json.dumps(told["warnings"]))

    def test_prompts_select_as_segctl_does(self):
        labels, _ = self.segment_locally(self.scene)
        on, beside = ("{1},{0}".format(*divmod(list(labels).index(label), WIDTH)) for label in (2, 1))
        picked, summary = self.segment_locally(self.scene, "--include", on, "--exclude", beside)
        query = f"include={on}&exclude={beside}"
        told = self.server.segment_well(self.scene, query + "&outputs=segments")
        self.assertEqual(told["selection"], summary["selection"])
        _, _, body = self.server.segment(self.scene, query, accept="application/octet-stream")
        self.assertEqual(numpy.frombuffer(body, "<u4").tolist(), list(picked))

    def test_errors_are_json_and_name_every_fault(self):
        error = self.error(400, self.scene, "threshold=2&method=none&colour=1&include=a")
        self.assertEqual((error["code"], error["reason"]), ("invalid_argument", "INVALID_FIELD"))
        self.assertEqual([field["field"] for field in error["fields"]], ["threshold", "method", "colour", "include"])
        told = {field["field"]: field["description"] for field in
                self.error(400, self.scene, "colour=1&treshold=0.2&out=labels&depth-scale=1&zzzz=1")["fields"]}
        self.assertEqual(told, {"colour": "is no parameter", "zzzz": "is no parameter", "out": "is no parameter (did you mean outputs?)",
                                "treshold": "is no parameter (did you mean threshold?)",
                                "depth-scale": "is no parameter (did you mean depth_scale?)"})
        error = self.error(400, self.scene, "preset=kitchen")
        self.assertEqual(error["fields"][0]["description"], "'kitchen' is not one of auto, tabletop, room, lidar, scan")
        error = self.error(400, self.scene, "preset=lidar")
        self.assertEqual(error["fields"][0]["field"], "options.preset")
        broken = b"ply\nformat ascii 1.0\n"
        error = self.error(400, broken)
        done = segctl("segment", "-", "--local", stdin=broken)
        self.assertIn(error["message"], done.stderr.decode())
        self.assertEqual(error["reason"], "MALFORMED_PAYLOAD")
        self.assertEqual(self.error(400, b"")["reason"], "MALFORMED_PAYLOAD")
        self.assertEqual(self.error(400, self.scene, "include=500,1")["fields"][0]["field"], "prompts")
        self.assertEqual(self.error(400, self.scene, "q=%zz")["fields"][0]["field"], "query")

    def test_paths_and_methods_that_there_are_not(self):
        for method, target, status in (("GET", "/v1/segment", 405), ("GET", "/../etc/passwd", 404), ("GET", "/etc/passwd", 404),
                                       ("GET", "//etc/passwd", 404), ("GET", "/%2e%2e/etc/passwd", 404), ("POST", "/", 405),
                                       ("GET", "file:///etc/passwd", 404), ("DELETE", "/healthz", 405),
                                       ("GET", "/segserve.v1.SegmentationService/Segment", 405)):
            got, headers, body = self.server.request(method, target)
            self.assertEqual(got, status, (method, target))
            self.assertNotIn(b"root:", body)
            for name, value in SECURITY.items():
                self.assertEqual(headers[name], value)
            self.assertEqual(headers["content-security-policy"], "default-src 'none'; frame-ancestors 'none'")
        self.assertEqual(self.server.segment(self.scene, accept="image/png")[0], 406)
        self.assertEqual(self.server.segment(self.scene, headers={"Content-Encoding": "gzip"})[0], 415)

    def test_health_and_metrics(self):
        self.assertEqual(self.server.request("GET", "/healthz")[::2], (200, b"ok\n"))
        self.assertEqual(self.server.request("GET", "/readyz")[::2], (200, b"ok\n"))
        self.assertEqual(self.server.request("HEAD", "/healthz")[::2], (200, b""))
        self.server.segment_well(self.scene)
        status, headers, body = self.server.request("GET", "/metrics")
        self.assertEqual((status, headers["content-type"]), (200, "text/plain; version=0.0.4; charset=utf-8"))
        self.assertIn(b"segserve_frames_total", body)

    def test_bodies_in_chunks(self):
        content = self.scene.read_bytes()
        pieces = (content[at:at + 5000] for at in range(0, len(content), 5000))
        status, _, body = self.server.request("POST", "/v1/segment", pieces)
        self.assertEqual(status, 200, body[:300])
        self.assertEqual(json.loads(body)["points"], WIDTH * HEIGHT)

    def test_bodies_of_a_few_bytes(self):
        for content in (b"1 2 3", b"1 2 3\n", b"1 2 3\n4 5 6.25", b"1 2 3\n4 5 6.125", b"1 2 3\n4 5 6.125\n7 8 9\n"):
            for body in (content, (content[at:at + 2] for at in range(0, len(content), 2))):
                status, _, answer = self.server.request("POST", "/v1/segment", body)
                self.assertEqual(status, 200, (content, answer[:300]))

    def test_bodies_are_bounded_exactly(self):
        limit = 1 << 20
        server = WebServer(self.folder, "--stream-bytes", str(limit))
        self.addCleanup(server.close)
        for size, status, reason in ((limit, 400, "MALFORMED_PAYLOAD"), (limit + 1, 413, "LIMIT_EXCEEDED")):
            content = b"x" * size
            for body in (content, (content[at:at + 50_000] for at in range(0, size, 50_000))):
                got, _, answer = server.request("POST", "/v1/segment", body)
                self.assertEqual((got, json.loads(answer)["error"]["reason"]), (status, reason))

    def test_a_deadline_ends_the_call(self):
        error = self.error(504, self.scene, "timeout=0.0001")
        self.assertEqual((error["code"], error["reason"]), ("deadline_exceeded", "DEADLINE_EXCEEDED"))

    def answer_to(self, text):
        """The status and the error of a request that is sent as it stands."""
        with socket.create_connection(("127.0.0.1", self.server.http_port), timeout=20) as connection:
            connection.sendall(text)
            answer = http.client.HTTPResponse(connection)
            answer.begin()
            body = answer.read()
        return answer.status, json.loads(body)["error"]["message"] if answer.status != 200 else body.decode()

    def test_requests_that_break_the_rules_of_http_are_told_why(self):
        for text, status, why in ((b"GET /healthz HTTP/1.1\r\n\r\n", 400, "one header Host"),
                                  (b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nHost: a\r\n\r\n", 400, "one header Host"),
                                  (b"GET /healthz HTTP/1.0\r\n\r\n", 200, "ok"),
                                  (b"GET / HTTP/1.1\r\nHost localhost\r\n\r\n", 400, "the header of the request is wrong"),
                                  (b"GET / HTTP/1.1\r\nA: " + b"a" * 20_000 + b"\r\n\r\n", 431, "more than 16384 bytes")):
            told = self.answer_to(text)
            self.assertEqual(told[0], status, text[:80])
            self.assertIn(why, told[1])

    def test_answers_to_this_machine_and_to_names_that_are_told(self):
        ok, misdirected = 200, 421
        for host in ("localhost", "LOCALHOST:1", "127.0.0.1", "[::1]:8080"):
            self.assertEqual(self.server.request("GET", "/healthz", headers={"Host": host})[0], ok, host)
        for host in ("evil.example", "localhost.evil.example:8080", "127.0.0.1.evil.example", "10.0.0.7"):
            for method, path in (("GET", "/"), ("GET", "/healthz"), ("OPTIONS", "/v1/segment")):
                self.assertEqual(self.server.request(method, path, headers={"Host": host})[0], misdirected, host)
        status, _, _ = self.server.request("POST", "/v1/segment", self.scene.read_bytes(), headers={"Host": "evil.example"})
        self.assertEqual(status, misdirected)
        server = WebServer(self.folder, "--http-host", "robot.example,10.0.0.7")
        self.addCleanup(server.close)
        for host, status in (("Robot.Example:8080", ok), ("10.0.0.7", ok), ("localhost", ok), ("evil.example", misdirected)):
            self.assertEqual(server.request("GET", "/healthz", headers={"Host": host})[0], status, host)

    def test_other_sites_may_not_call_unless_they_are_allowed(self):
        for method in ("OPTIONS", "GET"):
            _, headers, _ = self.server.request(method, "/healthz", headers={"Origin": "https://app.example"})
            self.assertNotIn("access-control-allow-origin", headers)
        server = WebServer(self.folder, "--http-allow-origin", "https://app.example")
        self.addCleanup(server.close)
        status, headers, _ = server.request("OPTIONS", "/v1/segment", headers={"Origin": "https://app.example"})
        self.assertEqual((status, headers["access-control-allow-origin"]), (204, "https://app.example"))
        self.assertIn("Authorization", headers["access-control-allow-headers"])
        _, headers, _ = server.request("GET", "/healthz", headers={"Origin": "https://other.example"})
        self.assertNotIn("access-control-allow-origin", headers)
        self.assertEqual(headers["vary"], "Origin")


class HttpAccess(EndToEnd):
    """Tokens, limits and TLS are those of gRPC."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-http-access-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.scene = cls.folder / "scene.pcd"
        assert segctl("synth", "-o", cls.scene, "-q", "--width", 64, "--height", 48).returncode == SUCCESS
        tokens, token_file = cls.folder / "tokens.toml", cls.folder / "robot.token"
        assert segctl("token", "robot", "--output", token_file, "--tokens", tokens, "--frames-per-second",
                      "2").returncode == SUCCESS
        cls.token = token_file.read_text().strip()
        cls.server = WebServer(cls.folder, "--tokens", str(tokens))
        cls.addClassCleanup(cls.server.close)

    def ask(self, token):
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        status, headers, body = self.server.segment(self.scene, headers=headers)
        return status, headers, json.loads(body)

    def test_tokens_and_limits(self):
        for token, reason in ((None, "TOKEN_MISSING"), ("wrong", "TOKEN_INVALID")):
            status, headers, told = self.ask(token)
            self.assertEqual((status, told["error"]["reason"], headers["www-authenticate"]), (401, reason, "Bearer"))
        answers = [self.ask(self.token) for _ in range(6)]
        self.assertEqual(answers[0][0], 200)
        refused = [(headers, told["error"]) for status, headers, told in answers if status == 429]
        self.assertTrue(refused)
        self.assertEqual(refused[0][1]["reason"], "QUOTA_EXCEEDED")
        self.assertGreaterEqual(int(refused[0][0]["retry-after"]), 1)
        self.assertEqual(self.server.request("GET", "/healthz")[0], 200)
        self.assertEqual(self.server.request("GET", "/")[0] in (200, 404), True)

    def test_tls_with_and_without_certificates_of_clients(self):
        authority = Authority(self.folder, "authority")
        certificate, key = authority.sign("localhost")
        server = WebServer(self.folder, "--tls-cert", str(certificate), "--tls-key", str(key), "--tls-client-ca",
                           str(authority.certificate))
        self.addCleanup(server.close)
        context = ssl.create_default_context(cafile=authority.certificate)
        url = f"https://localhost:{server.http_port}/healthz"
        with self.assertRaises(OSError):
            urllib.request.urlopen(url, context=context, timeout=10).read()
        context.load_cert_chain(*authority.sign("robot"))
        self.assertEqual(urllib.request.urlopen(url, context=context, timeout=10).read(), b"ok\n")
        with self.assertRaises(OSError):
            urllib.request.urlopen(url.replace("https", "http"), timeout=10).read()


class HttpStops(EndToEnd):
    def test_frames_in_flight_finish_when_the_server_stops(self):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-http-stop-"))
        self.addCleanup(shutil.rmtree, folder)
        server = WebServer(folder, "--workers", "1", "--grace-period", "20")
        self.addCleanup(server.close)
        scene = self.synth("--width", "640", "--height", "480")
        answers = []
        threads = [threading.Thread(target=lambda: answers.append(server.segment(scene)[0])) for _ in range(4)]
        for thread in threads:
            thread.start()
        time.sleep(0.25)
        begin = time.monotonic()
        server.process.send_signal(signal.SIGTERM)
        self.assertEqual(server.process.wait(timeout=30), 0)
        for thread in threads:
            thread.join()
        self.assertEqual(set(answers) - {200, 503}, set())
        self.assertIn(200, answers)
        self.assertLess(time.monotonic() - begin, 20)


if __name__ == "__main__":
    unittest.main()
