# SPDX-License-Identifier: Apache-2.0
"""segctl segment reads and writes recordings as the libraries of Foxglove do."""
import base64
import json
import struct
import unittest

from harness import BAD_INPUT, FAILED, EndToEnd, SUCCESS, segctl
import pcd
import png
import recordings


class RecordingTest(EndToEnd):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        if recordings.missing:
            raise unittest.SkipTest(f"no recording was tried: {recordings.missing}")
        recordings.node("check")


class Recording(RecordingTest):
    def scene(self, seed):
        """A scene as a file, and its points with an intensity each."""
        scene = self.synth("--seed", seed, "--width", 80, "--height", 60, name=f"scene-{seed}.pcd")
        x, y, z, color = pcd.read_points(scene)
        return scene, [point + (i % 256,) for i, point in enumerate(zip(x, y, z, color))]

    def record(self, *frames, **options):
        """Clouds on /points, texts on /text, and metadata. `frames`: the points of each cloud."""
        points = [(i * 10**8, recordings.point_cloud2(recordings.FIRST + i, frame, "camera_optical_frame", 80))
                  for i, frame in enumerate(frames)]
        texts = [(i * 10**8 + 1, {"data": f"text {i}"}) for i in range(len(frames))]
        text = recordings.channel("/text", "std_msgs/msg/String", recordings.STRING, [])
        # The member of String has the name of the bytes in other messages.
        text["messages"] = [{"logTime": str(recordings.FIRST + after),
                             "data": recordings.text(b"\0\1\0\0" + len(value["data"] + "\0").to_bytes(4, "little") +
                                                     value["data"].encode() + b"\0")} for after, value in texts]
        return recordings.write(self.path("run.mcap"), [recordings.clouds("/points", points), text], **options)

    def test_a_recording_comes_out_with_labels(self):
        scenes = [self.scene(seed) for seed in (1, 2, 3)]
        # The library cannot read a file without chunks by its index.
        before = recordings.read(self.record(*(points for _, points in scenes)))
        for compression, chunks in (("zstd", True), ("lz4", True), ("", True), ("", False)):
            with self.subTest(compression=compression, chunks=chunks):
                run = self.record(*(points for _, points in scenes), compression=compression, chunks=chunks)
                labeled = self.path("labeled.mcap")
                done = self.run_well("segment", run, "--topic", "/points", "-o", labeled, "--server",
                                     self.server.address, "--json", "-")
                told = [json.loads(line) for line in done.stdout.splitlines()]
                after = recordings.read(labeled)
                self.assertEqual((after["profile"], after["metadata"]), ("ros2", before["metadata"]))
                self.assertEqual(sorted(after["topics"]), ["/points", "/text"])
                self.assertEqual(len(after["messages"]), len(before["messages"]))
                self.check_messages(before["messages"], after["messages"], scenes, told)

    def check_messages(self, before, after, scenes, told):
        frames = iter(zip(scenes, told))
        for old, new in zip(before, after):
            for key in ("topic", "type", "logTime", "publishTime", "sequence"):
                self.assertEqual(old[key], new[key])
            if old["topic"] == "/text":
                self.assertEqual(old["data"], new["data"])
                continue
            (scene, _), line = next(frames)
            labels, points = recordings.labels_of(new["decoded"])
            expected, summary = self.segment_locally(scene)
            self.assertEqual(labels, expected)
            self.assertEqual((line["segments"], line["view"]), (summary["segments"], "camera"))
            self.assertEqual(line["log_time_ns"], int(old["logTime"]))
            data = base64.b64decode(old["decoded"]["data"])
            self.assertEqual(len(data), 60 * (80 * 22 + 3))
            self.assertEqual([point[:22] for point in points],
                             [data[row * 1763 + column * 22:][:22] for row in range(60) for column in range(80)])
            self.assertEqual(old["decoded"]["header"], new["decoded"]["header"])

    def test_info_lists_the_topics(self):
        run = self.record(self.scene(1)[1])
        info = json.loads(self.run_well("info", run, "--json", "-").stdout)
        self.assertEqual([(topic["name"], topic["type"], topic["messages"], topic["has_frames"]) for topic in info["topics"]],
                         [("/points", "sensor_msgs/msg/PointCloud2", 1, True), ("/text", "std_msgs/msg/String", 1, False)])
        self.assertIn("/points", self.run_well("info", run).stdout.decode())

    def test_files_can_be_written_instead(self):
        scene, points = self.scene(1)
        run = self.record(points, points)
        folder = self.path("frames")
        done = self.run_well("segment", run, "--local", "--out-dir", folder)
        self.assertIn("2 frames segmented, 0 failed", done.stdout.decode())
        self.assertEqual(sorted(file.name for file in folder.iterdir()),
                         [f"{run.stem}-000000.pcd", f"{run.stem}-000001.pcd"])
        self.assertEqual(pcd.read_labels(folder / f"{run.stem}-000001.pcd"), self.segment_locally(scene)[0])

    def test_only_the_topic_is_kept_if_asked_for(self):
        run = self.record(self.scene(1)[1])
        labeled = self.path("labeled.mcap")
        self.run_well("segment", run, "--local", "--only-topic", "-o", labeled)
        self.assertEqual(recordings.read(labeled)["topics"], ["/points"])

    def test_standard_output_is_a_recording_too(self):
        run = self.record(self.scene(1)[1])
        piped = self.path("piped.mcap")
        piped.write_bytes(self.run_well("segment", run, "--local", "-o", "-").stdout)
        self.assertEqual(recordings.read(piped)["count"], "2")

    def test_a_frame_that_fails_is_copied_and_told(self):
        scene, points = self.scene(1)
        nowhere = [(float("nan"),) * 3 + (0, 0)] * 80
        run = self.record(points, [], nowhere, [(1e30, 0, 1, 0, 0)] * 80)
        labeled = self.path("labeled.mcap")
        done = segctl("segment", run, "--local", "-o", labeled)
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertRegex(done.stderr.decode(), r"\Asegctl: \d of 4 frames failed; frame \d: [^\n]+\n\Z")
        frames = [m["decoded"] for m in recordings.read(labeled)["messages"] if m["topic"] == "/points"]
        self.assertEqual([frame["fields"][-1]["name"] for frame in frames[:2]], ["label", "label"])
        self.assertEqual(frames[3]["fields"][-1]["name"], "intensity", "as it was")

    def test_what_a_crash_left_is_read(self):
        run = self.record(*[self.scene(1)[1]] * 3)
        cut = self.path("cut.mcap")
        cut.write_bytes(run.read_bytes()[:run.stat().st_size // 2])
        labeled = self.path("labeled.mcap")
        done = segctl("segment", cut, "--local", "-o", labeled)
        self.assertEqual(done.returncode, SUCCESS, done)
        self.assertIn("as after a crash", done.stderr.decode())
        self.assertGreater(len(recordings.read(labeled)["messages"]), 0)

    def test_json_tells_that_a_recording_is_cut_off(self):
        run = self.record(*[self.scene(1)[1]] * 3)
        cut = self.path("cut.mcap")
        cut.write_bytes(run.read_bytes()[:run.stat().st_size // 2])
        done = segctl("segment", cut, "--local", "-q", "--json", "-")
        self.assertEqual(done.returncode, SUCCESS, done)
        *frames, last = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertGreater(len(frames), 0)
        self.assertTrue(all("frame" in line for line in frames))
        self.assertEqual(list(last), ["input", "topic", "warnings"])
        self.assertIn("as after a crash", last["warnings"][0]["message"])
        self.assertIn("as after a crash", done.stderr.decode())
        self.assertEqual(done.stderr.count(b"\n"), 1)

    def test_a_recording_without_a_whole_frame_is_bad_input(self):
        run = self.record(self.scene(1)[1], chunks=False)
        whole = run.read_bytes()
        cut = self.path("cut.mcap")
        cut.write_bytes(whole[:len(whole) // 2])
        done = segctl("segment", cut, "--local", "-q", "--json", "-")
        self.assertEqual(done.returncode, BAD_INPUT, done)
        self.assertIn("as after a crash", done.stderr.decode())
        self.assertIn("warnings", json.loads(done.stdout.splitlines()[-1]))

    def test_a_topic_without_messages_is_bad_input(self):
        other = recordings.point_cloud2(recordings.FIRST, self.scene(1)[1], "camera_optical_frame", 80)
        run = recordings.write(self.path("run.mcap"), [recordings.clouds("/points", []), recordings.clouds("/other", [(0, other)])])
        error = self.run_badly(BAD_INPUT, "segment", run, "--local", "--quiet", "--topic", "/points")
        self.assertIn("there is no message in the topic /points", error)

    def test_a_recording_is_replayed_with_its_own_timing(self):
        frame = self.scene(1)[1]
        times = (0, 50, 100, 400)  # ms
        clouds = [(ms * 10**6, recordings.point_cloud2(recordings.FIRST, frame, "camera_optical_frame", 80)) for ms in times]
        run = recordings.write(self.path("run.mcap"), [recordings.clouds("/points", clouds)])
        bench = ("bench", "--server", self.server.address, "--input", run, "--warm-up", "0", "--json", "-")
        told = json.loads(self.run_well(*bench, "--duration", "1.5", "--speed", "2", "--clients", "2", "--verify").stdout)
        self.assertEqual((told["loop"], told["arrivals"], told["speed"], told["mismatches"]), ("open", "recorded", 2, 0))
        self.assertAlmostEqual(told["offered_frames_per_s"], 2 * 2 * 3 / 0.4)
        # A round takes 0.4 s + a gap of 0.1333 s, halved: in 1.5 s there are 5 rounds and a rest.
        self.assertAlmostEqual(told["frames"]["sent"], 2 * 23, delta=3)
        told = json.loads(self.run_well(*bench, "--duration", "0.5", "--speed", "0").stdout)
        self.assertEqual((told["loop"], told["speed"]), ("closed", None))
        told = json.loads(self.run_well(*bench, "--duration", "0.5", "--rate", "20").stdout)
        self.assertEqual((told["arrivals"], told["offered_frames_per_s"]), ("constant", 20))
        single = self.record(frame)
        self.assertIn("no two frames", self.run_badly(BAD_INPUT, *bench[:4], single))
        self.assertIn("--speed", self.run_badly(BAD_INPUT, *bench[:4], self.scene(1)[0], "--speed", "2"))

    def test_wrong_usage(self):
        run = self.record(self.scene(1)[1])
        bag = self.path("run.db3")
        bag.write_bytes(b"SQLite format 3\0" + bytes(100))
        for flags, said in (((run, "--topic", "/point"), "its topics are /points (sensor_msgs/msg/PointCloud2, cdr, 1 "),
                            ((run, "--topic", "/text"), "std_msgs/msg/String (cdr): it is no topic that can be read"),
                            ((run, "-o", "x.pcd"), ".mcap"), ((run, "--picture", "x.png"), "--picture"),
                            ((run, "-o", self.path("x.mcap"), "--color", "segment"), "--color"),
                            ((bag,), "ros2 bag convert"),
                            ((self.scene(1)[0], "--topic", "/points"), "--topic")):
            with self.subTest(flags=flags):
                self.assertIn(said, self.run_badly(BAD_INPUT, "segment", "--local", *flags))

    def test_without_a_server_nothing_is_left(self):
        run = self.record(self.scene(1)[1])
        labeled = self.path("labeled.mcap")
        self.run_badly(FAILED, "segment", run, "--server", "127.0.0.1:1", "-o", labeled)
        self.assertEqual(list(self.folder.glob(f"{labeled.name}*")), [])


class Bags(RecordingTest):
    def test_a_ros_1_bag_becomes_a_recording_with_labels(self):
        points = [(0.01 * (i % 30), 0.01 * (i // 30), 1.0 + (0.2 if i % 30 > 15 else 0)) for i in range(900)]
        message = recordings.ros1_point_cloud2(recordings.FIRST, points, "lidar")
        run = recordings.write_bag(self.path("run.bag"), "/points",
                                   [(recordings.FIRST + i * 10**9, message) for i in range(2)])
        labeled = self.path("labeled.mcap")
        self.run_well("segment", run, "--local", "-o", labeled)
        after = recordings.read(labeled)
        self.assertEqual((after["profile"], after["topics"]), ("ros1", ["/points"]))
        scene = self.path("scene.pcd")
        scene.write_bytes(pcd.binary_file(points))
        expected, _ = self.segment_locally(scene)
        for i, new in enumerate(after["messages"]):
            self.assertEqual((new["type"], new["logTime"]), ("sensor_msgs/PointCloud2", str(recordings.FIRST + i * 10**9)))
            data = base64.b64decode(new["data"])
            self.assertEqual(data[:16], message[:16], "the header")
            body = data[-1 - 16 * 900:-1]
            self.assertEqual([row[:3] for row in struct.iter_unpack("<3fI", body)],
                             [struct.unpack("<3f", struct.pack("<3f", *point)) for point in points])
            self.assertEqual([row[3] for row in struct.iter_unpack("<3fI", body)], expected)


WIDTH, HEIGHT = 80, 60
CAMERA = (WIDTH, HEIGHT, 70.0, 71.0, 39.5, 29.5)
DEPTH = [0 if u < 3 else 700 if 20 <= u < 45 and 15 <= v < 40 else 900 + 2 * v for v in range(HEIGHT) for u in range(WIDTH)]
COLORS = [0x9060C0 if depth == 700 else 0x406080 for depth in DEPTH]


class RecordedImages(RecordingTest):
    """Images in a recording give the clouds that the same images give as files."""

    def setUp(self):
        self.depth_png, self.color_png = self.path("depth.png"), self.path("color.png")
        self.depth_png.write_bytes(png.gray16(WIDTH, HEIGHT, DEPTH))
        self.color_png.write_bytes(png.rgb8(WIDTH, HEIGHT, COLORS))
        self.expected = self.labels_of_files("--rgb", self.color_png)

    def labels_of_files(self, *flags):
        labeled = self.path("files.pcd")
        self.run_well("segment", "--depth", self.depth_png, *flags, "--intrinsics", ",".join(map(str, CAMERA[2:])),
                      "--depth-scale", "0.001", "--local", "-q", "-o", labeled)
        return pcd.read_labels(labeled)

    def check(self, run, topic, expected, *flags):
        labeled = self.path("labeled.mcap")
        done = self.run_well("segment", run, "--local", "-o", labeled, "--json", "-", *flags)
        told = [json.loads(line) for line in done.stdout.splitlines()]
        after = recordings.read(labeled)
        clouds = [m for m in after["messages"] if m["topic"] == f"{topic}/labeled"]
        self.assertEqual(len(clouds), len(told))
        for cloud, line in zip(clouds, told):
            self.assertEqual(cloud["type"], "sensor_msgs/msg/PointCloud2")
            self.assertEqual(recordings.labels_of(cloud["decoded"])[0], expected)
            self.assertEqual((cloud["decoded"]["width"], cloud["decoded"]["height"]), (WIDTH, HEIGHT))
            self.assertEqual(cloud["decoded"]["header"]["frame_id"], "camera_depth_optical_frame")
            self.assertEqual((int(cloud["logTime"]), line["view"]), (line["log_time_ns"], "camera"))
        self.assertEqual(len(after["messages"]), len(recordings.read(run)["messages"]) + len(told), "the rest is copied")
        return told

    def test_raw_images_with_color(self):
        depth = struct.pack(f"<{len(DEPTH)}H", *DEPTH)
        color = b"".join(value.to_bytes(3, "big") for value in COLORS)
        at = recordings.FIRST
        run = recordings.write(self.path("run.mcap"), [
            recordings.images("/camera/depth/image_raw",
                              [(i * 10**8, recordings.image(at + i * 10**8, WIDTH, "16UC1", depth)) for i in range(3)]),
            recordings.images("/camera/color/image_raw",
                              [(i * 10**8 + 10**7, recordings.image(at + i * 10**8 + 10**7, WIDTH, "rgb8", color))
                               for i in range(3)]),
            recordings.cameras("/camera/depth/camera_info", [(5, recordings.camera_info(at, *CAMERA))])])
        topic = "/camera/depth/image_raw"
        told = self.check(run, topic, self.expected, "--topic", topic, "--color-topic", "/camera/color/image_raw")
        self.assertEqual([line["warnings"] for line in told], [[]] * 3)
        self.check(run, topic, self.labels_of_files())  # the only topic with depth in its name, without color

    def test_compressed_depth_and_a_distorted_camera(self):
        at = recordings.FIRST
        packed = bytes(12) + self.depth_png.read_bytes()
        topic = "/camera/depth/image_raw/compressedDepth"
        run = recordings.write(self.path("run.mcap"), [
            recordings.compressed_images(topic, [(0, recordings.compressed_image(at, "16UC1; compressedDepth png", packed))]),
            recordings.cameras("/camera/depth/camera_info", [(5, recordings.camera_info(at, *CAMERA, (0.1, 0, 0, 0, 0)))])])
        told = self.check(run, topic, self.labels_of_files())
        self.assertIn("distorted lens", told[0]["warnings"][0]["message"])

    def test_images_of_foxglove(self):
        stamp = {"seconds": 1, "nanos": 2}
        width, height, fx, fy, cx, cy = CAMERA
        topic = "/camera/depth"
        message = {"timestamp": stamp, "frame_id": "camera_depth_optical_frame", "format": "png"}
        run = recordings.write(self.path("run.mcap"), [
            recordings.foxglove(topic, "CompressedImage",
                                [(0, message | {"data": recordings.text(self.depth_png.read_bytes())})]),
            recordings.foxglove("/camera/color", "CompressedImage",
                                [(1, message | {"data": recordings.text(self.color_png.read_bytes())})]),
            recordings.foxglove("/camera/calibration", "CameraCalibration",
                                [(2, {"timestamp": stamp, "width": width, "height": height,
                                      "K": [fx, 0, cx, 0, fy, cy, 0, 0, 1]})])], profile="")
        self.check(run, topic, self.expected, "--topic", topic, "--color-topic", "/camera/color")

    def test_what_is_missing_is_told(self):
        depth = struct.pack(f"<{len(DEPTH)}H", *DEPTH)
        topic = "/camera/depth/image_raw"
        images = recordings.images(topic, [(0, recordings.image(recordings.FIRST, WIDTH, "16UC1", depth))])
        run = recordings.write(self.path("run.mcap"), [images])
        self.assertIn("there is no topic /camera/depth/camera_info", self.run_badly(BAD_INPUT, "segment", run, "--local"))
        camera = recordings.cameras("/camera/depth/camera_info", [])
        run = recordings.write(self.path("run.mcap"), [images, camera])
        self.assertIn("has no message", self.run_badly(BAD_INPUT, "segment", run, "--local"))
        self.assertIn("there is no topic /color; its topics are",
                      self.run_badly(BAD_INPUT, "segment", run, "--local", "--color-topic", "/color"))


class FoxgloveClouds(RecordingTest):
    def test_a_cloud_gets_labels_and_keeps_its_fields(self):
        points = [(0.01 * (i % 30), 0.01 * (i // 30), 1.0 + (0.2 if i % 30 > 15 else 0), i % 256) for i in range(900)]
        data = b"".join(struct.pack("<3fB", *point) for point in points)
        fields = [{"name": name, "offset": 4 * i, "type": 7} for i, name in enumerate("xyz")]
        message = {"timestamp": {"seconds": 7, "nanos": 8}, "frame_id": "lidar", "point_stride": 13,
                   "fields": [*fields, {"name": "intensity", "offset": 12, "type": 1}], "data": recordings.text(data)}
        run = recordings.write(self.path("run.mcap"), [recordings.foxglove("/points", "PointCloud", [(0, message)])])
        labeled = self.path("labeled.mcap")
        self.run_well("segment", run, "--local", "-o", labeled)
        old, new = (recordings.read(path)["messages"][0]["decoded"] for path in (run, labeled))
        self.assertEqual((new["timestamp"], new["frame_id"]), (old["timestamp"], "lidar"))
        self.assertEqual(new["fields"], [*old["fields"], {"name": "label", "offset": 16, "type": 5}])
        after = base64.b64decode(new["data"])
        self.assertEqual((new["point_stride"], len(after)), (20, 20 * 900))
        rows = [after[at:at + 20] for at in range(0, len(after), 20)]
        self.assertEqual(b"".join(row[:13] for row in rows), data)
        scene = self.path("scene.pcd")
        scene.write_bytes(pcd.binary_file([point[:3] for point in points]))
        self.assertEqual([int.from_bytes(row[16:], "little") for row in rows], self.segment_locally(scene)[0])


if __name__ == "__main__":
    unittest.main()
