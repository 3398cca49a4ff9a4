# SPDX-License-Identifier: Apache-2.0
"""segctl stream: frames at a given rate through one stream, with a table on a terminal and a page in a browser."""
import http.client
import json
import os
import pty
import re
import signal
import socket
import subprocess
import threading
import time
import unittest

import pcd
import recordings
from browser import CHROMIUM, SIZE, Browser
from harness import BAD_INPUT, FAILED, SEGCTL, SUCCESS, EndToEnd, segctl

SMALL = ("--width", "160", "--height", "120")
SETTLED = "document.getElementById('view').dataset.settled === 'true'"


class LiveStream:
    """A stream with a page, which loops until it is stopped."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen([SEGCTL, "stream", *map(str, arguments), "--html-live", "127.0.0.1:0"],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.port = int(re.search(rb"http://127\.0\.0\.1:(\d+)/", self.process.stderr.readline())[1])

    def get(self, target, timeout=40, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        connection.request("GET", target, headers=headers)
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer.status, {name.lower(): value for name, value in answer.getheaders()}, body

    def raw(self, text, timeout=10):
        with socket.create_connection(("127.0.0.1", self.port), timeout=timeout) as browser:
            try:
                browser.sendall(text)
                return browser.recv(65536)
            except ConnectionError:
                return b""

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=60)
        return self.process.returncode, out, err

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()


class Stream(EndToEnd):
    def stream(self, *arguments):
        done = self.run_well("stream", *arguments, "--server", self.server.address, "--json", "-")
        return json.loads(done.stdout)

    def folder_of_scenes(self, count=5):
        folder = self.path("frames")
        folder.mkdir()
        for seed in range(1, count + 1):
            self.run_well("synth", "-o", folder / f"scene{seed}.pcd", "-q", "--seed", seed, *SMALL)
        return folder

    def test_sends_a_moving_scene_at_its_rate(self):
        told = self.stream("--moving", "--frames", "12", *SMALL, "--rate", "20", "--wait")
        self.assertEqual((told["frames"], told["results"], told["dropped"], told["failed"]), (12, 12, 0, 0))
        self.assertGreater(told["seconds"], 11 / 20 - 0.05)
        self.assertGreater(told["segments"], 1)
        self.assertGreaterEqual(told["p95_ms"], told["p50_ms"])

    def test_sends_files_and_folders(self):
        folder = self.folder_of_scenes()
        started = time.monotonic()
        told = self.stream(folder, "--rate", "10", "--wait")
        self.assertEqual((told["frames"], told["results"]), (5, 5))
        self.assertGreater(time.monotonic() - started, 0.4)
        told = self.stream(*sorted(folder.iterdir()), "--rate", "50", "--wait")
        self.assertEqual(told["results"], 5)

    def test_sequences_have_their_own_times(self):
        moving = self.path("moving")
        self.run_well("synth", "--moving", moving, "-q", "--rate", "5", "--frames", "6", *SMALL)
        for speed, least, most in ((1, 0.95, 30), (10, 0.09, 0.95)):
            told = self.stream(moving, "--speed", speed, "--wait", "--track")
            self.assertEqual(told["results"], 6)
            self.assertGreater(told["seconds"], least)
            if most < 1 and told["p95_ms"] < 50:
                self.assertLess(told["seconds"], most)

    def test_sends_recordings(self):
        if recordings.missing:
            self.skipTest(f"no recording was tried: {recordings.missing}")
        x, y, z, color = pcd.read_points(self.synth("--width", "80", "--height", "60"))
        points = [point + (0,) for point in zip(x, y, z, color)]
        clouds = [(i * 10**8, recordings.point_cloud2(recordings.FIRST + i, points, "camera_optical_frame", 80)) for i in range(4)]
        run = recordings.write(self.path("run.mcap"), [recordings.clouds("/points", clouds)])
        told = self.stream(run, "--topic", "/points", "--wait")
        self.assertEqual((told["results"], told["failed"]), (4, 0))
        self.assertGreater(told["seconds"], 0.29)

    def test_tells_that_its_rate_was_not_kept(self):
        folder = self.folder_of_scenes(2)
        slow = self.path("slow.pcd")
        os.mkfifo(slow)

        def feed():
            with open(slow, "wb") as writer:
                time.sleep(0.6)
                writer.write((folder / "scene1.pcd").read_bytes())
        thread = threading.Thread(target=feed)
        thread.start()
        self.addCleanup(thread.join)
        done = self.run_well("stream", folder / "scene1.pcd", slow, folder / "scene2.pcd", "--rate", "20", "--wait", "--server",
                             self.server.address, "--json", self.path("told.json"))
        self.assertRegex(done.stdout.decode(), r"; the rate was not kept: \d frames were sent more than 50 ms late, up to \d+ ms\n$")
        told = json.loads(self.path("told.json").read_text())
        self.assertGreaterEqual(told["late"], 1)
        self.assertGreater(told["longest_delay_ms"], 300)

    def test_loops_until_its_time_is_over(self):
        folder = self.folder_of_scenes(2)
        told = self.stream(folder, "--rate", "20", "--loop", "--duration", "1.5", "--wait")
        self.assertGreater(told["frames"], 5)
        self.assertEqual(told["results"], told["frames"])

    def test_drops_what_comes_too_fast_and_ends_each_frame_once(self):
        told = self.stream("--moving", "--frames", "40", "--rate", "1000", *SMALL)
        self.assertEqual(told["frames"], 40)
        self.assertEqual(told["results"] + told["dropped"] + told["failed"], 40)

    def test_a_bad_frame_stops_no_other(self):
        folder = self.folder_of_scenes(3)
        (folder / "scene0.ply").write_text("ply\nformat ascii 1.0\n")
        done = segctl("stream", folder, "--rate", "20", "--wait", "--server", self.server.address, "--json", "-")
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertRegex(done.stderr, rb"\Asegctl: 1 of \d+ frames failed; [^\n]*scene0.ply: [^\n]+\n\Z")
        told = json.loads(done.stdout)
        self.assertEqual((told["results"], told["failed"]), (3, 1))

    def test_without_a_terminal_there_is_only_the_summary(self):
        done = self.run_well("stream", "--moving", "--frames", "4", *SMALL, "--wait", "--server", self.server.address)
        self.assertRegex(done.stdout.decode(), r"\Aa moving table: 4 frames, 4 results, 0 dropped, 0 failed in [\d.]+ s: "
                                               r"[\d.]+ a second, p50 [\d.]+ ms, p95 [\d.]+ ms(; the rate was not kept: [^\n]+)?\n\Z")

    def test_a_terminal_shows_a_table(self):
        main, other = pty.openpty()
        process = subprocess.Popen([SEGCTL, "stream", "--moving", "--frames", "20", *SMALL, "--rate", "10", "--server",
                                    self.server.address], stdout=subprocess.PIPE, stderr=other,
                                   env=os.environ | {"TERM": "xterm"})
        os.close(other)
        text = b""
        while True:
            try:
                part = os.read(main, 4096)
            except OSError:  # The terminal is closed at the end.
                break
            if not part:
                break
            text += part
        out, _ = process.communicate(timeout=60)
        os.close(main)
        self.assertEqual(process.returncode, SUCCESS)
        text = text.decode()
        for name in ("frames", "rate/s", "p50 ms", "p95 ms", "dropped", "segments"):
            self.assertIn(name, text)
        self.assertGreater(text.count("\x1b["), 4)
        self.assertTrue(text.endswith("\x1b[J"), "the table is wiped at the end")
        self.assertIn(b"20 frames", out)

    def test_says_what_is_wrong(self):
        scene = self.synth(*SMALL)
        local = ("--server", self.server.address)
        for said, *arguments in (("INPUT is required", ), ("exclude each other", scene, "--moving"),
                                 ("--html-live 0.0.0.0:0: whoever", scene, "--html-live", "0.0.0.0:0", *local),
                                 ("--html-live here: it must be HOST:PORT", scene, "--html-live", "here", *local),
                                 ("--html-live-for-anyone needs", scene, "--html-live-for-anyone"),
                                 ("there is no", scene, self.path("none.pcd"), *local),
                                 ("must be the only INPUT", scene, self.folder, *local),
                                 ("for one recording", scene, "--topic", "/points", *local),
                                 ("--loop cannot", "-", "--loop"), ("--rate", scene, "--rate", "0"),
                                 ("--speed", scene, "--rate", "5", "--speed", "2")):
            with self.subTest(said=said):
                self.assertIn(said, self.run_badly(BAD_INPUT, "stream", *arguments))
        self.assertIn("127.0.0.1:1", self.run_badly(FAILED, "stream", scene, "--server", "127.0.0.1:1", "--timeout", "2"))


class LivePage(EndToEnd):
    def setUp(self):
        if b"without its pages" in segctl("view", "none.pcd", "-o", self.path("none.html")).stderr:
            self.skipTest("segctl was built without npm: there is no page to test")
        self.live = LiveStream("--moving", "--frames", "100", *SMALL, "--rate", "10", "--loop", "--server",
                               self.server.address)
        self.addCleanup(self.live.close)

    def newest(self, after=0):
        status, headers, body = self.live.get(f"/live?after={after}")
        self.assertEqual((status, headers["content-type"]), (200, "application/json"))
        return json.loads(body)

    def test_serves_the_newest_frame_again_and_again(self):
        first = self.newest()
        second = self.newest(first["sequence"])
        self.assertGreater(second["sequence"], first["sequence"])
        self.assertEqual(len(second["page"]["clouds"]), 1)
        self.assertTrue(second["arrays"])
        self.assertGreater(second["stats"]["results"], 0)
        time.sleep(1)  # A slow browser skips frames.
        self.assertGreater(self.newest(second["sequence"])["sequence"], second["sequence"] + 3)
        code, out, err = self.live.stop()
        self.assertEqual((code, err), (SUCCESS, b""))
        self.assertIn(b"results", out)

    def test_has_strict_headers(self):
        status, headers, body = self.live.get("/")
        self.assertEqual((status, headers["content-type"]), (200, "text/html; charset=utf-8"))
        policy = headers["content-security-policy"]
        for part in ("default-src 'none'", "connect-src 'self'", "frame-ancestors 'none'"):
            self.assertIn(part, policy)
        self.assertNotIn("unsafe", policy)
        self.assertIn(b'id="live-stream"', body)
        for target in ("/", "/live?after=0", "/nothing", "/live?after=x"):
            _, headers, _ = self.live.get(target)
            self.assertEqual(headers["x-content-type-options"], "nosniff")
            self.assertEqual(headers["cache-control"], "no-store")
            self.assertEqual(headers["cross-origin-resource-policy"], "same-origin")
            self.assertNotIn("access-control-allow-origin", headers)

    def test_answers_no_other_host_and_no_other_method(self):
        for host in ("localhost", "127.0.0.1:80", "[::1]:9", "LOCALHOST:8081", "127.1.2.3"):
            self.assertEqual(self.live.get("/", Host=host)[0], 200, host)
        for host in ("evil.example", "localhost.evil.example", "127.0.0.1.evil.example", "127.0.0.1@evil", "", "[::2]", "[::1",
                     "localhost:8081:1", "10.0.0.1"):
            self.assertEqual(self.live.get("/", Host=host)[0], 421, host)
        self.assertEqual(self.live.get("/../etc/passwd")[0], 404)
        for method in (b"POST", b"OPTIONS", b"PUT"):
            self.assertIn(b" 405 ", self.live.raw(method + b" / HTTP/1.1\r\nHost: localhost\r\n\r\n"))
        for more in (b"Host: evil.example", b"Content-Length: -5", b"Content-Length: 3", b"Transfer-Encoding: chunked"):
            self.assertIn(b" 400 ", self.live.raw(b"GET / HTTP/1.1\r\nHost: localhost\r\n" + more + b"\r\n\r\n"), more)

    def test_silent_and_hostile_browsers_hold_nobody_up(self):
        silent = [socket.create_connection(("127.0.0.1", self.live.port), timeout=30) for _ in range(12)]
        for browser in silent:
            self.addCleanup(browser.close)
        self.assertTrue(self.newest()["arrays"])
        self.assertEqual(self.live.raw(b"GET /" + b"a" * 100_000), b"", "an endless line is cut")
        for garbage in (b"\0\0\0\0\r\n\r\n", b"GET\r\n\r\n", b"GET  HTTP/1.1\r\n\r\n"):
            self.assertIn(b" 405 ", self.live.raw(garbage))
        self.assertEqual(self.live.stop()[0], SUCCESS)

    def test_a_browser_follows_the_stream(self):
        if CHROMIUM is None:
            self.skipTest("there is no chromium: pages are not opened")
        browser = Browser()
        self.addCleanup(browser.close)
        sequence = "Number(document.getElementById('live').dataset.sequence)"
        told = browser.visit(f"http://127.0.0.1:{self.live.port}/", [
            ["wait_for", f"{sequence} > 0"], ["run", f"window.firstSequence = {sequence}"],
            ["wait_for", f"{sequence} > window.firstSequence + 3"], ["run", "document.getElementById('pause').click()"],
            ["wait_for", SETTLED], ["text", "#live-message"], ["text", "#heads span"], ["run", sequence]], self.folder, SIZE)
        self.assertEqual(told["faults"], [])
        answers = told["answers"]
        self.assertRegex(answers[5], r"\d+ results · [\d.]+ a second · p50 [\d.]+ ms · p95 [\d.]+ ms · \d+ dropped")
        self.assertRegex(answers[6], r"[\d,]+ points · \d+ segments")
        self.assertGreater(answers[7], answers[1])


if __name__ == "__main__":
    unittest.main()
