# SPDX-License-Identifier: Apache-2.0
"""What tests of the package of client/python share."""
import numpy as np
import segserve

from harness import EndToEnd

CODECS = [codec for codec in segserve.CODECS if segserve.zstd.is_there() or codec in ("planar", "strided", "pcd")]


def arrays(path):
    """xyz and rgb of an organized PCD file of four columns."""
    content = path.read_bytes()
    head, body = content.split(b"DATA binary\n", 1)
    lines = dict(line.split(" ", 1) for line in head.decode().splitlines() if " " in line)
    fields = lines["FIELDS"].split()
    points = np.frombuffer(body, np.dtype([(name, "<u4" if name in ("rgb", "label") else "<f4") for name in fields]))
    points = points.reshape(int(lines["HEIGHT"]), int(lines["WIDTH"]))
    xyz = np.stack([points[name] for name in "xyz"], axis=-1)
    rgb = np.stack([points["rgb"] >> shift & 255 for shift in (16, 8, 0)], axis=-1).astype(np.uint8)
    return xyz, rgb


class PythonClient(EndToEnd):
    """A scene that was synthesized, with holes, and what segctl says of it."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = cls.folder / "scene.pcd"
        cls().run_well("synth", "-o", cls.scene, "--quiet", "--seed", "3", "--width", "160", "--height", "120")
        cls.xyz, cls.rgb = arrays(cls.scene)
        assert np.isnan(cls.xyz).any(), "the scene has no holes"
        cls.client = segserve.Client(cls.server.address)
        cls.addClassCleanup(cls.client.close)

    def runTest(self):
        """Only so that setUpClass can use our methods."""

    def by_segctl(self, *flags, scene=None):
        labels, summary = self.segment(self.scene if scene is None else scene, *flags)
        return np.array(labels, np.uint32), summary

    def assert_labels(self, found, expected):
        np.testing.assert_array_equal(found.reshape(-1), expected)
        self.assertEqual(found.dtype, np.uint32)
