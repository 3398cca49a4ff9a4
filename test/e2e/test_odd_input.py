# SPDX-License-Identifier: Apache-2.0
"""Valid but odd input gives a sensible result, and the same one with and without the server."""
import math
import unittest

from harness import EndToEnd
import pcd

NAN = float("nan")


def square(x0=0.0, y0=0.0, z=1.0, n=10):
    return [(x0 + 0.005 * (i % n), y0 + 0.005 * (i // n), z) for i in range(n * n)]


class OddInput(EndToEnd):
    def labels(self, content, *flags):
        scene = self.path("odd.pcd")
        scene.write_bytes(content)
        labels, told = self.segment_locally(scene, *flags)
        for payload in ("planar", "pcd"):
            self.assertEqual(self.segment(scene, "--codec", payload, *flags)[0], labels)
        self.assertEqual(told["segments"], max(labels))
        return labels

    def test_no_finite_point(self):
        self.assertEqual(self.labels(pcd.ascii_file([(NAN, NAN, NAN)] * 50)), [0] * 50)

    def test_one_point(self):
        self.assertEqual(self.labels(pcd.ascii_file([(0.0, 0.0, 1.0)])), [1])

    def test_all_points_equal(self):
        self.assertEqual(self.labels(pcd.ascii_file([(0.5, 0.5, 2.0)] * 1000)), [1] * 1000)

    def test_a_flat_cloud_of_one_color(self):
        points = square(n=60)
        self.assertEqual(self.labels(pcd.ascii_file(points, [0x336699] * len(points))), [1] * len(points))

    def test_no_color_at_all(self):
        points = square(n=40)
        self.assertEqual(self.labels(pcd.ascii_file(points)), [1] * len(points))

    def test_a_hundred_components(self):
        points = [point for i in range(100) for point in square(x0=1.0 * (i % 10), y0=1.0 * (i // 10), n=5)]
        labels = self.labels(pcd.ascii_file(points))
        self.assertEqual(len(set(labels)), 100)
        for i in range(100):
            self.assertEqual(len(set(labels[25 * i:25 * (i + 1)])), 1)
        self.assertEqual(max(self.labels(pcd.ascii_file(points), "--regions", "3")), 3)

    def test_nan_colors_in_a_float_field(self):
        head = pcd.header(100, "x y z rgb", "4 4 4 4", "F F F F", "1 1 1 1")
        rows = "".join(f"{x} {y} {z} nan\n" for x, y, z in square())
        self.assertEqual(self.labels(head + rows.encode()), [1] * 100)

    def test_some_points_are_not_finite(self):
        points = square()
        points[3] = (NAN, 0.0, 1.0)
        points[7] = (0.0, math.inf, 1.0)
        labels = self.labels(pcd.ascii_file(points))
        self.assertEqual([i for i, label in enumerate(labels) if label == 0], [3, 7])


if __name__ == "__main__":
    unittest.main()
