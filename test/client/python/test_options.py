# SPDX-License-Identifier: Apache-2.0
"""Options and outputs by name."""
import unittest

from segserve.options import METHODS, method_name, method_number, numbers_of, options_message, outputs_message
from segserve.v1 import options_pb2


class Options(unittest.TestCase):
    def test_methods_have_the_names_of_the_command_line(self):
        self.assertEqual(method_number("lambda-convex"), options_pb2.METHOD_LAMBDA_CONVEX)
        self.assertEqual([method_name(method_number(name)) for name in METHODS], list(METHODS))
        self.assertEqual((method_name(0), method_name(99)), ("", ""))
        with self.assertRaisesRegex(ValueError, "did you mean 'border'"):
            method_number("boarder")

    def test_are_set_by_name(self):
        message = options_message("border", None, 12, {"voxel_resolution": 0.01, "threads": 2})
        self.assertEqual(numbers_of(message), {"regions": 12, "voxel_resolution": 0.01, "threads": 2})
        self.assertEqual(numbers_of(options_message(None, 0.25, None, None)), {"threshold": 0.25})
        self.assertEqual(options_message(None, None, None, None), options_pb2.SegmentOptions())
        with_preset = options_message(None, None, None, {"preset": "lidar", "threads": 2})
        self.assertEqual((with_preset.preset, numbers_of(with_preset)), (options_pb2.PRESET_LIDAR, {"threads": 2}))

    def test_that_make_no_sense_are_refused(self):
        for arguments, error, message in (
                ((None, 0.2, 3, None), ValueError, "one of the two ways"),
                ((None, 0.2, None, {"regions": 3}), ValueError, "given twice"),
                ((None, None, None, {"regions": 3, "threshold": 0.1}), ValueError, "not both"),
                ((None, None, None, {"voxel_resolutoin": 1}), ValueError, "did you mean 'voxel_resolution'"),
                ((None, None, None, {"method": 1}), ValueError, "there is no 'method'"),
                ((None, None, None, {"preset": "Lidar"}), ValueError, "preset: there is no 'Lidar'"),
                ((None, None, None, {"preset": 4}), ValueError, "preset: there is no '4'"),
                ((None, None, None, {"lambda": "much"}), TypeError, "lambda: 'much' is not a number"),
                ((None, None, None, {"threads": 1.5}), ValueError, "not a whole number"),
                ((None, None, -1, None), ValueError, "not a whole number")):
            with self.subTest(arguments), self.assertRaisesRegex(error, message):
                options_message(*arguments)

    def test_outputs(self):
        message = outputs_message(("labels", "segments"), True)
        self.assertEqual(
            (message.labels, message.supervoxels, message.tree, message.segments, len(message.accepted_compressions)),
            (True, False, False, True, 1))
        self.assertTrue(outputs_message("tree", False).tree)
        with self.assertRaisesRegex(ValueError, "did you mean 'labels'"):
            outputs_message(["label"], False)


if __name__ == "__main__":
    unittest.main()
