# SPDX-License-Identifier: Apache-2.0
"""Bad input gives exit code 2, one clear line and no output file, and the server goes on serving."""
import random
import struct
import unittest

from harness import BAD_INPUT, EndToEnd
import pcd

SQUARE = [(0.005 * (i % 10), 0.005 * (i // 10), 1.0) for i in range(100)]
LIMIT = 20_000


class BadInput(EndToEnd):
    server_flags = ("--max-points", str(LIMIT))

    def ways(self):
        """Every way in which a cloud can be segmented."""
        server = ("--server", self.server.address)
        return {"local": ("--local",), "planar": server, "zstd": (*server, "--zstd"), "pcd": (*server, "--codec", "pcd")}

    def refuse(self, content, *flags, ways=None, saying=""):
        """No way accepts the content; afterward the same server process segments a good scene."""
        scene, output = self.path("bad.pcd"), self.path("out.pcd")
        scene.write_bytes(content)
        for name, way in self.ways().items():
            if ways is not None and name not in ways:
                continue
            with self.subTest(way=name):
                line = self.run_badly(BAD_INPUT, "segment", scene, "-o", output, *way, *flags)
                self.assertIn(saying, line)
                self.assertFalse(output.exists())
        self.assert_serving()

    def assert_serving(self):
        self.assertIsNone(self.server.process.poll())
        good = self.path("good.pcd")
        good.write_bytes(pcd.ascii_file(SQUARE))
        labels, _ = self.segment(good)
        self.assertEqual(labels, [1] * 100)

    def test_an_empty_cloud(self):
        self.refuse(pcd.header(0, width=0, height=0))
        self.refuse(pcd.header(0, data="binary"))

    def test_an_empty_file(self):
        self.refuse(b"")

    def test_no_such_file(self):
        for way in self.ways().values():
            self.assertIn("missing", self.run_badly(BAD_INPUT, "segment", self.path("missing.pcd"), *way))
        self.run_badly(BAD_INPUT, "segment", self.folder, "--local")

    def test_truncated_files(self):
        self.refuse(pcd.binary_file(SQUARE)[:-1])
        self.refuse(pcd.ascii_file(SQUARE)[:-30])
        self.refuse(pcd.header(100)[:-20])

    def test_headers_that_lie(self):
        body = b"\0" * 1200
        self.refuse(pcd.header(4_000_000_000, data="binary") + body)
        self.refuse(pcd.header(100, width=10, height=11, data="binary") + body)
        self.refuse(pcd.header(100, size="4 4 0", data="binary") + body)
        self.refuse(pcd.header(100, count="1 1 -1", data="binary") + body)
        self.refuse(pcd.header(100, fields="x y", data="binary") + body)
        self.refuse(pcd.header(-1, data="binary") + body)
        self.refuse(pcd.header(100, data="zip") + body)

    def test_compressed_sizes_that_lie(self):
        head = pcd.header(100, data="binary_compressed")
        self.refuse(head + struct.pack("<2I", 0xFFFFFFF0, 1200) + b"\0" * 1200)
        self.refuse(head + struct.pack("<2I", 1200, 0xFFFFFFF0) + b"\0" * 1200)
        self.refuse(head + struct.pack("<2I", 40, 1200) + b"\xff" * 40)

    def test_random_bytes_after_a_good_header(self):
        rng = random.Random(4)
        for data in ("ascii", "binary_compressed"):
            self.refuse(pcd.header(100, data=data) + rng.randbytes(1200))

    def test_options_out_of_range(self):
        good = pcd.ascii_file(SQUARE)
        self.refuse(good, "--threshold", "-1", saying="threshold")
        self.refuse(good, "--threshold", "nan", saying="threshold")
        self.refuse(good, "--regions", "0", saying="regions")
        self.refuse(good, "--regions", "3", "--threshold", "0.1", saying="exclude")
        self.refuse(good, "--voxel-resolution", "inf", saying="voxel_resolution")
        self.refuse(good, "--method", "magic", saying="magic")
        self.refuse(good, "--view", "sideways", saying="sideways")
        self.refuse(good, "--view", "world:1,2", saying="world:1,2")
        self.refuse(good, "--view", "world:1,2,nan", saying="nan")

    def test_parts_that_are_none(self):
        good = pcd.ascii_file(SQUARE)
        self.refuse(good, "--crop-min-x", "0.5", "--crop-max-x", "-0.5", saying="crop_max_x")
        self.refuse(good, "--crop-min-z", "nan", saying="crop_min_z")
        self.refuse(good, "--range-min", "2", "--range-max", "1", saying="range_max")
        self.refuse(good, "--view", "world", "--range-max", "1", saying="range_max")
        self.refuse(good, "--support-plane-distance", "-1", saying="support_plane_distance")

    def test_every_wrong_option_is_named_at_once(self):
        self.refuse(pcd.ascii_file(SQUARE), "--lambda", "2", "--color-weight", "-4", saying="lambda")
        self.refuse(pcd.ascii_file(SQUARE), "--lambda", "2", "--color-weight", "-4", saying="color_weight")

    def test_coordinates_beyond_any_grid(self):
        self.refuse(pcd.ascii_file(SQUARE + [(1e20, 0.0, 1.0)] * 20))

    def test_points_behind_the_camera(self):
        for z in (0.0, -1.0):
            self.refuse(pcd.ascii_file(SQUARE + [(0.5, 0.0, z)] * 20), "--view", "camera", saying="z")

    def test_a_cloud_over_the_servers_limit(self):
        points = [(0.001 * i, 0.0, 1.0) for i in range(LIMIT + 1)]
        self.refuse(pcd.binary_file(points), ways=("planar", "zstd", "pcd"), saying=str(LIMIT))

    def test_a_cloud_too_large_for_a_call_meets_the_limits_of_a_stream(self):
        rng = random.Random(5)
        body = rng.randbytes(12 * 900_000)
        self.refuse(pcd.header(900_000, data="binary") + body, "--view", "world",
                    ways=("planar", "zstd", "pcd"), saying=f"{LIMIT}")

    def test_a_ply_that_is_none(self):
        self.refuse(b"ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n",
                    ways=("local", "planar", "zstd"))
        self.refuse(b"ply\nformat ascii 1.0\nend_header\n", ways=("pcd",))


if __name__ == "__main__":
    unittest.main()
