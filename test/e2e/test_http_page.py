# SPDX-License-Identifier: Apache-2.0
"""The page of the web entrance in a browser: files are dropped on it, and pixels are read."""
import json
import pathlib
import shutil
import tempfile
import unittest

import numpy

from browser import CHROMIUM, SIZE, Browser
from harness import SUCCESS, segctl
from http_client import WebServer
from test_view import LEFT, RIGHT, is_near, two_plates

DONE = "document.getElementById('open-message').textContent.includes(' segmented')"
FAILED = "document.getElementById('open-message').dataset.failed === 'true'"


class HttpPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if CHROMIUM is None:
            raise unittest.SkipTest("there is no chromium: pages are not opened")
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-http-page-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.server = WebServer(cls.folder)
        cls.addClassCleanup(cls.server.close)
        if cls.server.request("GET", "/")[0] == 404:
            raise unittest.SkipTest("segserve was built without npm: there is no page to test")
        cls.browser = Browser()
        cls.addClassCleanup(cls.browser.close)
        cls.plates = cls.folder / "plates.pcd"
        cls.plates.write_bytes(two_plates(truth=False))

    def open(self, *steps, faults=(), server=None):
        server = server or self.server
        address = f"http://127.0.0.1:{server.http_port}/"
        downloads = self.folder / self.id()
        downloads.mkdir(exist_ok=True)
        told = self.browser.visit(address, steps, downloads, SIZE)
        for request in told["requests"]:
            self.assertTrue(request.startswith((address, "blob:")), f"the page asked {request}")
        self.assertEqual(len(told["faults"]), len(faults), told["faults"])
        for fault, expected in zip(told["faults"], faults):
            self.assertIn(expected, fault)
        return told["answers"]

    def test_has_strict_headers(self):
        status, headers, body = self.server.request("GET", "/")
        self.assertEqual((status, headers["content-type"]), (200, "text/html; charset=utf-8"))
        policy = headers["content-security-policy"]
        for part in ("default-src 'none'", "connect-src 'self'", "frame-ancestors 'none'", "base-uri 'none'"):
            self.assertIn(part, policy)
        self.assertNotIn("unsafe", policy)
        self.assertIn(b"connect-src 'self'", body)

    def test_a_dropped_file_is_segmented_and_shown(self):
        answers = self.open(["drop", str(self.plates)], ["wait_for", DONE], ["settle"], ["press", "l"], ["settle"],
                            ["pixel", *LEFT], ["pixel", *RIGHT], ["text", "#segment-count"], ["text", "#heads b"],
                            ["run", "document.getElementById('drop').hidden"], ["press", "1"], ["settle"], ["picture", "page.png"])
        self.assertFalse(is_near(answers[5], answers[6], by=20), "both plates have the same color")
        self.assertEqual(answers[8], "plates.pcd")
        self.assertTrue(answers[9])
        done = segctl("segment", self.plates, "--local", "--json", "-")
        self.assertEqual(int("".join(filter(str.isdigit, answers[7]))), json.loads(done.stdout)["segments"])

    def test_other_files_follow(self):
        ply = self.folder / "other.ply"
        self.assertEqual(segctl("synth", "-o", ply, "-q", "--width", 64, "--height", 48).returncode, SUCCESS)
        las = self.folder / "other.las"
        self.assertEqual(segctl("segment", ply, "--local", "-q", "-o", las).returncode, SUCCESS)
        answers = self.open(["drop", str(self.plates)], ["wait_for", DONE], ["settle"],
                            ["drop", str(ply)], ["wait_for", "document.title === 'other.ply'"], ["settle"], ["text", "#heads b"],
                            ["drop", str(las)], ["wait_for", "document.title === 'other.las'"], ["settle"], ["text", "#heads b"],
                            ["press", "]"], ["slide", "#regions", "0.2"], ["settle"])
        self.assertEqual((answers[6], answers[10]), ("other.ply", "other.las"))

    def test_a_pair_of_images(self):
        depth, color = self.folder / "depth.pgm", self.folder / "color.ppm"
        rows = numpy.full((48, 64), 1200, numpy.uint16)
        rows[:, :32] = 1000
        depth.write_bytes(b"P5\n64 48\n65535\n" + rows.astype(">u2").tobytes())
        color.write_bytes(b"P6\n64 48\n255\n" + numpy.full((48, 64, 3), 120, numpy.uint8).tobytes())
        answers = self.open(["run", "document.getElementById('intrinsics').value = '60,60,31.5,23.5'"],
                            ["drop", str(color), str(depth)], ["wait_for", DONE], ["settle"], ["text", "#heads span"],
                            ["text", "#open-message"])
        self.assertIn("3,072 points", answers[4])
        self.assertEqual(answers[5], "color.ppm and depth.pgm were segmented.")

    def test_controls_come_with_the_first_file(self):
        shown = "[...document.getElementById('panel').children].filter((part) => part.offsetHeight > 0).map((part) => part.id).join()"
        answers = self.open(["run", shown], ["drop", str(self.plates)], ["wait_for", DONE], ["settle"], ["run", shown],
                            ["text", "#open-message"])
        self.assertEqual(answers[0], "open")
        self.assertIn("paints", answers[4].split(","))
        self.assertEqual(answers[5], "plates.pcd was segmented.")

    def test_no_button_is_cut_off(self):
        answers = self.open(["drop", str(self.plates)], ["wait_for", DONE], ["settle"],
                            ["run", "[...document.querySelectorAll('button')].filter((button) => button.scrollWidth > "
                                    "button.clientWidth).map((button) => button.textContent).join()"])
        self.assertEqual(answers[3], "")

    def test_the_keys_are_those_that_do_something(self):
        keys = self.open(["drop", str(self.plates)], ["wait_for", DONE], ["settle"], ["press", "?"], ["text", "#key-list"])[4]
        self.assertIn("Stability", keys)
        for other in ("Ground truth", "Errors", "the other side"):
            self.assertNotIn(other, keys)

    def test_texts_can_be_written_beside_a_cloud(self):
        answers = self.open(["drop", str(self.plates)], ["wait_for", DONE], ["settle"],
                            ["run", "document.querySelector('details').open = true"],
                            ["run", "document.getElementById('intrinsics').value = ''"],
                            ["run", "document.getElementById('intrinsics').focus()"],
                            *(["press", key] for key in "6,5h"), ["run", "document.getElementById('intrinsics').value"])
        self.assertEqual(answers[-1], "6,5h")

    def test_errors_are_the_sentences_of_segctl_and_nothing_but_text(self):
        broken = self.folder / "<img src=x onerror=alert(1)>.ply"
        broken.write_bytes(b"ply\nformat ascii 1.0\nelement vertex <img src=x onerror=alert(1)>\nend_header\n")
        done = segctl("segment", broken, "--local")
        answers = self.open(["drop", str(broken)], ["wait_for", FAILED], ["text", "#open-message"],
                            ["run", "document.images.length"], faults=("400",))
        self.assertIn(answers[2], done.stderr.decode())
        self.assertEqual(answers[3], 0)

    def test_a_token_is_asked_for(self):
        tokens, token_file = self.folder / "tokens.toml", self.folder / "robot.token"
        self.assertEqual(segctl("token", "robot", "--output", token_file, "--tokens", tokens).returncode, SUCCESS)
        server = WebServer(self.folder, "--tokens", str(tokens))
        self.addCleanup(server.close)
        token = token_file.read_text().strip()
        answers = self.open(["drop", str(self.plates)], ["wait_for", FAILED], ["text", "#open-message"],
                            ["run", f"document.getElementById('token').value = '{token}'"],
                            ["drop", str(self.plates)], ["wait_for", DONE], ["settle"], faults=("401",), server=server)
        self.assertIn("token", answers[2])


if __name__ == "__main__":
    unittest.main()
