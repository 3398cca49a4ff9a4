# SPDX-License-Identifier: Apache-2.0
"""With every codec, and with images, labels come in the order of the input and equal those of a local run on what was sent."""
import json
import struct
import unittest

import pcd
import png
from harness import BAD_INPUT, EndToEnd

WIDTH, HEIGHT, FOCAL, CENTER_X, CENTER_Y = 160, 120, 150.0, 79.5, 59.5
INTRINSICS = f"{FOCAL},{FOCAL},{CENTER_X},{CENTER_Y}"


def float32(number):
    return struct.unpack("f", struct.pack("f", number))[0]


def wall_with_box():
    """A scene as depths in millimeters, with a hole in every seventh pixel, and colors."""
    depth, colors = [], []
    for row in range(HEIGHT):
        for column in range(WIDTH):
            box = 50 < column < 90 and 40 < row < 80
            depth.append(0 if (row * WIDTH + column) % 7 == 3 else 900 if box else 1200)
            colors.append(0xc81e1e if box else 0x787878)
    return depth, colors


def organized_pcd(depth, colors):
    """The cloud that the images describe, by the formula of RgbdImages in cloud.proto."""
    rows = []
    for i, (units, color) in enumerate(zip(depth, colors)):
        z = units * 0.001 if units else float("nan")
        x, y = (i % WIDTH - CENTER_X) / FOCAL * z, (i // WIDTH - CENTER_Y) / FOCAL * z
        rows.append(f"{float32(x)!r} {float32(y)!r} {float32(z)!r} {color}\n")
    header = pcd.header(len(rows), "x y z rgb", "4 4 4 4", "F F F U", "1 1 1 1", width=WIDTH, height=HEIGHT)
    return header + "".join(rows).encode()


class Codecs(EndToEnd):
    server_flags = ("--enable-draco",)

    def test_remote_labels_are_those_of_a_local_run_on_the_decoded_payload(self):
        info = json.loads(self.run_well("info", "--server", self.server.address, "--json", "-").stdout)
        names = [codec["name"] for codec in info["codecs"]]
        self.assertLessEqual({"planar", "planar-zstd", "strided", "quantised", "pcd", "rgbd"}, set(names))
        scene = self.path("scene.pcd")
        scene.write_bytes(organized_pcd(*wall_with_box()))
        for name in names:
            with self.subTest(codec=name):
                remote, told = self.segment(scene, "--codec", name)
                local, _ = self.segment_locally(scene, "--codec", name)
                self.assertEqual(remote, local)
                self.assertEqual(told["segments"], 2)
                self.assertEqual([label != 0 for label in remote], [depth != 0 for depth in wall_with_box()[0]])

    def test_an_error_bound_can_be_asked_for(self):
        scene = self.synth("--width", "160", "--height", "120")
        fine = self.segment(scene, "--codec", "quantised", "--error-bound", "0.1")[0]
        self.assertEqual(fine, self.segment_locally(scene, "--codec", "quantised", "--error-bound", "0.1")[0])
        coarse = self.segment(scene, "--codec", "quantised", "--error-bound", "10")[0]
        self.assertNotEqual(fine, coarse)


class Images(EndToEnd):
    def setUp(self):
        self.values, self.colors = wall_with_box()
        self.depth, self.rgb = self.path("depth.png"), self.path("color.png")
        self.depth.write_bytes(png.gray16(WIDTH, HEIGHT, self.values))
        self.rgb.write_bytes(png.rgb8(WIDTH, HEIGHT, self.colors))

    def segment_images(self, *flags, where=None):
        output = self.path("images.pcd")
        done = self.run_well("segment", "--depth", self.depth, "--intrinsics", INTRINSICS, *flags, "-o", output, "--json",
                             "-", *(where or ("--server", self.server.address)))
        return pcd.read_labels(output), json.loads(done.stdout)

    def test_a_pair_of_images_is_the_cloud_that_the_pinhole_model_says(self):
        scene = self.path("scene.pcd")
        scene.write_bytes(organized_pcd(self.values, self.colors))
        expected, _ = self.segment_locally(scene)
        remote, told = self.segment_images("--rgb", self.rgb)
        self.assertEqual(remote, expected)
        self.assertEqual(told["segments"], 2)
        self.assertIn("CAMERA", told["view_rule"])
        self.assertEqual(self.segment_images("--rgb", self.rgb, where=("--local",))[0], expected)

    def test_color_may_be_left_out_and_the_scale_be_another(self):
        labels, told = self.segment_images("--depth-scale", "0.0005")
        self.assertEqual(len(labels), WIDTH * HEIGHT)
        self.assertEqual(told["segments"], 2)
        self.assertEqual(labels, self.segment_images("--depth-scale", "0.0005", where=("--local",))[0])

    def test_bad_images_are_named(self):
        broken = self.path("broken.png")
        broken.write_bytes(self.depth.read_bytes()[:-100])
        small = self.path("small.png")
        small.write_bytes(png.rgb8(2, 2, [0, 1, 2, 3]))
        for depth, rgb, words in ((broken, self.rgb, "depth: PNG: "), (self.depth, small, "the colou?r image has 2 x 2"),
                                  (self.rgb, self.rgb, r"gr[ae]y \(0\) with 16 bits"),
                                  (self.depth, __file__, "neither PNG nor JPEG")):
            for where in (("--local",), ("--server", self.server.address)):
                line = self.run_badly(BAD_INPUT, "segment", "--depth", depth, "--rgb", rgb, "--intrinsics", INTRINSICS, *where)
                self.assertRegex(line, words)


if __name__ == "__main__":
    unittest.main()
