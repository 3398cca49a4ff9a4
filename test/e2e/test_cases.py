# SPDX-License-Identifier: Apache-2.0
"""Files as strangers have them: each is read right, and what cannot be used is said. ../shared/cases/README.md describes them."""
import json
import unittest

from harness import DATA, EndToEnd

CASES = DATA.parent / "cases"
TABLE, BOX = (150, 110, 70), (40, 60, 200)

COLORS = ("ply_color_r_g_b.ply", "ply_color_16bit.ply", "ply_color_float_0_1.ply", "pcd_color_float_0_1.pcd",
          "pcd_color_red_green_blue.pcd", "pcd_color_signed_bytes.pcd", "pcd_rgb_signed_with_alpha.pcd",
          "ply_color_capitals.ply", "ply_color_decimals.ply")
TEXT = ("ply_cr_line_ends.ply", "ply_bom_at_data.ply", "pcd_bom.pcd", "pcd_height_0.pcd", "pcd_comment_after_end.pcd")
NOT_ALL_USED = ("ply_long_face_rows.ply", "ply_lines_after_end.ply", "ply_faces_cut_off.ply")


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


if __name__ == "__main__":
    unittest.main()
