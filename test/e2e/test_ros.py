# SPDX-License-Identifier: Apache-2.0
"""The node of ROS 1 for real: a roscore, PointCloud2 in, labeled PointCloud2, detections and markers out.

ROS_PACKAGE is the folder of the package segserve_ros, if it was built.
"""
import json
import os
import pathlib
import queue
import shutil
import signal
import socket
import subprocess
import time
import unittest

import numpy as np

from harness import EndToEnd

PACKAGE = pathlib.Path(os.environ.get("ROS_PACKAGE", ""))
RUNS = "ROS_PACKAGE" in os.environ and shutil.which("roscore") is not None
if RUNS:
    try:
        import rosgraph
        import rospy
        from sensor_msgs.msg import PointCloud2, PointField
        from visualization_msgs.msg import Marker, MarkerArray
    except ImportError:
        RUNS = False


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def arrays(path):
    """The points of a binary PCD file whose fields have four bytes, in rows and columns."""
    head, body = path.read_bytes().split(b"DATA binary\n", 1)
    lines = dict(line.split(" ", 1) for line in head.decode().splitlines() if " " in line)
    kinds = [(name, "<u4" if name in ("rgb", "label") else "<f4") for name in lines["FIELDS"].split()]
    return np.frombuffer(body, kinds).reshape(int(lines["HEIGHT"]), int(lines["WIDTH"]))


@unittest.skipUnless(RUNS, "there is no ROS 1 here: deploy/install-packages ros")
class Ros(EndToEnd):
    """A roscore, and a topic for each way out of the node."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        port = free_port()
        cls.environment = os.environ | {
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1", "ROS_HOME": str(cls.folder / "ros"),
            "ROS_PACKAGE_PATH": f"{PACKAGE.parent}:/usr/share", "PYTHONWARNINGS": "ignore"
        }
        os.environ.update({name: cls.environment[name] for name in ("ROS_MASTER_URI", "ROS_IP", "ROS_HOME")})
        cls.start("roscore", "-p", str(port), log="roscore.log")
        deadline = time.monotonic() + 60
        while not rosgraph.is_master_online():
            assert time.monotonic() < deadline, (cls.folder / "roscore.log").read_text()
            time.sleep(0.1)
        rospy.init_node("test", anonymous=True, disable_signals=True)
        cls.addClassCleanup(rospy.signal_shutdown, "the test is over")
        cls.scene = cls.folder / "scene.pcd"
        cls().run_well("synth", "-o", cls.scene, "--quiet", "--seed", "3", "--width", "160", "--height", "120")
        cls.points = arrays(cls.scene)

    def runTest(self):
        """Only so that setUpClass can use our methods."""

    @classmethod
    def start(cls, *command, log):
        """Starts a program that ends with the class, in a process group of its own."""
        with open(cls.folder / log, "wb") as output:
            process = subprocess.Popen(command, env=cls.environment, stdout=output, stderr=subprocess.STDOUT,
                                       start_new_session=True)
        cls.addClassCleanup(cls.stop, process)
        return process

    @staticmethod
    def stop(process):
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    def listen(self, topic, kind):
        """The messages of a topic."""
        messages = queue.Queue()
        subscriber = rospy.Subscriber(topic, kind, messages.put, queue_size=100)
        self.addCleanup(subscriber.unregister)
        return messages

    def connected(self, topic):
        """A publisher that has a listener."""
        publisher = rospy.Publisher(topic, PointCloud2, queue_size=100)
        self.addCleanup(publisher.unregister)
        self.wait_for(lambda: publisher.get_num_connections() > 0)
        return publisher

    def send_until_all_have_one(self, publisher, *topics):
        """A node sees who listens to it a moment after they began, and segments nothing before."""
        deadline = time.monotonic() + 60
        while any(topic.empty() for topic in topics):
            self.assertLess(time.monotonic(), deadline, "no message came")
            publisher.publish(self.message(1))
            time.sleep(0.3)

    def message(self, seconds):
        points = self.points
        message = PointCloud2(height=points.shape[0], width=points.shape[1], is_dense=False)
        message.header.frame_id = "camera_color_optical_frame"
        message.header.stamp = rospy.Time(seconds, 7)
        message.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(("x", "y", "z", "rgb"))]
        message.point_step, message.row_step = 16, 16 * points.shape[1]
        message.data = np.stack([points[name].view("<u4") for name in ("x", "y", "z", "rgb")], axis=-1).tobytes()
        return message

    def launch(self, topic, *arguments):
        """The launch file, whose node is then ready."""
        return self.start("roslaunch", "--wait", "segserve_ros", "segserve.launch", f"points:={topic}",
                          f"address:={self.server.address}", *arguments, log=f"{topic.strip('/')}.log")

    def node(self, *arguments, **environment):
        """The node by itself, to its end."""
        return subprocess.run([PACKAGE / "segserve_node", *arguments], env=self.environment | environment, timeout=60,
                              capture_output=True, text=True, check=False)

    def test_labels_detections_and_markers_come_out(self):
        process = self.launch("/points", "time_to_live:=0")
        self.addCleanup(self.stop, process)
        labeled = self.listen("/segserve/labeled", PointCloud2)
        detections = self.listen("/segserve/detections", MarkerArray)
        markers = self.listen("/segserve/markers", MarkerArray)
        publisher = self.connected("/points")
        self.send_until_all_have_one(publisher, labeled, detections, markers)
        cloud = labeled.get()

        expected, summary = self.segment(self.scene, "--segments")
        self.assertEqual((cloud.width, cloud.height), (160, 120))
        self.assertEqual((cloud.header.frame_id, cloud.header.stamp), ("camera_color_optical_frame", rospy.Time(1, 7)))
        self.assertEqual([field.name for field in cloud.fields], ["x", "y", "z", "rgb", "label"])
        words = np.frombuffer(cloud.data, "<u4").reshape(120 * 160, 5)
        np.testing.assert_array_equal(words[:, 4], expected)
        np.testing.assert_array_equal(words[:, :4].tobytes(), self.message(1).data)

        boxes = detections.get().markers
        known = [segment for segment in summary["segment_statistics"] if segment["points"] >= 50]
        self.assertEqual([box.id for box in boxes], [segment["label"] for segment in known])
        for box, segment in zip(boxes, known):
            self.assertEqual((box.type, box.action, box.text), (Marker.CUBE, Marker.ADD, str(segment["points"])))
            center, edges = segment["box"]["center"], 2 * np.array(segment["box"]["half_extents"])
            np.testing.assert_allclose([box.pose.position.x, box.pose.position.y, box.pose.position.z], center, atol=1e-3)
            np.testing.assert_allclose([box.scale.x, box.scale.y, box.scale.z], edges, atol=1e-3)
            np.testing.assert_allclose(255 * np.array([box.color.r, box.color.g, box.color.b]), segment["color"], atol=0.1)

        shown = markers.get().markers
        self.assertEqual(shown[0].action, Marker.DELETEALL)
        self.assertEqual(sorted({marker.ns for marker in shown[1:]}), ["boxes", "ids"])
        self.assertEqual(len(shown), 1 + 2 * len(known))

        # The launch file ends with its node, and the node with it.
        self.stop(process)
        self.assertEqual(process.returncode, 0)

    def test_a_node_that_is_behind_gives_the_newest(self):
        process = self.launch("/fast", "time_to_live:=0")
        self.addCleanup(self.stop, process)
        labeled = self.listen("/segserve/labeled", PointCloud2)
        publisher = self.connected("/fast")
        self.send_until_all_have_one(publisher, labeled)
        for seconds in range(2, 62):
            publisher.publish(self.message(seconds))
        seen = []
        while not seen or seen[-1] != 61:
            seen.append(labeled.get(timeout=30).header.stamp.secs)
        self.assertEqual(seen, sorted(seen))
        self.assertLess(len(seen), 61)

    def test_wrong_parameters_are_named(self):
        done = self.node("_threshold:=high", "_treshold:=0.5", "__name:=wrong")
        self.assertEqual(done.returncode, 2)
        text = done.stdout + done.stderr
        self.assertIn("treshold: there is no such parameter", text)
        self.assertIn("threshold: 'high' must be a number", text)

    def test_numbers_and_truth_values_may_be_parameters(self):
        done = self.node("_threshold:=7", "_track:=true", "_max_in_flight:=2.5", "__name:=typed")
        self.assertEqual(done.returncode, 2)
        text = done.stdout + done.stderr
        self.assertIn("threshold", text)
        self.assertIn("max_in_flight: '2.5' must be a whole number", text)
        self.assertNotIn("track", text)


if __name__ == "__main__":
    unittest.main()
