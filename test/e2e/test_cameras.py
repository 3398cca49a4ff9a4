# SPDX-License-Identifier: Apache-2.0
"""Several cameras see one table: segctl segment --cameras, and the Python client, make one cloud of theirs.

The package of client/python is in PYTHONPATH.
"""
import asyncio
import importlib.util
import json
import math
import os
import unittest

import numpy as np
import segserve

from harness import BAD_INPUT, EndToEnd
import pcd

SIZE = ("--width", 160, "--height", 120, "--objects", 5, "--stacked", 0, "--clutter", 0, "--compact")


def points_of(path):
    """The fields of a binary PCD file whose fields have four bytes, in rows and columns."""
    content = path.read_bytes()
    head, body = content.split(b"DATA binary\n", 1)
    lines = dict(line.split(" ", 1) for line in head.decode().splitlines() if " " in line)
    kinds = [(name, "<u4" if name in ("rgb", "label") else "<f4") for name in lines["FIELDS"].split()]
    return np.frombuffer(body, kinds).reshape(int(lines["HEIGHT"]), int(lines["WIDTH"]))


class Cameras(EndToEnd):
    """A table that two cameras see from opposite sides."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.rig = cls.folder / "rig"
        cls().run_well("synth", "--rig", cls.rig, "--seed", 4, "--quiet", *SIZE)
        cls.scenes = [points_of(cls.rig / f"camera_{i}.pcd") for i in range(2)]

    def runTest(self):
        """Only so that setUpClass can use our methods."""

    def segment_rig(self, *flags, rig=None, name="labeled"):
        """The labels of each camera in rows and columns, and the summary."""
        folder = self.path(name)
        done = self.run_well("segment", "--cameras", (rig or self.rig) / "cameras.json", "--out-dir", folder, "--json", "-",
                             *flags)
        return [points_of(folder / f"camera_{i}.pcd")["label"] for i in range(2)], json.loads(done.stdout)

    def poses(self):
        matrices = []
        for camera in json.loads((self.rig / "cameras.json").read_text())["cameras"]:
            pose = np.eye(4)
            pose[:3, :3] = np.reshape(camera["rotation"], (3, 3))
            pose[:3, 3] = camera["translation"]
            matrices.append(pose)
        return matrices

    def python_cameras(self):
        cameras = []
        for scene, pose in zip(self.scenes, self.poses()):
            xyz = np.stack([scene[axis] for axis in "xyz"], axis=-1)
            rgb = np.stack([scene["rgb"] >> shift & 255 for shift in (16, 8, 0)], axis=-1).astype(np.uint8)
            cameras.append(segserve.Camera(xyz, rgb, pose))
        return cameras


class Segctl(Cameras):
    def test_the_cameras_stand_opposite_each_other(self):
        first, second = (pose[:3, 3] for pose in self.poses())
        np.testing.assert_allclose(first[:2], -second[:2], atol=1e-9)
        self.assertAlmostEqual(first[2], second[2])
        self.assertTrue({1, 20, 30, 40, 50, 60} <= set(self.scenes[0]["label"].flat))

    def test_an_object_that_both_see_is_one_segment(self):
        labels, summary = self.segment_rig("--local")
        self.assertEqual(summary["points"], 2 * 160 * 120)
        common = 0
        for label in (20, 30, 40, 50, 60):
            found = []
            for scene, segments in zip(self.scenes, labels):
                mine = segments[(scene["label"] == label) & (segments > 0)]
                if len(mine) >= 100:
                    numbers, counts = np.unique(mine, return_counts=True)
                    self.assertGreater(counts.max() / len(mine), 0.8, f"object {label}")
                    found.append(numbers[counts.argmax()])
            if len(found) == 2:
                common += 1
                self.assertEqual(found[0], found[1], f"object {label}")
        self.assertGreaterEqual(common, 4)

    def test_a_server_answers_as_this_process_does_for_every_codec(self):
        here, summary = self.segment_rig("--local")
        for codec in ("planar", "planar-zstd", "strided", "pcd"):
            with self.subTest(codec):
                there, remote = self.segment_rig("--server", self.server.address, "--codec", codec, name=codec)
                np.testing.assert_array_equal(there, here)
                self.assertEqual(remote["options_hash"], summary["options_hash"])
        lossy, _ = self.segment_rig("--server", self.server.address, "--codec", "quantised", name="lossy")
        np.testing.assert_array_equal(
            lossy, self.segment_rig("--local", "--codec", "quantised", name="lossy-here")[0])

    def test_the_whole_cloud_is_written_in_the_shared_frame(self):
        merged = self.path("merged.pcd")
        self.run_well("segment", "--cameras", self.rig / "cameras.json", "--local", "-o", merged, "--picture",
                      self.path("merged.png"), "--result", self.path("merged.result"), "--quiet")
        points = points_of(merged).reshape(2, 120, 160)
        labels, _ = self.segment_rig("--local")
        np.testing.assert_array_equal(points["label"], labels)
        table = points["z"][np.stack([scene["label"] for scene in self.scenes]) == 1]
        self.assertLess(abs(np.median(table)), 0.01, "the top of the table is at z = 0")
        cut = json.loads(self.run_well("cut", self.path("merged.result"), "--regions", 4, "--json", "-").stdout)
        self.assertEqual(cut["segments"], 4)

    def test_an_object_is_picked_in_all_cameras(self):
        object_points = [scene["label"] == 20 for scene in self.scenes]
        row, column = np.argwhere(object_points[0])[object_points[0].sum() // 2]
        scene = self.scenes[0][row, column]
        position = self.poses()[0] @ (scene["x"], scene["y"], scene["z"], 1)
        labels, _ = self.segment_rig("--local", "--include", ",".join(map(str, position[:3])))
        for mine, picked in zip(object_points, labels):
            self.assertGreater((picked[mine] == 1).mean(), 0.7)

    def test_poses_in_another_unit_of_the_files(self):
        """The files may be in millimeters; poses stay in meters."""
        rig = self.path("millimeters")
        rig.mkdir()
        for i in range(2):
            content = (self.rig / f"camera_{i}.pcd").read_bytes()
            head, _ = content.split(b"DATA binary\n", 1)
            points = self.scenes[i].copy()
            for axis in "xyz":
                points[axis] *= 1000
            (rig / f"camera_{i}.pcd").write_bytes(head + b"DATA binary\n" + points.tobytes())
        (rig / "cameras.json").write_text((self.rig / "cameras.json").read_text())
        labeled = self.path("labeled-millimeters")
        self.run_well("segment", "--cameras", rig / "cameras.json", "--local", "--unit", "mm", "--out-dir", labeled,
                      "--quiet")
        labels = [pcd.read_labels(labeled / f"camera_{i}.pcd") for i in range(2)]
        expected, _ = self.segment_rig("--local")
        self.assertGreater((np.array(labels) == np.reshape(expected, (2, -1))).mean(), 0.99)

    def test_wrong_files_are_named(self):
        good = json.loads((self.rig / "cameras.json").read_text())
        file = self.rig / "wrong.json"

        def refused(change, *flags):
            cameras = json.loads(json.dumps(good))
            change(cameras["cameras"])
            file.write_text(json.dumps(cameras))
            return self.run_badly(BAD_INPUT, "segment", "--cameras", file, "--local", *flags)

        def scaled(cameras):
            cameras[1]["rotation"][0] += 0.5

        def mirrored(cameras):
            cameras[0]["rotation"] = [-1, 0, 0, 0, 1, 0, 0, 0, 1]

        self.assertIn("camera 1: the pose has a rotation that is not orthonormal", refused(scaled))
        self.assertIn("camera 0: the pose has a rotation that is left-handed", refused(mirrored))
        self.assertIn("camera 1: it has no \"file\"", refused(lambda cameras: cameras[1].pop("file")))
        for said, change in (
                ('"translation" must be a list of 3 numbers, and is missing', lambda camera: camera.pop("translation")),
                ('"rotation" must be a list of 9 numbers, and has 8 elements', lambda camera: camera["rotation"].pop()),
                ('"rotation" must be a list of 9 numbers, and has null', lambda camera: camera["rotation"].insert(0, None) or camera["rotation"].pop()),
                ('it has a member "rotatoin", but may only have file, rotation, translation',
                 lambda camera: camera.update(rotatoin=[]))):
            self.assertIn(f"camera 1: {said}", refused(lambda cameras: change(cameras[1])))
        self.assertIn("it has 65 cameras, but at most 64", refused(lambda cameras: cameras.extend([cameras[0]] * 63)))
        os.mkfifo(self.rig / "pipe.pcd")
        self.assertIn("pipe.pcd: it is no regular file", refused(lambda cameras: cameras[0].update(file="pipe.pcd")))
        self.assertIn("no_such.pcd", refused(lambda cameras: cameras[0].update(file="no_such.pcd")))
        self.assertIn("two cameras have files of the name camera_0",
                      refused(lambda cameras: cameras[1].update(file="camera_0.pcd")))
        self.assertIn("its list \"cameras\" is empty", refused(lambda cameras: cameras.clear()))
        self.assertIn("WORLD view that does not say", refused(lambda cameras: None, "--view", "world"))
        for text, said in (("{", "line 1, column 2"), ("", "line 1, column 1"), ('{"cameras": [1e999]}', "1e999"),
                           ('{"cameras": []} []', "column 17"), ("[]", "it is no JSON object"), ("{}", 'no list "cameras"'),
                           ('{"cameras": [{"file": "a.pcd", "file": "b.pcd"}]}', 'the member "file" twice'),
                           ('{"cameras": [], "cameras": []}', 'the member "cameras" twice')):
            file.write_text(text)
            self.assertRegex(self.run_badly(BAD_INPUT, "segment", "--cameras", file, "--local"), f"wrong.json: .*{said}")

    def test_flags_that_do_not_go_together_are_refused(self):
        rig = self.rig / "cameras.json"
        for flags in ((self.rig / "camera_0.pcd",), ("--track",), ("--parallel", 2, "--out-dir", self.path("x"))):
            with self.subTest(flags):
                self.assertIn("--cameras", self.run_badly(BAD_INPUT, "segment", "--cameras", rig, "--local", *flags))
        self.assertIn("camera_0.pcd would be overwritten by its own output",
                      self.run_badly(BAD_INPUT, "segment", "--cameras", rig, "--local", "--out-dir", self.rig))
        self.assertIn("--rig", self.run_badly(BAD_INPUT, "synth", "--rig", self.path("rig"), "-o", self.path("x.pcd")))
        self.assertIn("from 1 to 16", self.run_badly(BAD_INPUT, "synth", "--rig", self.path("rig"), "--cameras", 17))


class Python(Cameras):
    def setUp(self):
        self.client = segserve.Client(self.server.address)
        self.addCleanup(self.client.close)

    def test_labels_are_those_of_segctl(self):
        expected, _ = self.segment_rig("--local")
        result = self.client.segment_cameras(self.python_cameras())
        labels = result.by_camera()
        self.assertEqual([part.shape for part in labels], [(120, 160)] * 2)
        np.testing.assert_array_equal(labels, expected)
        self.assertEqual([camera.points for camera in result.view.cameras], [160 * 120] * 2)
        np.testing.assert_allclose(result.view.cameras[0].sensor, self.poses()[0][:3, 3], rtol=1e-6)
        cut = result.by_camera(result.cut(regions=3))
        self.assertEqual(set(np.unique(cut)) - {0}, {1, 2, 3})

    def test_streams_and_asyncio_give_the_same(self):
        expected = self.client.segment_cameras(self.python_cameras()).labels
        merged = segserve.merge_cameras(self.python_cameras())
        with self.client.stream() as stream:
            stream.send(merged.cloud, view=merged.view)
            result = merged.restore(stream.next().get())
        np.testing.assert_array_equal(result.labels, expected)
        self.assertEqual(result.by_camera()[1].shape, (120, 160))

        async def call():
            async with segserve.aio.Client(self.server.address) as client:
                return await client.segment_cameras(self.python_cameras())

        np.testing.assert_array_equal(asyncio.run(call()).labels, expected)

    @unittest.skipUnless(importlib.util.find_spec("segserve._local"), "segserve.local was not built")
    def test_this_process_gives_the_same(self):
        local = importlib.import_module("segserve.local")
        expected = self.client.segment_cameras(self.python_cameras())
        here = local.segment_cameras(self.python_cameras())
        np.testing.assert_array_equal(here.by_camera(), expected.by_camera())

    def test_a_server_refuses_numbers_that_do_not_add_up(self):
        cameras = (segserve.CameraPoints(2, (0, 0, 1)), segserve.CameraPoints(2, (0, 0, -1)))
        xyz = np.ones((5, 3), np.float32)
        for codec in ("planar", "strided", "pcd"):
            with self.subTest(codec), self.assertRaises(segserve.InvalidArgument) as raised:
                self.client.segment(xyz, view=segserve.View("world", cameras=cameras), codec=codec)
            self.assertEqual([field.field for field in raised.exception.field_violations], ["cloud.view.cameras"])
            self.assertIn("4 points together, but the cloud has 5", str(raised.exception))

    def test_a_saved_result_knows_its_cameras(self):
        path = self.path("result")
        result = self.client.segment_cameras(self.python_cameras())
        result.save(path)
        again = segserve.Result.load(path).by_camera()
        np.testing.assert_array_equal([part.reshape(120, 160) for part in again], result.by_camera())


class Merging(unittest.TestCase):
    """What segserve.merge_cameras does by itself."""

    POSE = [[0, -1, 0, 10], [1, 0, 0, 20], [0, 0, 1, 30], [0, 0, 0, 1]]

    def test_moves_points_and_sensors(self):
        xyz = np.array([[1, 2, 3], [0, 0, 0], [math.nan, 1, 1]], np.float32)
        merged = segserve.merge_cameras([
            segserve.Camera(xyz, pose=self.POSE),
            segserve.Camera(xyz[None, :2], view="world:0,0,5")
        ])
        np.testing.assert_array_equal(merged.cloud.xyz[0], [8, 21, 33])
        self.assertTrue(np.isnan(merged.cloud.xyz[1:3]).all())
        np.testing.assert_array_equal(merged.cloud.xyz[3:], xyz[:2])
        self.assertEqual(merged.shapes, ((3,), (1, 2)))
        self.assertEqual(merged.view.cameras,
                         (segserve.CameraPoints(3, (10, 20, 30)), segserve.CameraPoints(2, (0, 0, 5))))

    def test_names_the_camera_that_is_wrong(self):
        xyz = np.ones((2, 3), np.float32)
        good = segserve.Camera(xyz)
        mirror = np.diag([-1.0, 1, 1, 1])
        for cameras, text in (([], "there is none"), ([good] * 65, "there are 65, but at most 64"),
                              ([good, segserve.Camera(xyz, view="world")], "camera 1: view: "),
                              ([segserve.Camera(xyz, pose=np.eye(3))], r"camera 0: pose: the shape is \(3, 3\)"),
                              ([segserve.Camera(xyz, pose=2 * np.eye(4))], "camera 0: pose: the matrix must be"),
                              ([good, segserve.Camera(xyz, pose=np.diag([2.0, 1, 1, 1]))], "camera 1: .* orthonormal"),
                              ([segserve.Camera(xyz, pose=mirror)], "camera 0: .* mirror image"),
                              ([good, segserve.Camera(xyz, np.zeros((2, 3), np.uint8))], "camera 1: either all"),
                              ([segserve.Camera(xyz[:, :2])], "camera 0: xyz: the shape")):
            with self.subTest(text), self.assertRaisesRegex(ValueError, text):
                segserve.merge_cameras(cameras)


if __name__ == "__main__":
    unittest.main()
