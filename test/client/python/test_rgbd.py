# SPDX-License-Identifier: Apache-2.0
"""Images of RGB-D cameras."""
import struct
import unittest
import zlib

import numpy as np

from segserve import Intrinsics, encode_rgbd

CAMERA = Intrinsics(500, 510, 320, 240)
DEPTH = np.arange(12, dtype=np.uint16).reshape(3, 4) * 1000
COLOR = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)


def unpng(content):
    """The rows of a PNG file whose filter is "up"."""
    width, height, bits, kind = struct.unpack(">IIBB", content[16:26])
    length, = struct.unpack(">I", content[33:37])
    rows = np.frombuffer(zlib.decompress(content[41:41 + length]), np.uint8).reshape(height, -1)
    assert (rows[:, 0] == 2).all()
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8), width, bits, kind


class Images(unittest.TestCase):
    def test_are_sent_raw(self):
        payload = encode_rgbd(DEPTH, COLOR, CAMERA)
        depth, color = map(bytes, payload.blocks)
        self.assertEqual(depth, b"P5\n4 3\n65535\n" + DEPTH.astype(">u2").tobytes())
        self.assertEqual(color, b"P6\n4 3\n255\n" + COLOR.tobytes())
        rgbd = payload.header.rgbd
        self.assertEqual((rgbd.fx, rgbd.fy, rgbd.cx, rgbd.cy, rgbd.depth_scale), (500, 510, 320, 240, 0.001))
        self.assertEqual((payload.shape, payload.points), ((3, 4), 12))

    def test_or_as_png(self):
        payload = encode_rgbd(DEPTH, COLOR, CAMERA, images="png")
        depth, *facts = unpng(payload.blocks[0])
        self.assertEqual((depth.tobytes(), facts), (DEPTH.astype(">u2").tobytes(), [4, 16, 0]))
        color, *facts = unpng(payload.blocks[1])
        self.assertEqual((color.tobytes(), facts), (COLOR.tobytes(), [4, 8, 2]))
        self.assertEqual(payload.shape, (3, 4))

    def test_of_floats_are_meters(self):
        depth = DEPTH.astype(np.float64) / 1000
        payload = encode_rgbd(depth, None, np.array([[500, 0, 320], [0, 510, 240], [0, 0, 1]]))
        head, rows = bytes(payload.blocks[0])[:len(b"Pf\n4 3\n-1.0\n")], bytes(
            payload.blocks[0])[len(b"Pf\n4 3\n-1.0\n"):]
        self.assertEqual(head, b"Pf\n4 3\n-1.0\n")
        np.testing.assert_array_equal(np.frombuffer(rows, "<f4").reshape(3, 4)[::-1], depth.astype(np.float32))
        self.assertEqual((payload.header.rgbd.depth_scale, payload.header.rgbd.cy, len(payload.blocks)), (1, 240, 1))

    def test_may_be_files(self):
        png = bytes(encode_rgbd(DEPTH, None, CAMERA, images="png").blocks[0])
        payload = encode_rgbd(png, b"\xff\xd8 a JPEG", CAMERA, color_intrinsics=(1, 2, 3, 4), depth_scale=0.0002)
        self.assertEqual((payload.shape, bytes(payload.blocks[0])), ((3, 4), png))
        self.assertEqual((payload.header.rgbd.color_intrinsics.cy, payload.header.rgbd.depth_scale), (4, 0.0002))
        self.assertEqual(encode_rgbd(b"P5\n# a comment\n7 5 65535\n...", None, CAMERA).shape, (5, 7))
        self.assertIsNone(encode_rgbd(b"something else", None, CAMERA).shape)

    def test_that_are_none_are_refused(self):
        for arguments, error in (((DEPTH[0], None, CAMERA), ValueError), ((DEPTH.astype(int), None, CAMERA), TypeError),
                                 ((DEPTH, COLOR[..., :2], CAMERA), ValueError), ((DEPTH, COLOR.astype(float), CAMERA),
                                                                                 TypeError),
                                 ((DEPTH, None, (1, 2, 3)), ValueError), ((DEPTH, None, (0, 1, 2, 3)), ValueError),
                                 ((DEPTH, None, (np.nan, 1, 2, 3)), ValueError)):
            with self.assertRaises(error):
                encode_rgbd(*arguments)
        with self.assertRaises(ValueError):
            encode_rgbd(DEPTH, None, CAMERA, images="jpeg")


if __name__ == "__main__":
    unittest.main()
