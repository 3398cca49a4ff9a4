# SPDX-License-Identifier: Apache-2.0
"""Unary calls of the protocol Connect: by the packages of @connectrpc, as browsers use them, and byte by byte."""
import base64
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

from harness import EndToEnd, SUCCESS, segctl
from http_client import WebServer
import node_packages

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PACKAGES = {"@connectrpc/connect": "2.0.4", "@connectrpc/connect-web": "2.0.4", "@bufbuild/protobuf": "2.6.3",
            "@bufbuild/protoc-gen-es": "2.6.3"}
SERVICE = "/segserve.v1.SegmentationService/"


class Connect(EndToEnd):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-connect-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.server = WebServer(cls.folder)
        cls.addClassCleanup(cls.server.close)
        cls.scene = cls.folder / "scene.pcd"
        assert segctl("synth", "-o", cls.scene, "-q", "--width", 64, "--height", 48).returncode == SUCCESS

    def call(self, method, body, content_type="application/json", **headers):
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        return self.server.request("POST", SERVICE + method, body, {"Content-Type": content_type, **headers})

    def request(self, **fields):
        return json.dumps({"cloud": {"pcdFile": {"file": {"data": base64.b64encode(self.scene.read_bytes()).decode()}}},
                           **fields})

    def test_the_packages_of_connectrpc_get_the_labels_of_segctl(self):
        modules = node_packages.installed("connect", PACKAGES)
        generated = self.folder / "javascript"
        generated.mkdir()
        subprocess.run(["protoc", f"--plugin=protoc-gen-es={modules / '.bin/protoc-gen-es'}", f"--es_out={generated}",
                        "--es_opt=target=js,import_extension=js", f"--proto_path={ROOT / 'proto'}",
                        *(str(path.relative_to(ROOT / "proto")) for path in sorted((ROOT / "proto/segserve/v1").glob("*.proto"))),
                        "google/rpc/status.proto", "google/rpc/error_details.proto"], check=True, cwd=ROOT / "proto")
        (generated / "package.json").write_text('{"type": "module"}')
        (generated / "node_modules").symlink_to(modules)
        expected, summary = self.segment_locally(self.scene)
        for form in ("proto", "json"):
            with self.subTest(form):
                done = subprocess.run(["node", HERE / "clients/connect_client.mjs", modules, generated,
                                       f"http://127.0.0.1:{self.server.http_port}", self.scene, form], capture_output=True,
                                      timeout=120, env=os.environ)
                self.assertEqual(done.returncode, 0, done.stderr.decode())
                told = json.loads(done.stdout)
                self.assertEqual((told["labels"], told["segments"]), (list(expected), summary["segments"]))
                self.assertEqual((told["version"], told["requestId"]), (summary["version"], "from node"))
                self.assertEqual((told["wrong"]["code"], told["wrong"]["reasons"]), ("InvalidArgument", ["INVALID_FIELD"]))
                self.assertEqual(told["wrong"]["fields"], ["options.seed_resolution", "options.lambda"])
                self.assertEqual(told["late"]["code"], "DeadlineExceeded")

    def test_errors_have_the_form_of_connect(self):
        status, headers, body = self.call("Segment", "{}")
        told = json.loads(body)
        self.assertEqual((status, headers["content-type"], told["code"]), (400, "application/json", "invalid_argument"))
        self.assertIn("cloud", told["message"])
        self.assertEqual({detail["type"] for detail in told["details"]},
                         {"google.rpc.ErrorInfo", "google.rpc.BadRequest"})
        for detail in told["details"]:
            self.assertNotIn("=", detail["value"])
            base64.b64decode(detail["value"] + "==")
        for body, content_type in ((b"\xff\xff\xff", "application/proto"), ("{", "application/json"),
                                   ('{"cloud": 7}', "application/json"), ("[" * 100_000, "application/json"),
                                   ('{"a":[' + "{}," * 100_000 + "{}]}", "application/json")):
            status, _, answer = self.call("Segment", body, content_type)
            self.assertEqual((status, json.loads(answer)["code"]), (400, "invalid_argument"), answer[:200])

    def test_names_that_json_misspells_are_refused(self):
        for fields, name in (({"foo": 1}, "foo"), ({"options": {"treshold": 0.4}}, "treshold"), ({"cloud": {"unit": "X"}}, "unit")):
            status, _, body = self.call("Segment", json.dumps(fields))
            self.assertEqual((status, json.loads(body)["code"]), (400, "invalid_argument"), fields)
            self.assertIn(name, json.loads(body)["message"])
        for body in ("{", "", '{"foo": 1}', "[]"):
            status, _, answer = self.call("GetServerInfo", body)
            self.assertEqual((status, json.loads(answer)["code"]), (400, "invalid_argument"), body)
        status, _, answer = self.call("GetServerInfo", " " * (65 << 10))
        self.assertEqual((status, json.loads(answer)["code"]), (400, "invalid_argument"))
        self.assertEqual(self.call("GetServerInfo", b"", "application/proto")[0], 200)

    def test_what_is_not_a_unary_call_is_refused(self):
        for kind in ("text/plain", "application/grpc", "application/grpc-web+proto", "application/connect+json"):
            status, headers, body = self.call("Segment", "", kind)
            self.assertEqual((status, headers["content-type"]), (415, "application/json"))
            self.assertIn("must be application/proto or application/json", json.loads(body)["message"])
        self.assertEqual(self.call("SegmentStream", "", "application/proto")[0], 501)
        self.assertEqual(self.call("Nothing", "{}")[0], 404)
        for headers in ({"Content_Encoding": "gzip"}, {"Connect_Protocol_Version": "2"}, {"Connect_Timeout_Ms": "soon"}):
            status, _, body = self.call("Segment", self.request(), **headers)
            self.assertEqual((status, json.loads(body)["code"]), (400, "invalid_argument"), headers)
        status, _, body = self.call("Segment", self.request(), Connect_Timeout_Ms="0")
        self.assertEqual((status, json.loads(body)["code"]), (504, "deadline_exceeded"))

    def test_a_request_that_is_too_large_is_refused_before_it_comes(self):
        status, _, body = self.server.request("POST", SERVICE + "Segment", None,
                                              {"Content-Type": "application/proto", "Content-Length": str(9 << 20)})
        self.assertEqual((status, json.loads(body)["code"]), (400, "invalid_argument"))

    def test_server_info(self):
        status, headers, body = self.call("GetServerInfo", "{}")
        self.assertEqual((status, headers["content-type"]), (200, "application/json"))
        self.assertIn("maxPoints", json.loads(body)["limits"])
