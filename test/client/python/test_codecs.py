# SPDX-License-Identifier: Apache-2.0
"""What clouds are encoded to. test/e2e/test_python_client.py has the server decode them."""
import struct
import unittest
from unittest import mock

import numpy as np

import segserve
from segserve import as_cloud, codecs, encode, zstd
from segserve.payload import blocks_of
from segserve.v1 import block_pb2, cloud_pb2

needs_zstd = unittest.skipUnless(zstd.is_there(), "there is no zstandard")
XYZ = np.array([[0, 0, 1], [np.nan, 0, 1], [0.002, -0.002, 1]], np.float32)
RGB = np.array([[0x10, 0x20, 0x30], [255, 255, 255], [0x11, 0x20, 0x33]], np.uint8)


def unquantised(data):
    """Decodes the format by its description."""
    magic, version, flags, _, width, height, finite, *planes, _, step, _ = struct.unpack("<4sHBBIII4Bdd", data[:40])
    assert (magic, version, len(planes)) == (b"SEGQ", 1, 3)
    count, bitmap = width * height, (width * height + 7) // 8 if finite < width * height else 0
    body = zstd.decompress(data[40:], bitmap + finite * (sum(planes) + 3 * (flags & 1)))
    mask = np.unpackbits(np.frombuffer(body[:bitmap], np.uint8),
                         bitorder="little")[:count].astype(bool) if bitmap else np.ones(count, bool)
    rest = np.frombuffer(body[bitmap:], np.uint8).reshape(sum(planes) + 3 * (flags & 1), finite)
    xyz, row = np.full((count, 3), np.nan, np.float32), 0
    for axis in range(3):
        zigzag = sum(rest[row + plane].astype(np.int64) << 8 * plane for plane in range(planes[axis]))
        cells = np.cumsum((zigzag >> 1) ^ -(zigzag & 1))
        xyz[mask, axis] = ((cells + 0.5) * step).astype(np.float32)
        row += planes[axis]
    return xyz, np.cumsum(rest[row:].astype(np.int64), axis=1).T % 256, step


class Codecs(unittest.TestCase):
    def test_planar_has_a_plane_for_each_coordinate(self):
        payload = encode(XYZ, RGB, view="world:1,2,3", codec="planar")
        planes = [np.frombuffer(block, np.float32) for block in payload.blocks[:3]]
        np.testing.assert_array_equal(np.stack(planes, axis=1), XYZ)
        self.assertEqual(bytes(payload.blocks[3]), RGB.tobytes())
        self.assertEqual((payload.size, payload.points, payload.decoded_bytes, payload.shape), (45, 3, 45, (3,)))
        self.assertEqual(payload.header.view.sensor.z, 3)
        self.assertEqual(payload.message().planar.rgb.data, RGB.tobytes())
        self.assertEqual(payload.header.planar.rgb.data, b"")

    def test_the_arrays_may_change_afterwards(self):
        for codec in codecs.CODECS if zstd.is_there() else ("planar", "strided", "pcd"):
            xyz, rgb = XYZ.copy(), RGB.copy()
            payload = encode(xyz, rgb, view="camera", codec=codec)
            before = payload.message().SerializeToString()
            xyz[:], rgb[:] = 7, 7
            self.assertEqual(payload.message().SerializeToString(), before, codec)

    def test_strided_is_the_layout_of_point_cloud2(self):
        strided = encode(XYZ.reshape(1, 3, 3), RGB.reshape(1, 3, 3), view="camera", codec="strided").message().strided
        self.assertEqual([(field.name, field.offset) for field in strided.fields], [("x", 0), ("y", 4), ("z", 8),
                                                                                    ("rgb", 12)])
        self.assertEqual((strided.point_step, strided.row_step, len(strided.data.data)), (16, 48, 48))
        self.assertEqual(struct.unpack("<fffI", strided.data.data[32:]), (*XYZ[2].tolist(), 0x112033))

    def test_pcd_is_a_file(self):
        content = encode(XYZ, RGB, codec="pcd").message().pcd_file.file.data
        head, body = content.split(b"DATA binary\n")
        self.assertIn(b"FIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\n", head)
        self.assertEqual(struct.unpack("<fffI", body[:16]), (0, 0, 1, 0x102030))

    def test_without_a_view_the_server_chooses_it_from_a_file(self):
        self.assertEqual(encode(XYZ).header.WhichOneof("payload"), "pcd_file")
        self.assertFalse(encode(XYZ).header.HasField("view"))
        self.assertEqual(encode(XYZ, view="camera").header.WhichOneof("payload"), "planar")
        with self.assertRaisesRegex(ValueError, "^view: the codec 'planar' needs it"):
            encode(XYZ, codec="planar")

    def test_coordinates_far_from_0_keep_their_digits(self):
        far = np.array([[500_000.123456, 0, 0]])
        self.assertEqual(encode(far, view="world").header.WhichOneof("payload"), "strided")
        self.assertEqual(encode(far, view="world").header.strided.fields[0].datatype, cloud_pb2.POINT_DATATYPE_FLOAT64)
        self.assertIn(b"SIZE 8 8 8\n", bytes(encode(far).blocks[0]))
        for codec in ("planar", "quantised"):
            with self.assertRaisesRegex(ValueError, "too coarse"):
                encode(far, view="world", codec=codec)

    def test_units_and_faults(self):
        self.assertEqual(encode(XYZ, unit="mm").header.unit, cloud_pb2.LENGTH_UNIT_MILLIMETER)
        self.assertEqual(
            segserve.pcd_file(b"x", unit="cm", view="camera").header.unit, cloud_pb2.LENGTH_UNIT_CENTIMETER)
        for wrong, message in (({"unit": "mile"}, "^unit: "), ({"codec": "draco"}, "^codec: there is no"),
                               ({"codec": "rgbd"}, "segment_rgbd"), ({"view": "sideways"}, "^view: "),
                               ({"view": "world:1,2"}, "^view: "), ({"view": "world:1,2,nan"}, "^view: "),
                               ({"view": "camera:1,2,3"}, "^view: ")):
            with self.subTest(wrong), self.assertRaisesRegex(ValueError, message):
                encode(XYZ, **wrong)


@needs_zstd
class Quantised(unittest.TestCase):
    def test_the_example_of_the_format(self):
        data = codecs.quantised_bytes(as_cloud(XYZ, RGB), 0.001)
        self.assertEqual(data[:24], bytes.fromhex("53454751 01000100 03000000 01000000 02000000 01010200"))
        self.assertEqual(zstd.decompress(data[40:], 15), bytes.fromhex("05 0002 0003 e800 0300 1001 2000 3003"))

    def test_keeps_the_bound_the_finite_points_and_the_colors(self):
        rng = np.random.default_rng(1)
        xyz = rng.uniform(-4, 4, (60, 80, 3)).astype(np.float32)
        xyz[rng.random((60, 80)) < 0.3] = np.nan
        rgb = rng.integers(0, 256, (60, 80, 3), np.uint8)
        for bound in (0.0001, 0.001, 0.01):
            decoded, colors, step = unquantised(codecs.quantised_bytes(as_cloud(xyz, rgb), bound))
            finite = np.isfinite(xyz).all(axis=2).reshape(-1)
            self.assertEqual(np.isfinite(decoded).all(axis=1).tolist(), finite.tolist())
            error = np.abs(decoded[finite].astype(np.float64) - xyz.reshape(-1, 3)[finite])
            self.assertLessEqual(error.max(), bound)
            self.assertTrue(bound <= step <= 2 * bound)
            self.assertEqual(colors.tolist(), rgb.reshape(-1, 3)[finite].tolist())

    def test_of_no_finite_point(self):
        decoded, _, _ = unquantised(codecs.quantised_bytes(as_cloud(np.full((9, 3), np.nan, np.float32)), 0.001))
        self.assertTrue(np.isnan(decoded).all())

    def test_bounds_that_cannot_be_kept_are_refused(self):
        for bound in (0.00001, 0.1, np.nan):
            with self.assertRaisesRegex(ValueError, "^error_bound: "):
                encode(XYZ, view="camera", codec="quantised", error_bound=bound)
        with self.assertRaisesRegex(ValueError, "^error_bound: .*float32"):
            encode(XYZ * np.float32(5000), view="camera", codec="quantised", error_bound=0.0001)


class Zstandard(unittest.TestCase):
    def test_without_it_an_error_says_what_is_missing(self):
        with mock.patch.object(zstd, "zstandard", None):
            for codec in ("planar-zstd", "quantised"):
                with self.assertRaisesRegex(ImportError, f"the codec '{codec}' needs the package zstandard"):
                    encode(XYZ, view="camera", codec=codec)
            self.assertEqual(encode(XYZ, view="camera").points, 3)

    @needs_zstd
    def test_compresses_a_block_if_that_makes_it_smaller(self):
        payload = encode(np.ones((1000, 3), np.float32), view="camera", codec="planar-zstd")
        self.assertLess(payload.size, 300)
        self.assertEqual([block.compression for block in blocks_of(payload.header)], [block_pb2.COMPRESSION_ZSTD] * 3)
        noise = np.random.default_rng(1).integers(0, 2**31 - 2**24, (100, 3), np.int32).view(np.float32)
        self.assertEqual(
            encode(noise, view="camera", codec="planar-zstd").header.planar.x.compression, block_pb2.COMPRESSION_NONE)

    @needs_zstd
    def test_a_frame_of_another_size_is_refused(self):
        data = zstd.compress(b"x" * 100)
        self.assertEqual(zstd.decompress(data, 100), b"x" * 100)
        for wrong, size in ((data, 99), (data, 101), (data[:-1], 100), (b"nonsense", 100)):
            with self.assertRaises(ValueError):
                zstd.decompress(wrong, size)


if __name__ == "__main__":
    unittest.main()
