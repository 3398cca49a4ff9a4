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


def tiff(width, height, bits, kind, pixels):
    """A TIFF of one strip; `kind` is 1 for unsigned integers and 3 for floats."""
    tags = [(256, width), (257, height), (258, bits), (259, 1), (262, 1), (273, 8), (277, 1), (278, height),
            (279, width * height * bits // 8), (339, kind)]
    entries = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in tags)
    return b"II*\0" + struct.pack("<I", 8 + len(pixels)) + pixels + struct.pack("<H", len(tags)) + entries + b"\0\0\0\0"


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

    def labels_of(self, name, content, *flags):
        """The labels of the scene whose depth is in another file, which are the same here and in a server."""
        self.depth = self.path(name)
        self.depth.write_bytes(content)
        labels, _ = self.segment_images("--rgb", self.rgb, *flags)
        self.assertEqual(labels, self.segment_images("--rgb", self.rgb, *flags, where=("--local",))[0])
        return labels

    def test_depth_of_every_kind_gives_the_same(self):
        expected, told = self.segment_images("--rgb", self.rgb)
        self.assertEqual(told["warnings"], [])
        count = len(self.values)
        big, little = struct.pack(f">{count}H", *self.values), struct.pack(f"<{count}H", *self.values)
        rows = [self.values[row * WIDTH:(row + 1) * WIDTH] for row in range(HEIGHT)]
        floats = [value * 0.001 for row in reversed(rows) for value in row]
        size = f"{WIDTH} {HEIGHT}\n".encode()
        self.assertEqual(self.labels_of("d.pgm", b"P5\n" + size + b"65535\n" + big), expected)
        text = " ".join(map(str, self.values)).encode()
        self.assertEqual(self.labels_of("text.pgm", b"P2\n# a camera\n" + size + b"1200\n" + text), expected)
        self.assertEqual(self.labels_of("d.tif", tiff(WIDTH, HEIGHT, 16, 1, little)), expected)
        self.assertEqual(self.labels_of("d.png", self.png_depth(), "--depth-unit", "mm"), expected)
        meters = [value * 0.001 if value else float("nan") for value in self.values]
        from_floats = self.labels_of("d.pfm", b"Pf\n" + size + b"-1\n" + struct.pack(f"<{count}f", *floats))
        self.assertEqual(from_floats, self.labels_of("f.tif", tiff(WIDTH, HEIGHT, 32, 3, struct.pack(f"<{count}f", *meters))))
        self.assertEqual([label != 0 for label in from_floats], [value != 0 for value in self.values])
        in_units = [float(value) for value in self.values]
        self.assertEqual(self.labels_of("mm.tif", tiff(WIDTH, HEIGHT, 32, 3, struct.pack(f"<{count}f", *in_units)),
                                        "--depth-unit", "mm"), expected)

    def png_depth(self):
        return png.gray16(WIDTH, HEIGHT, self.values)

    def test_color_may_have_another_resolution(self):
        expected, _ = self.segment_images("--rgb", self.rgb, "--method", "color")
        doubled = [self.colors[row // 2 * WIDTH + column // 2] for row in range(2 * HEIGHT) for column in range(2 * WIDTH)]
        self.rgb.write_bytes(png.rgb8(2 * WIDTH, 2 * HEIGHT, doubled))
        self.assertEqual(self.segment_images("--rgb", self.rgb, "--method", "color")[0], expected)
        # This is the same image within a wider one, as its intrinsics say.
        margin = 40
        wide = [0 if not margin <= column < margin + WIDTH else self.colors[row * WIDTH + column - margin]
                for row in range(HEIGHT) for column in range(WIDTH + 2 * margin)]
        self.rgb.write_bytes(png.rgb8(WIDTH + 2 * margin, HEIGHT, wide))
        intrinsics = f"{FOCAL},{FOCAL},{CENTER_X + margin},{CENTER_Y}"
        self.assertEqual(self.segment_images("--rgb", self.rgb, "--method", "color", "--rgb-intrinsics", intrinsics)[0],
                         expected)
        _, told = self.segment_images("--rgb", self.rgb, "--rgb-intrinsics", f"{FOCAL},{FOCAL},{CENTER_X - 5},{CENTER_Y}")
        self.assertEqual([warning["reason"] for warning in told["warnings"]], ["COLOR_MISSING"])

    def test_bad_images_are_named(self):
        broken, small, cut = self.path("broken.png"), self.path("small.png"), self.path("cut.tif")
        broken.write_bytes(self.depth.read_bytes()[:-100])
        small.write_bytes(png.rgb8(2, 2, [0, 1, 2, 3]))
        cut.write_bytes(tiff(WIDTH, HEIGHT, 16, 1, b"12"))
        for depth, rgb, words in ((broken, self.rgb, f"{broken}: depth: PNG: "), (cut, self.rgb, f"{cut}: TIFF: "),
                                  (self.depth, small, f"{small}: color: it has 2 x 2 pixels"),
                                  (self.rgb, self.rgb, f"{self.rgb}: depth: PNG: it is a color image"),
                                  (self.depth, __file__, f"{__file__}: color: the bytes are neither PNG nor JPEG nor PPM")):
            for where in (("--local",), ("--server", self.server.address)):
                with self.subTest(words=words, where=where):
                    line = self.run_badly(BAD_INPUT, "segment", "--depth", depth, "--rgb", rgb, "--intrinsics", INTRINSICS,
                                          *where)
                    self.assertIn(words, line)

    def test_flags_that_are_wrong(self):
        for words, *flags in (("5000 units a meter are 0.0002", "--depth-scale", "5000"),
                              ("--depth-unit", "--depth-unit", "inch"),
                              ("does not go with", "--depth-unit", "mm", "--depth-scale", "0.001"),
                              ("--rgb-intrinsics needs --rgb", "--rgb-intrinsics", INTRINSICS),
                              ("--rgb-intrinsics: fx is 0", "--rgb", self.rgb, "--rgb-intrinsics", "0,1,1,1"),
                              ("--rgb-intrinsics 1,2: must be", "--rgb", self.rgb, "--rgb-intrinsics", "1,2")):
            with self.subTest(flags=flags):
                line = self.run_badly(BAD_INPUT, "segment", "--depth", self.depth, "--intrinsics", INTRINSICS, "--local", *flags)
                self.assertIn(words, line)


if __name__ == "__main__":
    unittest.main()
