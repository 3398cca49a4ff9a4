# SPDX-License-Identifier: Apache-2.0
"""The client for browsers of client/js gives what segctl gives, over the web entrance: in Node, and in a browser.

JS_PACKAGE is the folder of the package that was built of client/js.
"""
import http.server
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import threading
import time
import unittest

from certificates import Authority
from harness import SEGCTL, SEGSERVE
from test_js_client import JavaScriptClient, PACKAGE

CHROMIUM = shutil.which("chromium")


def has_web_entrance():
    return "--http ADDRESS" in subprocess.run([SEGSERVE, "--help"], capture_output=True, text=True, check=True).stdout


@unittest.skipUnless(has_web_entrance(), "this segserve has no web entrance")
class WebClient(JavaScriptClient):
    """A server with a web entrance."""

    scheme = "http"
    more_flags = ()

    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-e2e-web-"))
        cls.addClassCleanup(shutil.rmtree, folder)
        port_file = folder / "http-port"
        cls.server_flags = ("--http", "127.0.0.1:0", "--http-port-file", str(port_file), *cls.more_flags)
        super().setUpClass()
        deadline = time.monotonic() + 30
        while not (port_file.exists() and port_file.read_text().strip()):
            assert time.monotonic() < deadline, "the web entrance does not open"
            time.sleep(0.02)
        cls.url = f"{cls.scheme}://localhost:{port_file.read_text().strip()}"

    def do_web(self, task, options=None):
        return self.do(task, {"web": True} | (options or {}), self.url)


class SameAsSegctl(WebClient):
    def test_labels_for_every_codec(self):
        codecs = ("planar", "planar-zstd", "strided", "strided-zstd", "pcd", "quantised")
        told = self.do_web("segment", {"calls": {codec: {"view": "camera", "codec": codec} for codec in codecs}})
        for codec, result in zip(codecs, told, strict=True):
            with self.subTest(codec):
                expected, summary = self.by_segctl("--codec", codec)
                self.assert_labels(codec, expected)
                self.assertEqual((result["optionsHash"], result["segmentCount"]), (summary["options_hash"], summary["segments"]))

    def test_cuts_and_picks(self):
        labels, _ = self.by_segctl()
        told = self.do_web("cut", {"cuts": {"seven": {"regions": 7}, "middle": {"threshold": 0.2}},
                                   "picks": {"object": {"include": [labels.index(2)], "exclude": [labels.index(1)]}}})
        for name in ("seven", "middle"):
            self.assert_labels(name, self.labels(f"{name}-again"))
        self.assertGreater(len(told[0]["candidates"]), 0)

    def test_what_the_server_says(self):
        info, = self.do_web("info")
        self.assertEqual(set(info["methods"]), set(info["methodNames"]))

    def test_errors_are_those_of_grpc(self):
        calls = {"calls": [{"view": "camera", "options": {"voxelResolution": 100, "normalWeight": -1}},
                           {"view": "camera", "timeoutMs": 1}]}
        for by_web, by_grpc in zip(self.do_web("errors", calls), self.do("errors", calls)):
            self.assertEqual((by_web["name"], by_web["code"], by_web.get("fields")),
                             (by_grpc["name"], by_grpc["code"], by_grpc.get("fields")))
        nobody, = self.do("errors", {"web": True, "calls": [{"view": "camera"}]}, "http://127.0.0.1:1")
        self.assertEqual(nobody["code"], "UNAVAILABLE")
        self.assertIn("is segserve --http running there", nobody["message"])


class WithTokensAndTls(WebClient):
    scheme = "https"

    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-e2e-web-tls-"))
        cls.addClassCleanup(shutil.rmtree, folder)
        authority = Authority(folder, "authority")
        certificate, key = authority.sign("server")
        cls.token = folder / "robot.token"
        subprocess.run([SEGCTL, "token", "robot", "--output", cls.token, "--tokens", folder / "tokens.toml"], check=True,
                       capture_output=True)
        cls.more_flags = ("--tls-cert", str(certificate), "--tls-key", str(key), "--tokens", str(folder / "tokens.toml"))
        super().setUpClass()
        os.environ["NODE_EXTRA_CA_CERTS"] = str(authority.certificate)
        cls.addClassCleanup(os.environ.pop, "NODE_EXTRA_CA_CERTS")

    def test_the_token_is_asked_for(self):
        expected, _ = self.segment_locally(self.scene)
        known = {"client": {"token": self.token.read_text().strip()}}
        self.do_web("segment", known | {"calls": {"known": {"view": "camera"}}})
        self.assert_labels("known", expected)
        for client, reason in (({}, "TOKEN_MISSING"), ({"token": "wrong"}, "TOKEN_INVALID")):
            error, = self.do_web("errors", {"client": client, "calls": [{"view": "camera"}]})
            self.assertEqual((error["code"], error["reason"]), ("UNAUTHENTICATED", reason))


class Site(http.server.BaseHTTPRequestHandler):
    """A site of another origin with a page that segments, and tells what it got."""

    def do_GET(self):
        kind, content = self.server.files.get(self.path, ("text/plain", b""))
        self.send_response(200 if content else 404)
        self.send_header("Content-Type", kind)
        self.end_headers()
        self.wfile.write(content)

    def do_POST(self):
        self.server.told[self.path] = self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(204)
        self.end_headers()
        self.server.is_told.set()

    def log_message(self, *_):
        """The test needs no log."""


PAGE = """
import {Client, METHODS} from 'segserve';  // with "browser", this is segserve/web
const tell = (path, body) => fetch(path, {method: 'POST', body});
try {
  const pcd = new Uint8Array(await (await fetch('/scene.pcd')).arrayBuffer());
  const client = new Client(SERVER);
  const result = await client.segment({pcd, frameId: 'page'});
  const refused = await client.segment({pcd, options: {voxelResolution: 100}}).catch((error) => error);
  await tell('/labels', result.labels);
  await tell('/cut', result.cut({regions: 5}));
  await tell('/summary', JSON.stringify({segments: result.segmentCount, frame: result.frameId, methods: METHODS.length,
                                         refused: refused.reason, fields: refused.fieldViolations}));
} catch (error) {
  await tell('/error', String(error.stack));
}
"""


@unittest.skipUnless(CHROMIUM, "there is no chromium")
class InABrowser(WebClient):
    more_flags = ("--http-allow-origin", "*")

    def bundle(self):
        (self.folder / "page.js").write_text(PAGE)
        (self.folder / "node_modules").mkdir()
        (self.folder / "node_modules/segserve").symlink_to(PACKAGE)
        done = subprocess.run([PACKAGE / "node_modules/.bin/esbuild", "page.js", "--bundle", "--platform=browser", "--format=esm",
                               "--minify", f"--define:SERVER={json.dumps(self.url)}", "--outfile=bundle.js"], cwd=self.folder,
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        return (self.folder / "bundle.js").read_bytes()

    def open(self, files):
        """What a page says that is opened from such a site."""
        site = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Site)
        site.files, site.told, site.is_told = files, {}, threading.Event()
        threading.Thread(target=site.serve_forever, daemon=True).start()
        self.addCleanup(site.server_close)
        self.addCleanup(site.shutdown)
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
            browser = subprocess.Popen([CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}",
                                        "--remote-debugging-port=0", f"http://127.0.0.1:{site.server_port}/"],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                self.wait_for(lambda: "/summary" in site.told or "/error" in site.told, 90)
            finally:
                browser.terminate()
                browser.wait()
        return site.told

    def test_a_page_of_another_origin_gets_the_labels_of_segctl(self):
        bundle = self.bundle()
        self.assertNotIn(b"grpc-js", bundle)
        self.assertLess(len(bundle), 250_000)
        told = self.open({"/": ("text/html", b"<!doctype html><script type=module src=/bundle.js></script>"),
                          "/bundle.js": ("text/javascript", bundle),
                          "/scene.pcd": ("application/octet-stream", self.scene.read_bytes())})
        self.assertNotIn("/error", told, told.get("/error"))
        expected, summary = self.by_segctl()
        for path, name in (("/labels", "page-labels"), ("/cut", "page-cut")):
            (self.folder / f"{name}.u32").write_bytes(told[path])
        self.assert_labels("page-labels", expected)
        self.assertEqual(max(self.labels("page-cut")), 5)
        said = json.loads(told["/summary"])
        self.assertEqual((said["segments"], said["frame"], said["refused"]), (summary["segments"], "page", "INVALID_FIELD"))
        self.assertEqual([fault["field"] for fault in said["fields"]], ["options.voxel_resolution"])


del JavaScriptClient  # whose tests are those of test_js_client

if __name__ == "__main__":
    unittest.main()
