# SPDX-License-Identifier: Apache-2.0
"""Results as servers and files tell them. Each lie of a server is noticed."""
import pathlib
import tempfile
import unittest
from unittest import mock

import numpy as np

import segserve
from segserve import result, result_file, result_message, zstd
from segserve.v1 import block_pb2, options_pb2, result_pb2

OUTPUTS = ("labels", "supervoxels", "tree", "segments")


def array(message, values, kind="u1"):
    data = np.array(values, f"<{kind}").tobytes()
    message.count, message.bytes_per_value = len(values), int(kind[1])
    message.data.data = data


def good():
    """Six points, of which the last is not finite, in three supervoxels and two segments."""
    message = result_pb2.SegmentationResult()
    summary = message.summary
    summary.points, summary.finite_points, summary.segmented_points = 6, 5, 5
    summary.supervoxels, summary.segments, summary.threshold, summary.method = 3, 2, 0.5, options_pb2.METHOD_BORDER
    summary.view.kind = 1
    summary.timings.total_ms = 7
    summary.warnings.add(reason="TOO_SPARSE", message="there are few points")
    array(message.labels, [1, 1, 1, 2, 2, 0])
    array(message.supervoxels, [1, 2, 2, 3, 3, 0], "u2")
    array(message.tree.leaf_points, [1, 2, 2], "u4")
    array(message.tree.left, [0, 2])
    array(message.tree.right, [1, 3])
    message.tree.weight.data = np.array([0.25, 1]).tobytes()
    message.tree.merged_rows = 1
    for points in (3, 2):
        segment = message.segments.add(points=points)
        segment.centroid.x = points
        for axis in "xyz":
            setattr(segment.box.axes.add(), axis, 1)
    message.segments[0].color.red = 9
    message.segments[1].normal.z = 1
    return message


class Results(unittest.TestCase):
    def test_have_the_shape_of_the_input(self):
        found = result_message.decode(good(), (2, 3), OUTPUTS, "request", "frame")
        self.assertEqual(found.labels.tolist(), [[1, 1, 1], [2, 2, 0]])
        self.assertEqual((found.supervoxels.dtype, found.supervoxels.shape), (np.uint32, (2, 3)))
        self.assertEqual(found.cut(regions=3).tolist(), [[3, 1, 1], [2, 2, 0]])
        self.assertEqual(found.cut(threshold=0.5).tolist(), found.labels.tolist())
        self.assertEqual(found.cut(regions=1).tolist(), [[1, 1, 1], [1, 1, 0]])
        self.assertEqual((found.request_id, found.frame_id, found.method, found.threshold, found.regions),
                         ("request", "frame", "border", 0.5, None))
        self.assertEqual((found.timings["total"], found.warnings[0].reason, found.view.kind),
                         (7, "TOO_SPARSE", "camera"))
        self.assertEqual((found.support_plane, found.placement), (None, None))

    def test_segments_are_a_structured_array(self):
        segments = result_message.decode(good(), None, OUTPUTS).segments
        self.assertEqual(segments.dtype, result.SEGMENT)
        self.assertEqual((segments["label"].tolist(), segments["points"].tolist()), ([1, 2], [3, 2]))
        self.assertEqual(segments["centroid"][1].tolist(), [2, 0, 0])
        self.assertEqual((segments["color"][0].tolist(), segments["normal"][1].tolist()), ([9, 0, 0], [0, 0, 1]))
        self.assertTrue(np.isnan(segments["color"][1]).all() and np.isnan(segments["normal"][0]).all())

    def test_arrays_that_were_not_asked_for_are_none(self):
        message = good()
        for name in ("supervoxels", "tree", "segments"):
            message.ClearField(name)
        found = result_message.decode(message, (6,), ("labels",))
        self.assertEqual((found.supervoxels, found.tree, found.segments), (None, None, None))
        for call in (lambda: found.cut(regions=2), lambda: found.save("/nowhere/at/all"), found.dendrogram):
            with self.assertRaisesRegex(ValueError, "not asked for"):
                call()

    def test_lies_are_noticed(self):
        def lie(change):
            message = good()
            change(message)
            return message

        for what, change in {
                "7 points, but the cloud has 6": lambda m: setattr(m.summary, "points", 7),
                "contradict each other": lambda m: setattr(m.summary, "supervoxels", 6),
                "which view": lambda m: m.summary.ClearField("view"),
                "labels: has 5 values": lambda m: array(m.labels, [1] * 5),
                "labels: holds 3": lambda m: array(m.labels, [3] * 6),
                "labels: has 3 bytes per value": lambda m: setattr(m.labels, "bytes_per_value", 3),
                "labels: has 6 bytes, but must have 12": lambda m: setattr(m.labels, "bytes_per_value", 2),
                "labels: claims 9 bytes": lambda m: setattr(m.labels.data, "decoded_bytes", 9),
                "labels: claims 9 encoded bytes": lambda m: setattr(m.labels.data, "encoded_bytes", 9),
                "labels: compression 9": lambda m: setattr(m.labels.data, "compression", 9),
                "supervoxels: holds 4": lambda m: array(m.supervoxels, [4] * 6),
                "tree.weight: has 8 bytes": lambda m: setattr(m.tree.weight, "data", bytes(8)),
                "the sum is 6": lambda m: array(m.tree.leaf_points, [2, 2, 2]),
                "row 1: a node is merged twice": lambda m: array(m.tree.left, [0, 0]),
                "segments: has 1 entries": lambda m: m.segments.pop(),
                "box.axes": lambda m: m.segments[0].box.axes.pop(),
                "numbers of points": lambda m: setattr(m.segments[1], "points", 4),
                "it lacks labels": lambda m: m.ClearField("labels")}.items():
            with self.subTest(what), self.assertRaisesRegex(segserve.Internal, f"the answer is broken: .*{what}"):
                result_message.decode(lie(change), (6,), OUTPUTS)

    def test_a_result_that_is_too_large_is_not_believed(self):
        message = good()
        message.summary.points = 2**40
        with self.assertRaisesRegex(segserve.Internal, "at most"):
            result_message.decode(message, None, OUTPUTS)

    @unittest.skipUnless(zstd.is_there(), "there is no zstandard")
    def test_may_be_compressed(self):
        message = good()
        block = message.labels.data
        block.decoded_bytes, block.compression, block.data = 6, block_pb2.COMPRESSION_ZSTD, zstd.compress(block.data)
        self.assertEqual(result_message.decode(message, None, OUTPUTS).labels.tolist(), [1, 1, 1, 2, 2, 0])
        block.data = block.data[:-2]
        with self.assertRaisesRegex(segserve.Internal, "labels: "):
            result_message.decode(message, None, OUTPUTS)


class Files(unittest.TestCase):
    def setUp(self):
        self.result = result_message.decode(good(), (2, 3), OUTPUTS)
        self.path = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "file"

    def test_keep_everything(self):
        for points in (None, np.zeros((2, 3, 3), np.float32)):
            self.result.save(self.path, points)
            self.assertTrue(
                self.path.read_bytes().startswith(b"segserve-result 2 " if points is None else b"segserve-result 3 "))
            loaded = segserve.Result.load(self.path)
            for name in ("labels", "supervoxels"):
                self.assertEqual(getattr(loaded, name).tolist(), getattr(self.result, name).reshape(-1).tolist())
            for name in ("leaf_points", "left", "right", "weight", "merged_rows"):
                np.testing.assert_array_equal(getattr(loaded.tree, name), getattr(self.result.tree, name))
            self.assertEqual(loaded.segments.tobytes(), self.result.segments.tobytes())
            self.assertEqual(loaded.summary, self.result.summary)

    def test_need_no_zstandard(self):
        with mock.patch.object(zstd, "zstandard", None):
            self.result.save(self.path)
            self.assertEqual(segserve.Result.load(self.path).labels.tolist(), [1, 1, 1, 2, 2, 0])

    def test_that_are_damaged_are_refused(self):
        content = result_file.encode(self.result)
        line, payload = content.split(b"\n", 1)
        for wrong, message in ((b"# .PCD v0.7", "this is not a result"), (content[:-1], "bytes after its first line"),
                               (content + b"x",
                                "bytes after its first line"), (content.replace(b"result 2",
                                                                                b"result 9"), "another version"),
                               (line, "first line"), (content[:-1] + bytes([content[-1] ^ 1]), "checksum")):
            with self.subTest(message), self.assertRaisesRegex(ValueError, message):
                result_file.decode(wrong)
        foreign = result_pb2.ResultSummary().SerializeToString()
        head = f"segserve-result 2 {len(foreign)} 00000000\n".encode()
        with self.assertRaisesRegex(ValueError, "lacks supervoxels|which view|damaged"):
            result_file.decode(head + foreign)

    def test_fingerprints_do_not_see_what_is_behind_nan(self):
        xyz = np.array([[0, 1, 2], [np.nan, 5, 6], [np.inf, 1, 1]], np.float32)
        other = np.array([[0, 1, 2], [3, np.nan, 6], [1, np.nan, 1]], np.float32)
        prints = [result_file.fingerprint(segserve.as_cloud(points)) for points in (xyz, other, xyz + np.float32(1))]
        self.assertEqual(prints[0], prints[1])
        self.assertNotEqual(prints[0], prints[2])
        self.assertEqual(prints[0][1], 0)


if __name__ == "__main__":
    unittest.main()
