# SPDX-License-Identifier: Apache-2.0
"""The package of client/js gives what segctl gives, for every codec, and loses no frame when servers stop.

JS_PACKAGE is the folder of the package that was built of client/js.
"""
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import tempfile
import threading
import unittest

from certificates import Authority
from harness import DATA, EndToEnd, SEGCTL, Server
import pcd
import png

PACKAGE = pathlib.Path(os.environ["JS_PACKAGE"])
SCRIPT = pathlib.Path(__file__).resolve().parent / "clients" / "js_client.mjs"
WIDTH, HEIGHT = 160, 120
CAMERA = {"fx": 131.25, "fy": 131.25, "cx": 79.5, "cy": 59.5}


def node(*arguments, **options):
    # gRPC gives the address as a name to TLS, of which Node warns if it is an IP address.
    return subprocess.Popen(["node", "--no-deprecation", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


class JavaScriptClient(EndToEnd):
    """A scene that was synthesized, with holes, and what segctl says of it."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = cls.folder / "scene.pcd"
        cls().run_well("synth", "-o", cls.scene, "--quiet", "--seed", "3", "--width", WIDTH, "--height", HEIGHT)
        cls.x, cls.y, cls.z, cls.colors = pcd.read_points(cls.scene)
        assert any(value != value for value in cls.z), "the scene has no holes"
        points = [value for point in zip(cls.x, cls.y, cls.z) for value in point]
        (cls.folder / "xyz.f32").write_bytes(struct.pack(f"<{len(points)}f", *points))
        (cls.folder / "rgb.u8").write_bytes(b"".join(color.to_bytes(4, "big")[1:] for color in cls.colors))
        (cls.folder / "shape").write_text(f"{WIDTH} {HEIGHT}")

    def runTest(self):
        """Only so that setUpClass can use our methods."""

    def begin(self, task, options=None, address=None):
        process = node(SCRIPT, PACKAGE, task, address or self.server.address, self.folder, json.dumps(options or {}))
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def do(self, task, options=None, address=None):
        """What the client prints."""
        process = self.begin(task, options, address)
        output, error = process.communicate(timeout=120)
        self.assertEqual((process.returncode, error), (0, ""))
        return [json.loads(line) for line in output.splitlines()]

    def labels(self, name):
        content = (self.folder / f"{name}.u32").read_bytes()
        return list(struct.unpack(f"<{len(content) // 4}I", content))

    def assert_labels(self, name, expected):
        self.assertTrue(self.labels(name) == list(expected), f"the labels of {name} differ")

    def by_segctl(self, *flags, scene=None):
        return self.segment(self.scene if scene is None else scene, *flags)


class SameLabels(JavaScriptClient):
    def test_for_every_codec(self):
        codecs = ("planar", "planar-zstd", "strided", "strided-zstd", "pcd", "quantised")
        told = self.do("segment", {"calls": {codec: {"view": "camera", "codec": codec} for codec in codecs}})
        for codec, result in zip(codecs, told, strict=True):
            with self.subTest(codec):
                expected, summary = self.by_segctl("--codec", codec)
                self.assert_labels(codec, expected)
                self.assertEqual(result["optionsHash"], summary["options_hash"])
                self.assertEqual((result["segmentCount"], result["method"]), (summary["segments"], summary["method"]))

    def test_with_an_error_bound(self):
        expected, _ = self.by_segctl("--codec", "quantised", "--error-bound", "3")
        self.do("segment", {"calls": {"bound": {"view": "camera", "codec": "quantised", "errorBound": 0.003}}})
        self.assert_labels("bound", expected)

    def test_of_the_file_and_of_arrays_without_a_view(self):
        expected, summary = self.by_segctl()
        told = self.do("segment", {"calls": {"file": {"file": str(self.scene)}, "arrays": {}}})
        for result in told:
            self.assert_labels(result["name"], expected)
            self.assertEqual((result["view"]["kind"], result["voxels"]), ("camera", summary["voxels"]))

    def test_without_color_or_organization_and_with_options(self):
        flags = ("--method", "lambda-convex", "--threshold", "0.3", "--voxel-resolution", "0.012", "--view", "world:0,0,-0.5")
        scene = self.path("plain.pcd")
        scene.write_bytes(pcd.binary_file([point for point in zip(self.x, self.y, self.z) if point[2] == point[2]]))
        expected, summary = self.by_segctl(*flags, scene=scene)
        call = {"view": "world:0,0,-0.5", "method": "lambda-convex", "threshold": 0.3, "options": {"voxelResolution": 0.012}}
        told = self.do("segment", {"calls": {kind: call | {"plain": kind} for kind in ("float", "double")}})
        for result in told:
            self.assert_labels(result["name"], expected)
            self.assertEqual((result["method"], result["threshold"], result["segmentCount"]),
                             ("lambda-convex", 0.3, summary["segments"]))
            self.assertEqual(result["view"], {"kind": "world", "sensor": [0, 0, -0.5]})

    def test_of_images(self):
        depth = [0 if value != value else math.floor(value * 1000 + 0.5) for value in self.z]  # as Math.round
        (self.folder / "depth.png").write_bytes(png.gray16(WIDTH, HEIGHT, depth))
        (self.folder / "color.png").write_bytes(png.rgb8(WIDTH, HEIGHT, [color & 0xffffff for color in self.colors]))
        output = self.path("labels.pcd")
        self.run_well("segment", "--server", self.server.address, "--depth", self.folder / "depth.png", "--rgb",
                      self.folder / "color.png", "-q", "-o", output, "--intrinsics", ",".join(map(str, CAMERA.values())))
        self.do("segment", {"calls": {kind: {"images": kind, "intrinsics": CAMERA} for kind in ("files", "pixels")}})
        for kind in ("files", "pixels"):
            self.assert_labels(kind, pcd.read_labels(output))

    def test_of_a_real_scene(self):
        scenes = sorted((DATA / "osd" / "learn").glob("*.pcd"))
        if not scenes:
            self.skipTest("there is no real scene")
        expected, _ = self.by_segctl(scene=scenes[0])
        result, = self.do("segment", {"calls": {"real": {"file": str(scenes[0])}}})
        self.assert_labels("real", expected)


class Results(JavaScriptClient):
    CUTS = {"one": {"regions": 1}, "seven": {"regions": 7}, "sixty": {"regions": 60}, "finest": {"threshold": 0},
            "middle": {"threshold": 0.2}, "coarsest": {"threshold": 1}}

    def test_cuts_and_picks_are_those_of_segctl(self):
        saved, labeled = self.path("saved.segres"), self.path("labeled.pcd")
        labels, _ = self.by_segctl("--result", saved)
        objects = [labels.index(label) for label in (1, 2)]
        picks = {"object": {"include": objects[1:]}, "pair": {"include": objects, "larger": 1},
                 "part": {"include": objects[1:], "exclude": objects[:1], "larger": -2}}
        told = self.do("cut", {"cuts": self.CUTS, "picks": picks})
        for name, cut in self.CUTS.items():
            (flag, value), = cut.items()
            self.run_well("cut", saved, f"--{flag}", value, "--cloud", self.scene, "-q", "-o", labeled)
            self.assert_labels(name, pcd.read_labels(labeled))
            self.assert_labels(f"{name}-again", pcd.read_labels(labeled))
        for name, places in picks.items():
            expected = self.picked(saved, labeled, places)
            self.assert_labels(name, pcd.read_labels(labeled))
            ours = next(pick for pick in told if pick["name"] == name)
            self.assertEqual(ours["candidate"], expected["candidate"])
            self.assertEqual([(candidate["nodes"], candidate["points"], candidate["thresholds"]) for candidate in ours["candidates"]],
                             [(candidate["nodes"], candidate["points"], candidate["thresholds"]) for candidate in expected["candidates"]])

    def picked(self, saved, labeled, places):
        """What segctl picks by indices of points."""
        flags = [flag for side in ("include", "exclude") for point in places.get(side, ())
                 for flag in (f"--{side}", f"{point % WIDTH},{point // WIDTH}")]
        steps = places.get("larger", 0)
        flags += ["--larger", steps] if steps > 0 else ["--smaller", -steps]
        return json.loads(self.run_well("pick", saved, "--cloud", self.scene, "-q", "-o", labeled, "--json", "-", *flags).stdout)

    def test_prompts_select_what_segctl_picks(self):
        saved, labeled = self.path("saved.segres"), self.path("labeled.pcd")
        labels, _ = self.by_segctl("--result", saved)
        on, beside = labels.index(2), labels.index(1)
        expected = self.picked(saved, labeled, {"include": [on], "exclude": [beside], "larger": -1})
        pixels = {"include": [[on % WIDTH, on // WIDTH]], "exclude": [[beside % WIDTH, beside // WIDTH]], "larger": -1}
        positions = {side: [[self.x[point], self.y[point], self.z[point]]] for side, point in (("include", on), ("exclude", beside))}
        told = self.do("segment", {"calls": {
            codec: {"view": "camera", "codec": codec, "outputs": ["labels", "segments"], "prompts": prompts}
            for codec, prompts in (("planar", pixels), ("strided", positions | {"larger": -1}), ("pcd", pixels))}})
        for result in told:
            with self.subTest(result["name"]):
                self.assert_labels(f"{result['name']}-selected", pcd.read_labels(labeled))
                selection = result["selection"]
                self.assertEqual((selection["candidate"], selection["thresholds"], selection["include"][0]["point"]),
                                 (expected["candidate"], expected["picked"]["thresholds"], on))
                self.assertEqual([candidate["nodes"] for candidate in selection["candidates"]],
                                 [candidate["nodes"] for candidate in expected["candidates"]])
                self.assertEqual(selection["segment"]["points"], expected["picked"]["points"])
        outcomes = self.do("stream", {"frames": 2, "each": {"prompts": pixels}})
        self.assertEqual([outcome["selected"] for outcome in outcomes], [expected["picked"]["points"]] * 2)

    def test_segments_and_summary_are_those_of_segctl(self):
        _, summary = self.by_segctl("--segments")
        result, = self.do("segment", {"calls": {"all": {"view": "camera", "outputs": ["labels", "segments"]}}})
        self.assertEqual(len(result["segments"]), summary["segments"])
        for ours, theirs in zip(result["segments"], summary["segment_statistics"]):
            self.assertEqual((ours["label"], ours["points"], ours["centroid"], ours["color"], ours.get("normal")),
                             (theirs["label"], theirs["points"], theirs["centroid"], theirs["color"], theirs["normal"]))
            self.assertEqual((ours["thresholds"], ours["stability"]), (theirs["thresholds"], theirs["stability"]))
            self.assertEqual((ours["box"]["center"], ours["box"]["axes"], ours["box"]["halfExtents"]),
                             (theirs["box"]["center"], theirs["box"]["axes"], theirs["box"]["half_extents"]))
        self.assertEqual((result["points"], result["finitePoints"], result["supervoxelCount"], result["viewRule"], result["serverVersion"]),
                         (summary["points"], summary["finite"], summary["supervoxels"], "CAMERA as the request says",
                          summary["version"]))
        stages = summary["timings_ms"].keys() - {"round_trip"}
        self.assertEqual(result["timingsMs"].keys(), stages | {"tracking"})  # segctl leaves it out without --track
        self.assertEqual(result["timingsMs"]["tracking"], 0)
        self.assertEqual([result["resolution"][name] for name in ("voxel", "seed", "reason")],
                         [summary["resolution"][name] for name in ("voxel", "seed", "reason")])

    def test_what_the_server_says(self):
        info, = self.do("info")
        self.assertTrue(info["healthy"])
        self.assertEqual(set(info["methods"]), set(info["methodNames"]))
        self.assertIn(info["defaultMethod"], info["methods"])
        self.assertEqual(info["options"]["voxelResolution"]["unit"], "m")
        self.assertGreater(info["limits"]["maxPoints"], 0)

    def test_errors(self):
        fields, cloud, late, service = self.do("errors", {"calls": [
            {"view": "camera", "options": {"voxelResolution": 100, "normalWeight": -1}},
            {"view": "camera", "options": {"voxelResolution": 0.01}, "unit": "ft", "threshold": 2},
            {"view": "camera", "timeoutMs": 0.5},
            {"service": "nothing of the kind"}]})
        self.assertEqual((fields["code"], fields["reason"]), ("INVALID_ARGUMENT", "INVALID_FIELD"))
        self.assertEqual(sorted(fields["fields"]), ["options.normal_weight", "options.voxel_resolution"])
        self.assertEqual(cloud["fields"], ["options.threshold"])
        self.assertEqual((late["code"], service["code"]), ("DEADLINE_EXCEEDED", "NOT_FOUND"))
        nobody, = self.do("errors", {"calls": [{"view": "camera"}]}, "127.0.0.1:1")
        self.assertEqual(nobody["code"], "UNAVAILABLE")
        self.assertRegex(nobody["message"], r"no answer from 127\.0\.0\.1:1: connect ECONNREFUSED .*; is segserve running there\?")
        self.do("info", address=f"127.0.0.1:1,{self.server.address}")


class Streams(JavaScriptClient):
    """Two servers of their own, one of which stops while frames are under way."""

    FRAMES = 24

    def setUp(self):
        self.expected, _ = self.by_segctl()
        self.serve()

    def serve(self, *flags):
        self.pair = [Server(self.folder, *flags) for _ in range(2)]
        for server in self.pair:
            self.addCleanup(server.close)
        self.addresses = ",".join(server.address for server in self.pair)

    def run_through(self, stop):
        """Sends frames while the server that has them stops; all come back, the last ones from the other."""
        process = self.begin("stream", {"frames": self.FRAMES}, self.addresses)
        outcomes = []
        for line in process.stdout:
            outcomes.append(json.loads(line))
            if len(outcomes) == 5:
                stop(next(server for server in self.pair if server.address == outcomes[-1]["address"]))
        self.assertEqual((process.wait(timeout=60), process.stderr.read()), (0, ""))
        self.assertEqual([(outcome["sequence"], outcome["kind"]) for outcome in outcomes],
                         [(number, "RESULT") for number in range(1, self.FRAMES + 1)])
        for number in range(1, self.FRAMES + 1):
            self.assert_labels(f"frame-{number}", self.expected)
        self.assertEqual(len({outcome["address"] for outcome in outcomes}), 2)
        return max(outcome["attempts"] for outcome in outcomes)

    def test_kill_loses_no_frame(self):
        self.assertGreater(self.run_through(lambda server: server.close()), 1)

    def test_drain_loses_no_frame(self):
        thread = []

        def drain(server):
            thread.append(threading.Thread(target=server.terminate))
            thread[0].start()

        # A frame whose header the server read after SIGTERM is sent again, elsewhere.
        self.assertLessEqual(self.run_through(drain), 2)
        thread[0].join()

    def test_old_streams_move_and_send_no_frame_twice(self):
        self.serve("--max-stream-age", "0.3")
        outcomes = self.do("stream", {"frames": 10_000, "seconds": 1.5}, self.addresses)
        self.assertEqual([outcome["sequence"] for outcome in outcomes], list(range(1, len(outcomes) + 1)))
        self.assertEqual({(outcome["kind"], outcome["attempts"]) for outcome in outcomes}, {("RESULT", 1)})
        self.assertEqual({outcome["address"] for outcome in outcomes}, set(self.addresses.split(",")))
        self.assert_labels("frame-1", self.expected)

    def test_a_server_that_is_full_is_waited_for(self):
        self.serve("--workers", "1", "--queue", "1")
        processes = [self.begin("stream", {"frames": 8, "seconds": 60, "rules": {"maxInFlight": 4}}, self.addresses) for _ in range(3)]
        for process in processes:
            output, error = process.communicate(timeout=120)
            self.assertEqual((process.returncode, error), (0, ""))
            self.assertEqual([json.loads(line)["kind"] for line in output.splitlines()], ["RESULT"] * 8)

    def test_other_codecs_options_and_outcomes(self):
        for codec in ("planar", "quantised", "pcd"):
            first, second, third, cancelled = sorted(
                self.do("outcomes", {"rules": {"codec": codec, "method": "lambda"}}), key=lambda outcome: outcome["sequence"])
            expected, _ = self.by_segctl("--codec", codec, "--method", "lambda")
            self.assert_labels("first", expected)
            self.assertEqual((first["requestId"], first["frameId"], first["hasTree"]), ("a", "camera", False))
            self.assertEqual((second["segments"], second["hasTree"]), (5, True))
            self.assertEqual((third["kind"], third["reason"], third["fields"]), ("FAILED", "INVALID_FIELD", ["options.voxel_resolution"]))
            self.assertEqual(cancelled["kind"], "CANCELLED")


class ThroughTls(JavaScriptClient):
    """A server that asks for certificates, with those of an authority of the test."""

    @classmethod
    def setUpClass(cls):
        certificates = pathlib.Path(tempfile.mkdtemp(prefix="segserve-e2e-tls-"))
        cls.addClassCleanup(shutil.rmtree, certificates)
        cls.authority, cls.stranger = Authority(certificates, "authority"), Authority(certificates, "stranger")
        certificate, key = cls.authority.sign("server")
        cls.ca = cls.authority.certificate
        cls.server_flags = ("--tls-cert", str(certificate), "--tls-key", str(key), "--tls-client-ca", str(cls.ca))
        super().setUpClass()

    @staticmethod
    def tls(ca, signed=None):
        names = {} if signed is None else dict(zip(("cert", "key"), map(str, signed)))
        return {"tls": {"ca": str(ca)} | names}

    def test_calls_and_streams(self):
        expected, _ = self.segment_locally(self.scene)
        client = self.tls(self.ca, self.authority.sign("robot"))
        self.do("segment", {"client": client, "calls": {"secure": {"view": "camera"}}})
        self.assert_labels("secure", expected)
        outcomes = self.do("stream", {"client": client, "frames": 3})
        self.assertEqual([outcome["kind"] for outcome in outcomes], ["RESULT"] * 3)
        self.assert_labels("frame-3", expected)

    def test_why_a_connection_fails_is_said_at_once(self):
        for client, message in (({}, "the server speaks TLS"), (self.tls(self.ca), "it asks for a certificate"),
                                (self.tls(self.stranger.certificate), "is not believed"),
                                (self.tls(self.ca, self.stranger.sign("robot")), "does not believe the client's")):
            with self.subTest(message):
                error, = self.do("errors", {"client": client | {"waitForServer": True},
                                            "calls": [{"service": "", "options": {"timeoutMs": 60_000}}]})
                self.assertEqual(error["name"], "TlsError")
                self.assertIn(message, error["message"])
                outcome, = self.do("stream", {"client": client, "frames": 1})
                self.assertEqual(outcome["kind"], "FAILED")
                self.assertIn(message, outcome["error"])


class Tokens(JavaScriptClient):
    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-e2e-tokens-"))
        cls.addClassCleanup(shutil.rmtree, folder)
        cls.token = folder / "robot.token"
        subprocess.run([SEGCTL, "token", "robot", "--output", cls.token, "--tokens", folder / "tokens.toml"], check=True,
                       capture_output=True)
        cls.server_flags = ("--tokens", str(folder / "tokens.toml"))
        super().setUpClass()

    def test_are_sent_and_asked_for(self):
        expected, _ = self.segment_locally(self.scene)
        for client in ({"tokenFile": str(self.token)}, {"token": self.token.read_text().strip()}):
            self.do("segment", {"client": client, "calls": {"known": {"view": "camera"}}})
            self.assert_labels("known", expected)
            outcomes = self.do("stream", {"client": client, "frames": 2})
            self.assertEqual([outcome["kind"] for outcome in outcomes], ["RESULT"] * 2)
        for client, reason in (({}, "TOKEN_MISSING"), ({"token": "wrong"}, "TOKEN_INVALID")):
            error, = self.do("errors", {"client": client, "calls": [{"view": "camera"}]})
            self.assertEqual((error["code"], error["reason"]), ("UNAUTHENTICATED", reason))
            outcome, = self.do("stream", {"client": client, "frames": 1})
            self.assertEqual(outcome["kind"], "FAILED")


if __name__ == "__main__":
    unittest.main()
