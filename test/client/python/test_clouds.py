# SPDX-License-Identifier: Apache-2.0
"""Which arrays are clouds, and what is said about those that are none."""
import types
import unittest

import numpy as np

from segserve import as_cloud

XYZ = np.arange(36, dtype=np.float32).reshape(3, 4, 3)
RGB = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)


class Arrays(unittest.TestCase):
    def test_may_be_organized_or_not(self):
        rows = as_cloud(XYZ, RGB)
        self.assertEqual((rows.shape, rows.width, rows.height, rows.xyz.shape), ((3, 4), 4, 3, (12, 3)))
        self.assertEqual(rows.packed_rgb[1], 0x030405)
        flat = as_cloud(XYZ.reshape(-1, 3))
        self.assertEqual((flat.shape, flat.width, flat.height, flat.rgb), ((12,), 12, 1, None))

    def test_may_be_views_of_others(self):
        self.assertEqual(as_cloud(XYZ[::2, ::-1]).xyz.tolist(), XYZ[::2, ::-1].reshape(-1, 3).tolist())

    def test_of_float64_are_float32_unless_they_are_far(self):
        self.assertEqual(as_cloud(np.array([[0.1, np.nan, 512]])).xyz.dtype, np.float32)
        self.assertEqual(as_cloud(np.array([[0.1, np.nan, 512.1]])).xyz.dtype, np.float64)
        self.assertEqual(as_cloud(np.array([[np.inf, -np.inf, 1e-3]])).xyz.dtype, np.float32)

    def test_that_are_no_clouds_are_refused(self):
        for xyz, error in ((XYZ[..., :2], ValueError), (XYZ[0, 0], ValueError), (XYZ[None], ValueError),
                           (XYZ[:0], ValueError), (XYZ.astype(int), TypeError), (np.array("x"),
                                                                                 TypeError), (None, TypeError)):
            with self.subTest(xyz), self.assertRaisesRegex(error, "^xyz: "):
                as_cloud(xyz)

    def test_of_colors_must_fit(self):
        for rgb, error in ((RGB.reshape(-1, 3), ValueError), (RGB[..., :1], ValueError), (RGB.astype(int), TypeError),
                           (RGB.astype(np.float32), ValueError), (RGB.astype(np.float64) - 3, ValueError)):
            with self.subTest(rgb.dtype), self.assertRaisesRegex(error, "^rgb: "):
                as_cloud(XYZ, rgb)

    def test_of_float_colors_are_from_0_to_1(self):
        colors = np.array([[0, 0.5, 1], [np.nan, 0.999, 0.001]])
        self.assertEqual(as_cloud(XYZ[0, :2], colors).rgb.tolist(), [[0, 128, 255], [0, 255, 0]])


class StructuredArrays(unittest.TestCase):
    def test_as_pcl_has_them(self):
        points = np.zeros(2, {
            "names": ["x", "y", "z", "rgb"],
            "formats": ["<f4"] * 4,
            "offsets": [0, 4, 8, 16],
            "itemsize": 32
        })
        points["z"] = [1, 2]
        points["rgb"] = np.array([0x00FF8001, 0xFF010203], np.uint32).view(np.float32)
        cloud = as_cloud(points)
        self.assertEqual(cloud.xyz.tolist(), [[0, 0, 1], [0, 0, 2]])
        self.assertEqual(cloud.rgb.tolist(), [[255, 128, 1], [1, 2, 3]])

    def test_of_big_endian_bytes(self):
        points = np.zeros(1, [("x", ">f4"), ("y", ">f4"), ("z", ">f4"), ("rgba", ">u4")])
        points["x"], points["rgba"] = 2, 0x00010203
        cloud = as_cloud(points)
        self.assertEqual((cloud.xyz.tolist(), cloud.rgb.tolist()), ([[2, 0, 0]], [[1, 2, 3]]))

    def test_with_a_field_for_each_channel(self):
        points = np.zeros((2, 3), [(name, "f8") for name in "xyz"] + [(name, "u1") for name in "rgb"])
        points["g"] = 7
        cloud = as_cloud(points)
        self.assertEqual((cloud.shape, cloud.rgb[0].tolist()), ((2, 3), [0, 7, 0]))

    def test_that_lack_something_are_refused(self):
        for fields, error in (([("x", "f4"), ("y", "f4")], ValueError), ([
            ("x", "i4"), ("y", "f4"), ("z", "f4")
        ], TypeError), ([(name, "f4") for name in "xyz"] + [("rgb", "u2")], TypeError)):
            with self.subTest(fields), self.assertRaises(error):
                as_cloud(np.zeros(3, fields))


class OtherObjects(unittest.TestCase):
    def test_of_open3d(self):
        legacy = types.SimpleNamespace(points=XYZ.reshape(-1, 3).astype(np.float64).tolist(),
                                       colors=np.full((12, 3), 0.2).tolist())
        self.assertEqual(as_cloud(legacy).rgb[0].tolist(), [51, 51, 51])
        legacy.colors = []
        self.assertIsNone(as_cloud(legacy).rgb)
        cloud = as_cloud(legacy)
        self.assertIs(as_cloud(cloud), cloud)
        with self.assertRaisesRegex(ValueError, "rgb: a Cloud brings its own colors"):
            as_cloud(cloud, RGB)
        tensor = types.SimpleNamespace(numpy=lambda: XYZ.reshape(-1, 3))
        self.assertEqual(as_cloud(types.SimpleNamespace(point={"positions": tensor})).xyz.shape, (12, 3))
        with self.assertRaisesRegex(ValueError, "no point"):
            as_cloud(types.SimpleNamespace(points=[]))


if __name__ == "__main__":
    unittest.main()
