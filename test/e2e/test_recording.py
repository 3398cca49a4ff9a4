# SPDX-License-Identifier: Apache-2.0
"""segctl segment reads and writes recordings as the libraries of Foxglove do."""
import base64
import json
import unittest

from harness import BAD_INPUT, FAILED, EndToEnd, segctl
import pcd
import recordings


class Recording(EndToEnd):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        if recordings.missing:
            raise unittest.SkipTest(f"no recording was tried: {recordings.missing}")
        recordings.node("check")

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
        done = self.run_well("segment", cut, "--local", "-o", labeled)
        self.assertIn("as after a crash", done.stdout.decode())
        self.assertGreater(len(recordings.read(labeled)["messages"]), 0)

    def test_wrong_usage(self):
        run = self.record(self.scene(1)[1])
        bag = self.path("run.db3")
        bag.write_bytes(b"SQLite format 3\0" + bytes(100))
        for flags, said in (((run, "--topic", "/point"), "its topics are /points (sensor_msgs/msg/PointCloud2, cdr, 1 "),
                            ((run, "--topic", "/text"), "std_msgs/msg/String (cdr), which cannot be read"),
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


if __name__ == "__main__":
    unittest.main()
