# SPDX-License-Identifier: Apache-2.0
"""The package of client/python gives what segctl gives, for every codec.

PYTHON_CLIENT_DIR is the folder client/python; the package that was built of it is in PYTHONPATH.
"""
import datetime
import json
import os
import pathlib
import subprocess
import types
import unittest

import numpy as np
import segserve

from harness import DATA
import pcd
import png
from python_client import CODECS, PythonClient, arrays

SOURCE = pathlib.Path(os.environ["PYTHON_CLIENT_DIR"])


class SameLabels(PythonClient):
    def test_for_every_codec(self):
        for codec in CODECS:
            with self.subTest(codec):
                expected, summary = self.by_segctl("--codec", codec)
                result = self.client.segment(self.xyz, self.rgb, view="camera", codec=codec)
                self.assertEqual(result.labels.shape, (120, 160))
                self.assert_labels(result.labels, expected)
                self.assertEqual(result.options_hash, summary["options_hash"])
                self.assertEqual((result.labels == 0).any(), True)

    def test_prompts_select_as_select_and_segctl_do(self):
        places = segserve.Prompts([(80, 60)], [(5, 100)])
        for codec in CODECS:
            with self.subTest(codec):
                expected, summary = self.by_segctl("--codec", codec, "--include", "80,60", "--exclude", "5,100")
                result = self.client.segment(self.xyz, self.rgb, view="camera", codec=codec, prompts=places,
                                             outputs=("labels", "supervoxels", "tree", "segments"))
                np.testing.assert_array_equal(result.selection.mask.reshape(-1), expected == 1)
                here = result.select([(80, 60)], [(5, 100)])
                np.testing.assert_array_equal(here.mask, result.selection.mask)
                self.assertEqual((here.candidate, here.thresholds, here.include),
                                 (result.selection.candidate, result.selection.thresholds, result.selection.include))
                np.testing.assert_array_equal(here.candidates.step_nodes, result.selection.candidates.step_nodes)
                self.assertEqual(result.selection.nodes.tolist(), summary["selection"]["picked"]["nodes"])
                stability = [segment["stability"] for segment in self.by_segctl("--codec", codec, "--segments")[1]
                             ["segment_statistics"]]
                self.assertEqual(result.segments["stability"].tolist(), stability)
        with self.client.stream(view="camera") as stream:
            stream.send(self.xyz, self.rgb, prompts=places)
            streamed = stream.next().get().selection
        np.testing.assert_array_equal(streamed.mask, self.client.segment(self.xyz, self.rgb, view="camera",
                                                                         prompts=places).selection.mask)
        with self.assertRaises(segserve.InvalidArgument) as raised:
            self.client.segment(self.xyz, self.rgb, view="camera", prompts=segserve.Prompts([(999, 0)]))
        self.assertEqual([field.field for field in raised.exception.field_violations], ["prompts"])

    def test_with_an_error_bound(self):
        if "quantised" not in CODECS:
            self.skipTest("there is no zstandard")
        expected, _ = self.by_segctl("--codec", "quantised", "--error-bound", "3")
        self.assert_labels(
            self.client.segment(self.xyz, self.rgb, view="camera", codec="quantised", error_bound=0.003).labels,
            expected)

    def test_of_the_file_and_of_arrays_without_a_view(self):
        expected, summary = self.by_segctl()
        result = self.client.segment_file(self.scene)
        self.assertEqual(result.labels.shape, (160 * 120,))
        self.assert_labels(result.labels, expected)
        chosen = self.client.segment(self.xyz, self.rgb)
        self.assert_labels(chosen.labels, expected)
        self.assertEqual((str(chosen.view), chosen.voxels), ("camera", summary["voxels"]))

    def test_without_color_or_organization_and_with_options(self):
        flags = ("--method", "lambda-convex", "--threshold", "0.3", "--voxel-resolution", "0.012", "--view",
                 "world:0,0,-0.5")
        scene = self.path("plain.pcd")
        finite = np.isfinite(self.xyz).all(axis=-1)
        scene.write_bytes(pcd.binary_file(self.xyz[finite].tolist()))
        expected, summary = self.by_segctl(*flags, scene=scene)
        for dtype in (np.float32, np.float64):
            result = self.client.segment(self.xyz[finite].astype(dtype),
                                         view="world:0,0,-0.5",
                                         method="lambda-convex",
                                         threshold=0.3,
                                         options={"voxel_resolution": 0.012})
            self.assert_labels(result.labels, expected)
        self.assertEqual((result.method, result.threshold, result.segment_count),
                         ("lambda-convex", 0.3, summary["segments"]))
        self.assertEqual(result.view, segserve.View.world(0, 0, -0.5))

    def test_of_images(self):
        depth = np.rint(np.nan_to_num(self.xyz[..., 2]) * 1000).astype(np.uint16)
        files = self.path("depth.png"), self.path("color.png")
        files[0].write_bytes(png.gray16(160, 120, depth.reshape(-1).tolist()))
        packed = self.rgb.reshape(-1, 3).astype(int) @ [1 << 16, 1 << 8, 1]
        files[1].write_bytes(png.rgb8(160, 120, packed.tolist()))
        camera = (131.25, 131.25, 79.5, 59.5)
        output = self.path("labels.pcd")
        self.run_well("segment", "--server", self.server.address, "--depth", files[0], "--rgb", files[1], "-q", "-o",
                      output, "--intrinsics", ",".join(map(str, camera)))
        expected = np.array(pcd.read_labels(output), np.uint32)
        for images in ("raw", "png"):
            result = self.client.segment_rgbd(depth, self.rgb, camera, images=images)
            self.assertEqual(result.labels.shape, (120, 160))
            self.assert_labels(result.labels, expected)
        self.assert_labels(self.client.segment_rgbd(*(file.read_bytes() for file in files), camera).labels, expected)
        meters = self.client.segment_rgbd(self.xyz[..., 2], None, camera)
        self.assertEqual(meters.finite_points, result.finite_points)

    def test_of_a_message_of_ros(self):
        expected, _ = self.by_segctl()
        rows = np.zeros((120, 160), {"names": ["rgb", "x", "y", "z"], "formats": ["<u4", "<f4", "<f4", "<f4"],
                                     "offsets": [2, 6, 10, 17], "itemsize": 21})
        for axis, name in enumerate("xyz"):
            rows[name] = self.xyz[..., axis]
        rows["rgb"] = segserve.as_cloud(self.xyz, self.rgb).packed_rgb.reshape(120, 160)
        fields = [
            types.SimpleNamespace(name=name, offset=rows.dtype.fields[name][1], datatype=7, count=1)
            for name in rows.dtype.names
        ]
        message = types.SimpleNamespace(height=120,
                                        width=160,
                                        fields=fields,
                                        point_step=21,
                                        row_step=160 * 21,
                                        is_bigendian=False,
                                        data=rows.tobytes())
        for view in ("camera", None):
            result = self.client.segment(message, view=view)
            self.assertEqual(result.labels.shape, (120, 160))
            self.assert_labels(result.labels, expected)

    def test_of_a_real_scene(self):
        scenes = sorted((DATA / "osd" / "learn").glob("*.pcd"))
        if not scenes:
            self.skipTest("there is no real scene")
        expected, _ = self.by_segctl(scene=scenes[0])
        self.assert_labels(self.client.segment_file(scenes[0]).labels, expected)

    def test_of_a_cloud_too_large_for_a_message(self):
        times = 8 * 2**20 // (self.xyz.size * 5) + 1
        xyz = np.tile(self.xyz.reshape(-1, 3), (times, 1))
        rgb = np.tile(self.rgb.reshape(-1, 3), (times, 1))
        payload = segserve.encode(xyz, rgb, view="camera")
        self.assertGreater(payload.size, 8 * 2**20)
        scene = self.path("large.pcd")
        scene.write_bytes(bytes(segserve.encode(xyz, rgb).blocks[0]))
        expected, _ = self.by_segctl("--view", "camera", scene=scene)
        self.assert_labels(self.client.segment(payload).labels, expected)


class Results(PythonClient):
    def test_cuts_are_those_of_segctl(self):
        result = self.client.segment(self.xyz, self.rgb, view="camera")
        saved = self.path("saved.segres")
        result.save(saved, self.xyz, self.rgb)
        labeled = self.path("cut.pcd")
        for name, value in (("regions", 1), ("regions", 7), ("regions", 60), ("threshold", 0), ("threshold", 0.2),
                            ("threshold", 1)):
            self.run_well("cut", saved, f"--{name}", value, "--cloud", self.scene, "-q", "-o", labeled)
            self.assert_labels(result.cut(**{name: value}), np.array(pcd.read_labels(labeled), np.uint32))
            again = self.client.segment(self.xyz, self.rgb, view="camera", **{name: value})
            self.assert_labels(result.cut(**{name: value}), again.labels.reshape(-1))
        self.assert_labels(result.cut(threshold=result.threshold), result.labels.reshape(-1))

    def test_files_go_both_ways(self):
        theirs = self.path("theirs.segres")
        self.run_well("segment", self.scene, "--server", self.server.address, "--result", theirs, "--segments", "-q")
        loaded = segserve.Result.load(theirs)
        direct = self.client.segment(self.xyz, self.rgb, view="camera", outputs=segserve.OUTPUTS)
        self.assert_labels(loaded.labels, direct.labels.reshape(-1))
        np.testing.assert_array_equal(loaded.segments, direct.segments)
        ours = self.path("ours.segres")
        direct.save(ours, self.xyz, self.rgb)
        first_lines = [path.read_bytes().split(b"\n")[0].split()[-2:] for path in (ours, theirs)]
        self.assertEqual(*first_lines, "the fingerprints differ")
        np.testing.assert_array_equal(segserve.Result.load(ours).segments, direct.segments)
        damaged = bytearray(ours.read_bytes())
        damaged[-5] ^= 1
        ours.write_bytes(damaged)
        with self.assertRaisesRegex(ValueError, "checksum"):
            segserve.Result.load(ours)

    def test_segments_and_summary_are_those_of_segctl(self):
        _, summary = self.by_segctl("--segments")
        result = self.client.segment(self.xyz, self.rgb, view="camera", outputs=("labels", "segments"))
        self.assertIsNone(result.tree)
        self.assertEqual(len(result.segments), summary["segments"])
        for ours, theirs in zip(result.segments, summary["segment_statistics"]):
            self.assertEqual((ours["label"], ours["points"]), (theirs["label"], theirs["points"]))
            for name, value in (("centroid", theirs["centroid"]), ("box_axes", theirs["box"]["axes"]),
                                ("color", theirs["color"]), ("box_center", theirs["box"]["center"]),
                                ("box_half_extents", theirs["box"]["half_extents"]), ("normal", theirs["normal"])):
                np.testing.assert_array_equal(ours[name], np.nan if value is None else value)
        self.assertEqual(result.segments["points"].tolist(), np.bincount(result.labels.reshape(-1))[1:].tolist())
        resolution = summary["resolution"]
        self.assertEqual(result.resolution,
                         (resolution["voxel"], resolution["seed"], resolution["reason"], resolution["noise_depth"]))
        self.assertEqual(
            (result.points, result.finite_points, result.supervoxel_count, result.view_rule, result.server_version),
            (summary["points"], summary["finite"], summary["supervoxels"], "CAMERA as the request says",
             summary["version"]))
        self.assertEqual(result.timings.keys(), summary["timings_ms"].keys() - {"round_trip"})
        self.assertEqual(self.client.info().version, result.server_version)

    def test_what_the_server_says(self):
        info = self.client.info()
        self.assertTrue(self.client.health())
        self.assertIn(info.default_method, info.methods)
        self.assertEqual(set(info.methods), set(segserve.METHODS))
        self.assertGreater(info.limits["max_points"], 0)
        self.assertEqual(info.options["voxel_resolution"].unit, "m")
        with self.assertRaises(segserve.NotFound):
            self.client.health("nothing of the kind")
        with self.assertRaises(segserve.InvalidArgument) as caught:
            self.client.segment(self.xyz, view="camera", options={"voxel_resolution": 100, "normal_weight": -1})
        self.assertEqual(caught.exception.reason, "INVALID_FIELD")
        self.assertEqual(sorted(fault.field for fault in caught.exception.field_violations),
                         ["options.normal_weight", "options.voxel_resolution"])
        with self.assertRaises(segserve.InvalidArgument) as caught:
            self.client.segment(self.xyz - np.float32(100), view="camera")
        self.assertEqual(caught.exception.reason, "INVALID_CLOUD")
        with self.assertRaises(segserve.DeadlineExceeded):
            self.client.segment(self.xyz, view="camera", timeout=0.0005)

    def test_no_server(self):
        with segserve.Client("127.0.0.1:1") as client:
            with self.assertRaisesRegex(segserve.Unavailable,
                                        r"no answer from 127\.0\.0\.1:1: .*is segserve running there\?"):
                client.segment(self.xyz, view="camera")
        with segserve.Client(f"127.0.0.1:1,{self.server.address}") as client:
            for _ in range(3):
                self.assertTrue(client.health())


class OverTime(PythonClient):
    """Objects keep their ids, by calls and by streams, as segctl tells them."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.moving = cls.folder / "moving"
        cls().run_well("synth", "--moving", cls.moving, "--frames", 4, "--width", 160, "--height", 120, "--clutter", 0,
                       "--quiet")
        done = cls().run_well("segment", cls.moving, "--track", "--json", "-", "--server", cls.server.address)
        cls.told = [json.loads(line) for line in done.stdout.splitlines()]
        cls.frames = [(arrays(cls.moving / frame["file"]), frame["time"],
                       np.c_[np.reshape(frame["rotation"], (3, 3)), frame["translation"]])
                      for frame in json.loads((cls.moving / "sequence.json").read_text())["frames"]]

    def check(self, result, told):
        self.assertEqual(result.tracks.ids.tolist(), told["track_ids"])
        self.assertEqual([(event.kind, event.track) for event in result.tracks.events],
                         [(event["kind"], event["track"]) for event in told["track_events"]])
        ids = result.tracks.of_points(result.labels)
        self.assertEqual(ids.shape, (120, 160))
        self.assertEqual(set(np.unique(ids)) - {0}, set(told["track_ids"]) - {0})

    def test_by_calls(self):
        state = b""
        for ((xyz, rgb), seconds, pose), told in zip(self.frames, self.told):
            result = self.client.segment(xyz, rgb, view="camera",
                                         tracking=segserve.Tracking(state, pose=pose, time=seconds))
            self.check(result, told)
            state = result.tracks.state

    def test_by_a_stream(self):
        with self.client.stream(view="camera", tracking=segserve.Tracking(), max_waiting=10) as stream:
            for (xyz, rgb), seconds, pose in self.frames:
                stamp = datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc)
                stream.send(xyz, rgb, stamp=stamp, pose=pose)
            stream.finish()
            results = [outcome.get() for outcome in stream]
        for result, told in zip(results, self.told, strict=True):
            self.check(result, told)

    def test_what_makes_no_sense(self):
        (xyz, rgb), _, _ = self.frames[0]
        with self.assertRaisesRegex(ValueError, "pose: a 4 x 4"):
            segserve.Tracking(pose=np.eye(3))
        with self.assertRaises(segserve.InvalidArgument) as raised:
            self.client.segment(xyz, rgb, view="camera", tracking=segserve.Tracking(b"no state", max_speed=-1))
        self.assertEqual([field.field for field in raised.exception.field_violations],
                         ["tracking.state", "tracking.max_speed"])
        self.assertIsNone(self.client.segment(xyz, rgb, view="camera").tracks)
        with self.client.stream(view="camera") as stream, self.assertRaisesRegex(ValueError, "opened with tracking"):
            stream.send(xyz, rgb, pose=np.eye(4))


class Example(PythonClient):
    def test_the_example_runs(self):
        done = subprocess.run(["/usr/bin/python3", "-B", SOURCE / "example_stream.py", self.server.address, "10"],
                              capture_output=True, text=True, timeout=100)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(done.stdout, r"frame \d+: 2 segments after \d+ ms")
        self.assertEqual(len(done.stdout.splitlines()), 10)


if __name__ == "__main__":
    unittest.main()
