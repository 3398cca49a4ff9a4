# SPDX-License-Identifier: Apache-2.0
"""Files as strangers have them: each is read right, and what cannot be used is said. ../shared/cases/README.md describes them."""
import json
import struct
import unittest

from harness import DATA, EndToEnd

CASES = DATA.parent / "cases"
TABLE, BOX = (150, 110, 70), (40, 60, 200)

COLORS = ("ply_color_r_g_b.ply", "ply_color_16bit.ply", "ply_color_float_0_1.ply", "pcd_color_float_0_1.pcd",
          "pcd_color_red_green_blue.pcd", "pcd_color_signed_bytes.pcd", "pcd_rgb_signed_with_alpha.pcd",
          "ply_color_capitals.ply", "ply_color_decimals.ply")
TEXT = ("ply_cr_line_ends.ply", "ply_bom_at_data.ply", "pcd_bom.pcd", "pcd_height_0.pcd", "pcd_comment_after_end.pcd")
NOT_ALL_USED = ("ply_long_face_rows.ply", "ply_lines_after_end.ply", "ply_faces_cut_off.ply")


def positions(path):
    """The coordinates of a binary PLY file whose vertices are 577 rows that begin with three doubles."""
    body = path.read_bytes().split(b"end_header\n", 1)[1]
    size = len(body) // 577
    return [struct.unpack_from("<3d", body, row * size) for row in range(577)]


@unittest.skipUnless(CASES.is_dir(), "there are no cases of strangers' files")
class Cases(EndToEnd):
    def told(self, name):
        done = self.run_well("segment", CASES / name, "--local", "--segments", "--view", "world", "-o", self.path("o.pcd"),
                             "--json", "-")
        return json.loads(done.stdout)

    def expect_table_and_box(self, name):
        told = self.told(name)
        self.assertEqual(told["segment_points"], [388, 189])
        for segment, color in zip(told["segment_statistics"], (TABLE, BOX)):
            for actual, expected in zip(segment["color"], color):
                self.assertAlmostEqual(actual, expected, delta=1)
        return told

    def test_colors_of_every_kind_are_read(self):
        for name in COLORS:
            with self.subTest(name):
                self.assertEqual(self.expect_table_and_box(name)["warnings"], [])

    def test_text_of_every_kind_is_read(self):
        for name in TEXT:
            with self.subTest(name):
                self.assertEqual(self.expect_table_and_box(name)["warnings"], [])

    def test_what_is_not_used_is_said(self):
        for name in NOT_ALL_USED:
            with self.subTest(name):
                warnings = self.expect_table_and_box(name)["warnings"]
                self.assertEqual([warning["reason"] for warning in warnings], ["ROWS_NOT_USED"])

    def test_nan_in_the_spelling_of_microsoft(self):
        told = self.told("pcd_qnan.pcd")
        self.assertEqual((told["points"], told["finite"], told["segments"]), (577, 512, 2))

    def tell(self, name, *flags):
        return json.loads(self.run_well("segment", CASES / name, "--local", "--segments", *flags, "--json", "-").stdout)

    def test_units_are_told_or_missed(self):
        for unit in ("mm", "auto"):
            told = self.tell("ply_millimetres.ply", "--unit", unit)
            self.assertEqual(told["segment_points"], [388, 189])
            self.assertEqual([w["reason"] for w in told["warnings"]], [] if unit == "mm" else ["UNIT_GUESSED"])
            box = told["segment_statistics"][0]["box"]
            self.assertGreater(max(box["half_extents"]), 50, "results are in the unit of the file")
            self.assertEqual(self.tell("ply_integer_millimetres.ply", "--unit", unit)["segments"], 2)
        for name in ("ply_millimetres.ply", "ply_integer_millimetres.ply"):
            [warning] = self.tell(name)["warnings"]
            self.assertEqual(warning["reason"], "TOO_SPARSE")
            self.assertIn("unit", warning["message"])

    def test_places_far_away_come_back(self):
        out = self.path("utm.ply")
        told = self.tell("ply_utm_double.ply", "-o", out)
        self.assertEqual(told["segment_points"], [388, 189])
        centroid = told["segment_statistics"][0]["centroid"]
        self.assertAlmostEqual(centroid[0], 389425.08, delta=0.1)
        self.assertAlmostEqual(centroid[1], 5819321.06, delta=0.1)
        self.assertEqual(positions(out), positions(CASES / "ply_utm_double.ply"))
        again = json.loads(self.run_well("segment", out, "--local", "--json", "-").stdout)
        self.assertEqual(again["segment_points"], [388, 189])
        crop = self.tell("ply_utm_double.ply", "--crop-min-x", "389425.05")
        self.assertTrue(0 < crop["segmented"] < 577, "the crop box is in the coordinates of the file")

    def test_the_sensor_follows_from_the_points(self):
        for name, view, points in (("pcd_origin_inside.pcd", "world", [388, 189]),
                                   ("pcd_organised_openni_viewpoint.pcd", "camera", [1958, 594]),
                                   ("pcd_organised_zeros.pcd", "camera", [1958, 594])):
            with self.subTest(name):
                told = self.tell(name)
                self.assertEqual((told["view"], told["segment_points"]), (view, points))
        told = self.tell("pcd_organised_zeros.pcd")
        self.assertEqual((told["points"], told["finite"]), (3072, 2552))
        self.assertEqual([w["reason"] for w in told["warnings"]], ["POINTS_NOT_USED"])

    def test_sweeps_of_a_lidar_are_seen_from_the_origin(self):
        for name in ("pcd_lidar_organised.pcd", "pcd_lidar_sweep.pcd"):
            with self.subTest(name):
                told = self.tell(name)
                self.assertEqual(told["view"], "world:0,0,0")
                self.assertIn("LiDAR", told["view_rule"])
                self.assertEqual((told["resolution"]["reason"], told["warnings"]), ("spacing", []))
                self.assertTrue(5 <= told["segments"] <= 16, told["segments"])
                [warning] = self.tell(name, "--voxel-resolution", "0.0075")["warnings"]
                self.assertRegex(warning["message"], "at 0[.][0-9]+ m a voxel would hold")

    def test_a_cloud_without_a_sensor_stays_so(self):
        first = self.tell("ply_color_r_g_b.ply", "-o", self.path("saved.pcd"))
        again = json.loads(self.run_well("segment", self.path("saved.pcd"), "--local", "--json", "-").stdout)
        self.assertEqual((again["view"], again["segment_points"]), (first["view"], first["segment_points"]))

    def test_the_server_says_the_same(self):
        for name, flags in (("ply_utm_double.ply", ()), ("pcd_organised_zeros.pcd", ()),
                            ("pcd_organised_zeros.pcd", ("--codec", "pcd")), ("pcd_lidar_sweep.pcd", ("--codec", "pcd")),
                            ("ply_millimetres.ply", ("--unit", "mm"))):
            with self.subTest(name):
                here = self.tell(name, *flags)
                there = json.loads(self.run_well("segment", CASES / name, "--server", self.server.address, "--segments",
                                                 *flags, "--json", "-").stdout)
                for key in ("segment_points", "segment_statistics", "view", "view_rule", "warnings", "placement", "finite"):
                    self.assertEqual(there[key], here[key], (name, flags, key))

    def test_info_tells_what_is_in_every_file(self):
        for path in sorted([*CASES.glob("*.ply"), *CASES.glob("*.pcd")]):
            with self.subTest(path.name):
                info = json.loads(self.run_well("info", path, "--json", "-").stdout)
                self.assertEqual(info["format"], path.suffix[1:].upper())
                self.assertTrue(info["points"] >= info["finite"] > 0)
                self.assertTrue(info["view_rule"])
                self.assertGreater(info["spacing"], 0)
                self.assertEqual(info["unit"]["guess"], "mm" if "millimetres" in path.name else "m")
                self.assertIn(path.name, self.run_well("info", path).stdout.decode())

    def images_told(self, *flags):
        """What a local run tells of images; a server tells the same."""
        local, remote = (json.loads(self.run_well("segment", *flags, *where, "--json", "-").stdout)
                         for where in (("--local",), ("--server", self.server.address)))
        for key in ("segment_points", "finite", "warnings"):
            self.assertEqual(local[key], remote[key])
        return local

    def test_cameras_of_few_pixels_and_coarse_depth_do_not_shatter(self):
        for name, intrinsics, points in (("rgbd_low_resolution", "131,131,79.5,59.5", [16712, 2488]),
                                         ("rgbd_kinect1_floor", "262.5,262.5,159.5,119.5", [52480])):
            with self.subTest(name):
                told = self.images_told("--depth", CASES / f"{name}.depth.png", "--intrinsics", intrinsics)
                self.assertEqual(len(told["segment_points"]), len(points))
                for ours, right in zip(told["segment_points"], points):
                    self.assertAlmostEqual(ours, right, delta=0.02 * right)

    def test_a_resolution_is_a_number_or_auto(self):
        for wrong in ("-1", "nan", "Auto", "0"):
            self.run_badly(2, "segment", CASES / "pcd_bom.pcd", "--local", "-o", self.path("o.pcd"), "--voxel-resolution", wrong)
        told = self.tell("pcd_bom.pcd", "--voxel-resolution", "auto", "--seed-resolution", "auto")
        self.assertEqual(told["segment_points"], [388, 189])

    def test_65535_is_no_depth(self):
        told = self.images_told("--depth", CASES / "rgbd_invalid_65535.depth.png", "--intrinsics", "150,150,59.5,44.5")
        box, floor = 1081, 7775  # by voxels of 7.5 mm; those that fit 120 x 90 pixels are larger
        self.assertEqual(len(told["segment_points"]), 2)
        self.assertEqual(sum(told["segment_points"]), floor + box)
        self.assertAlmostEqual(told["segment_points"][1], box, delta=0.02 * box)
        self.assertEqual(told["finite"], 7775 + 1081)
        self.assertEqual([warning["reason"] for warning in told["warnings"]], ["POINTS_NOT_USED"])
        self.assertIn("65535", told["warnings"][0]["message"])

    def test_a_jpeg_with_stray_bytes_is_used(self):
        told = self.images_told("--depth", CASES / "rgbd_low_resolution.depth.png", "--intrinsics", "131,131,79.5,59.5",
                                "--rgb", CASES / "rgbd_extraneous_bytes.color.jpg", "--voxel-resolution", "0.012")
        self.assertEqual(told["segments"], 2)
        self.assertEqual([warning["reason"] for warning in told["warnings"]], ["IMAGE_DAMAGED"])
        self.assertIn("all pixels are there", told["warnings"][0]["message"])


if __name__ == "__main__":
    unittest.main()
