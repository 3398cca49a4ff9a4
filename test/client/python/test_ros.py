# SPDX-License-Identifier: Apache-2.0
"""Messages of ROS 1, as Debian has them, and of ROS 2, by their fields."""
import array
import types
import unittest

import numpy as np

from segserve import result_message, ros
from segserve.encoding import Encoding, rgbd_payload
from segserve.view import View
from test_result import good

try:
    from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField
except ImportError:
    PointCloud2 = None


class Ros2Message:
    """A message as rclpy has it: bytes are an array, numbers have their types, and the matrix of a camera is `k`."""

    def __init__(self, **fields):
        self.header = types.SimpleNamespace(frame_id="camera")
        self.height = self.width = self.point_step = self.row_step = self.step = self.is_bigendian = self.is_dense = 0
        self.name, self.encoding, self.offset, self.datatype, self.count, self.fields = "", "", 0, 0, 0, []
        self.data = array.array("B")
        for name, value in fields.items():
            setattr(self, name, value)


XYZ = np.arange(18, dtype=np.float32).reshape(2, 3, 3)
RGB = np.arange(18, dtype=np.uint8).reshape(2, 3, 3)


def cloud_message(kind, field_kind, order="<", padding=4):
    """2 rows of 3 points: x, y, z, four bytes of nothing, rgb and intensity; rows have some bytes more."""
    points = np.zeros(
        (2, 3), {
            "names": ["x", "y", "z", "rgb", "intensity"],
            "formats": [order + "f4"] * 4 + [order + "u2"],
            "offsets": [0, 4, 8, 16, 20],
            "itemsize": 22
        })
    for axis, name in enumerate("xyz"):
        points[name] = XYZ[..., axis]
    packed = RGB.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], np.uint32)
    points["rgb"] = packed.view(np.float32)
    points["intensity"] = 7
    rows = np.concatenate([points.view(np.uint8).reshape(2, 66), np.zeros((2, padding), np.uint8)], axis=1)
    fields = []
    for name in points.dtype.names:
        entry = field_kind()
        entry.name, entry.offset, entry.count = name, points.dtype.fields[name][1], 1
        entry.datatype = 4 if name == "intensity" else 7
        fields.append(entry)
    message = kind()
    message.height, message.width, message.fields, message.is_bigendian = 2, 3, fields, order == ">"
    message.point_step, message.row_step, message.is_dense = 22, 66 + padding, True
    message.header.frame_id = "camera"
    message.data = rows.tobytes() if PointCloud2 is kind else array.array("B", rows.tobytes())
    return message


def images(kind):
    depth, color = kind(), kind()
    depth.encoding, depth.height, depth.width, depth.step = "16UC1", 2, 3, 8
    depth.data = np.pad(np.arange(6, dtype="<u2").reshape(2, 3), ((0, 0), (0, 1))).tobytes()
    color.encoding, color.height, color.width, color.step = "bgr8", 2, 3, 9
    color.data = RGB[..., ::-1].tobytes()
    return depth, color


class Messages(unittest.TestCase):
    def kinds(self):
        yield Ros2Message, Ros2Message
        if PointCloud2 is not None:
            yield PointCloud2, PointField

    def test_a_point_cloud_goes_out_as_it_is(self):
        for kind, field_kind in self.kinds():
            message = cloud_message(kind, field_kind)
            payload = Encoding(view="camera").payload(message)
            strided = payload.header.strided
            self.assertEqual([(field.name, field.offset, field.datatype) for field in strided.fields],
                             [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("rgb", 16, 7), ("intensity", 20, 4)])
            self.assertEqual((strided.point_step, strided.row_step, payload.shape, payload.points), (22, 70, (2, 3), 6))
            self.assertEqual(bytes(payload.blocks[0]), bytes(message.data))

    def test_a_single_row_needs_no_step(self):
        for kind, field_kind in self.kinds():
            message = cloud_message(kind, field_kind, padding=0)
            message.height, message.width, message.row_step = 1, 6, 0
            np.testing.assert_array_equal(ros.cloud_of(message).xyz, XYZ.reshape(-1, 3))
            payload = Encoding(view="camera").payload(message)
            self.assertEqual((payload.header.strided.row_step, bytes(payload.blocks[0])), (132, bytes(message.data)))

    def test_or_in_another_codec(self):
        for kind, field_kind in self.kinds():
            for order in "<>":
                cloud = ros.cloud_of(cloud_message(kind, field_kind, order))
                np.testing.assert_array_equal(cloud.xyz, XYZ.reshape(-1, 3))
                np.testing.assert_array_equal(cloud.rgb, RGB.reshape(-1, 3))
                self.assertEqual(cloud.shape, (2, 3))
            message = cloud_message(kind, field_kind)
            self.assertEqual(Encoding().payload(message).header.WhichOneof("payload"), "pcd_file")
            self.assertEqual(Encoding(view="camera", codec="planar").payload(message).size, 90)

    def test_labels_go_into_a_field_of_their_own(self):
        labels = result_message.decode(good(), (2, 3), ("labels",))
        for kind, field_kind in self.kinds():
            for order in "<>":
                message = cloud_message(kind, field_kind, order)
                labeled = ros.label_point_cloud2(message, labels)
                self.assertIs(type(labeled), kind)
                points = ros.structured_array(labeled)
                self.assertEqual(points["label"].tolist(), [[1, 1, 1], [2, 2, 0]])
                self.assertEqual(points["intensity"].tolist(), [[7] * 3] * 2)
                np.testing.assert_array_equal(points["y"], XYZ[..., 1])
                self.assertEqual((labeled.point_step, labeled.row_step, labeled.header.frame_id), (26, 78, "camera"))
                self.assertEqual(len(message.fields), 5)
                with self.assertRaisesRegex(ValueError, "already"):
                    ros.label_point_cloud2(labeled, labels)

    def test_what_comes_out_of_ros_1_can_be_serialized(self):
        if PointCloud2 is None:
            self.skipTest("there is no python3-sensor-msgs")
        import io
        labels = result_message.decode(good(), (2, 3), ("labels",))
        for message in (ros.label_point_cloud2(cloud_message(PointCloud2, PointField), labels),
                        ros.label_image(images(Image)[0], labels)):
            buffer = io.BytesIO()
            message.serialize(buffer)
            self.assertEqual(type(message)().deserialize(buffer.getvalue()).data, message.data)

    def test_images_and_their_camera(self):
        kinds = [Ros2Message] + ([Image] if PointCloud2 is not None else [])
        for kind in kinds:
            depth, color = images(kind)
            np.testing.assert_array_equal(ros.image_array(depth), np.arange(6).reshape(2, 3))
            np.testing.assert_array_equal(ros.image_array(color), RGB)
            if kind is Ros2Message:
                camera = types.SimpleNamespace(k=[500, 0, 1, 0, 510, 2, 0, 0, 1])
            else:
                camera = CameraInfo()
                camera.K = [500, 0, 1, 0, 510, 2, 0, 0, 1]
            payload = rgbd_payload(depth, color, camera)
            self.assertEqual((payload.header.rgbd.fx, payload.header.rgbd.cy, payload.shape), (500, 2, (2, 3)))
            labels = ros.label_image(depth, result_message.decode(good(), (2, 3), ("labels",)))
            self.assertEqual((labels.encoding, ros.image_array(labels).tolist()), ("mono16", [[1, 1, 1], [2, 2, 0]]))

    def test_encodings(self):
        for encoding, pixel, expected in (("rgba8", [1, 2, 3, 4], [1, 2, 3]), ("bgra8", [1, 2, 3,
                                                                                         4], [3, 2,
                                                                                              1]), ("mono8", [5], 5)):
            message = Ros2Message(encoding=encoding, height=1, width=1, step=len(pixel), data=bytes(pixel))
            self.assertEqual(ros.image_array(message)[0, 0].tolist(), expected)
        big = Ros2Message(encoding="mono16", height=1, width=1, step=2, data=b"\x01\x02", is_bigendian=1)
        self.assertEqual(ros.image_array(big).tolist(), [[0x102]])
        meters = Ros2Message(encoding="32FC1", height=1, width=1, step=4, data=np.float32(1.5).tobytes())
        self.assertEqual(ros.image_array(meters).tolist(), [[1.5]])

    def test_broken_messages_are_refused(self):
        message = cloud_message(Ros2Message, Ros2Message)
        message.data = message.data[:-30]
        for view in ("camera", None):
            with self.assertRaisesRegex(ValueError, "PointCloud2: "):
                Encoding(view=view).payload(message)
        message = cloud_message(Ros2Message, Ros2Message)
        message.fields[0].offset = 20
        with self.assertRaisesRegex(ValueError, "beyond point_step"):
            Encoding(view="camera").payload(message)
        message.fields[0].datatype = 9
        with self.assertRaisesRegex(ValueError, "unknown type 9"):
            ros.structured_array(message)
        for wrong in ({
                "encoding": "yuv422"
        }, {
                "encoding": "rgb8",
                "height": 2,
                "width": 2,
                "step": 6,
                "data": bytes(11)
        }, {
                "encoding": "rgb8",
                "height": 2,
                "width": 2,
                "step": 5,
                "data": bytes(12)
        }):
            with self.assertRaisesRegex(ValueError, "Image: "):
                ros.image_array(Ros2Message(**wrong))
        with self.assertRaisesRegex(ValueError, "rgb: "):
            Encoding(view=View.camera()).payload(cloud_message(Ros2Message, Ros2Message), RGB)


if __name__ == "__main__":
    unittest.main()
