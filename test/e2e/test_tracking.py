# SPDX-License-Identifier: Apache-2.0
"""segctl segment --track follows objects through folders and recordings, and segctl eval --track scores that."""
import json
import math
import shutil
import unittest

from harness import BAD_INPUT, EndToEnd, Server, segctl
import pcd
import recordings

FRAMES = 8


def many_objects(shift):
    """The points and packed colors of 256 bent sheets beside each other, which is the most that a track state holds."""
    points, colors = [], []
    for sheet in range(256):
        x, y = 0.5 * (sheet % 16), 0.5 * (sheet // 16)
        color = sheet * 2654435761 % (1 << 24)
        for i in range(20):
            for j in range(20):
                bend = 0.02 * math.sin(0.06 * i * (sheet % 7))
                points.append((round(x + 0.012 * i + shift, 4), round(y + 0.012 * j, 4), round(2 + 0.1 * (sheet % 5) + bend, 4)))
                colors.append(color)
    return points, colors


class Tracking(EndToEnd):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.other = Server(cls.folder)
        cls.addClassCleanup(cls.other.close)

    def moving(self, *flags, name="moving"):
        """A moving scene of small frames."""
        folder = self.path(name)
        self.run_well("synth", "--moving", folder, "--frames", FRAMES, "--width", 160, "--height", 120, "--objects", 5,
                      "--clutter", 0, "--compact", "--quiet", *flags)
        return folder

    def follow(self, folder, *flags):
        """What is told of each frame."""
        done = self.run_well("segment", folder, "--track", "--json", "-", *flags)
        return [json.loads(line) for line in done.stdout.splitlines()]

    @staticmethod
    def ids(lines):
        return [line["track_ids"] for line in lines]

    def test_a_sequence_tells_when_and_from_where(self):
        folder = self.moving("--rate", 4)
        frames = json.loads((folder / "sequence.json").read_text())["frames"]
        self.assertEqual([frame["time"] for frame in frames], [i / 4 for i in range(FRAMES)])
        self.assertEqual([frame["file"] for frame in frames], [f"frame_{i:04}.pcd" for i in range(FRAMES)])
        self.assertEqual({(len(frame["rotation"]), len(frame["translation"])) for frame in frames}, {(9, 3)})
        labels = pcd.read_labels(folder / "frame_0000.pcd")
        self.assertTrue({0, 1, 20, 30} <= set(labels), set(labels))

    def test_objects_keep_their_ids(self):
        folder = self.moving()
        lines = self.follow(folder, "--local", "--out-dir", self.path("followed"))
        self.assertEqual([line["state"] for line in lines], ["segmented"] * FRAMES)
        self.assertEqual(lines[0]["track_ids"][0], 1)
        self.assertTrue(all(event["kind"] == "born" for event in lines[0]["track_events"]))
        # Whoever is in every frame is most of them.
        always = set.intersection(*(set(ids) - {0} for ids in self.ids(lines)))
        self.assertGreaterEqual(len(always), 4, self.ids(lines))
        # The labels that are written are the ids: each object mostly has one over all frames.
        kept = 0
        truths = [pcd.read_labels(folder / f"frame_{i:04}.pcd") for i in range(FRAMES)]
        shown = [pcd.read_labels(self.path("followed") / f"frame_{i:04}.pcd") for i in range(FRAMES)]
        for label in (20, 30, 40, 50, 60):
            ids = set()
            for truth, ids_of_points in zip(truths, shown):
                of_object = [i for t, i in zip(truth, ids_of_points) if t == label and i != 0]
                if of_object:
                    ids.add(max(set(of_object), key=of_object.count))
            kept += len(ids) == 1
        self.assertGreaterEqual(kept, 4)
        for line, ids_of_points in zip(lines, shown):
            self.assertEqual(set(ids_of_points) - {0}, set(line["track_ids"]) - {0})

    def test_every_server_tells_the_same(self):
        folder = self.moving()
        here = self.follow(folder, "--local")
        for server in (self.server, self.other):
            there = self.follow(folder, "--server", server.address)
            for key in ("track_ids", "track_events", "segment_points", "track_state_bytes"):
                self.assertEqual([line[key] for line in there], [line[key] for line in here], key)

    def test_ids_outlive_a_server(self):
        folder = self.moving()
        here = self.follow(folder, "--local")
        first = Server(self.folder)
        self.addCleanup(first.close)
        both = f"{first.address},{self.other.address}"
        self.assertEqual(self.ids(self.follow(folder, "--server", both)), self.ids(here))
        first.close()
        self.assertEqual(self.ids(self.follow(folder, "--server", both)), self.ids(here))

    def test_a_frame_that_cannot_be_read_interrupts_nothing(self):
        folder = self.moving()
        (folder / "frame_0003.pcd").write_bytes(b"no cloud")
        done = self.run_badly_with_lines(folder)
        states = [line["state"] for line in done]
        self.assertEqual(states, ["segmented"] * 3 + ["failed"] + ["segmented"] * (FRAMES - 4))
        self.assertTrue(set(done[2]["track_ids"]) & set(done[4]["track_ids"]) - {0})

    def run_badly_with_lines(self, folder):
        output = self.path("tracks.jsonl")
        done = segctl("segment", folder, "--track", "--local", "--quiet", "--json", output)
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertRegex(done.stderr.decode(), r"\Asegctl: 1 of 8 frames failed; frame_0003.pcd: ")
        return [json.loads(line) for line in output.read_text().splitlines()]

    def test_without_sequence_json_the_names_give_the_order(self):
        folder = self.moving()
        (folder / "sequence.json").unlink()
        lines = self.follow(folder, "--local", "--rate", 5)
        self.assertEqual([line["time"] for line in lines], [i / 5 for i in range(FRAMES)])
        self.assertGreaterEqual(len(set.intersection(*(set(ids) - {0} for ids in self.ids(lines)))), 4)

    def test_a_wrong_sequence_is_explained(self):
        folder = self.moving()
        for text, message in (("{", "line 1, column 2"), ('{"frames": []}', "its list \"frames\" is empty"),
                              ('{"frames": [{"file": "../x.pcd", "time": 0}]}', "frame 0: its \"file\" is no name"),
                              ('{"frames": [{"file": "frame_0000.pcd"}]}', "frame 0: it has no \"time\""),
                              ('{"frames": [{"file": "frame_0000.pcd", "time": 0, "rotation": [1]}]}', "9 numbers"),
                              ('{"frames": [{"file": "frame_0000.pcd", "time": 0, "time": 1}]}', "the member \"time\" twice")):
            (folder / "sequence.json").write_text(text)
            self.assertIn(message, self.run_badly(BAD_INPUT, "segment", folder, "--track", "--local"))

    def test_scores(self):
        folder = self.moving()
        told = json.loads(self.run_well("eval", "--data", folder, "--track", "--json", "-").stdout)
        sequence = told["sequences"][0]
        self.assertEqual((sequence["frames"], sequence["visible_switches"]), (FRAMES, 0))
        self.assertGreater(sequence["assa"], 0.9)
        self.assertGreater(sequence["deta"], sequence["cut_deta"] - 0.02)
        self.assertGreater(sequence["idf1"], 0.8)
        parent = self.path("sequences")
        parent.mkdir()
        shutil.copytree(folder, parent / "a")
        shutil.copytree(folder, parent / "b")
        both = json.loads(self.run_well("eval", "--data", parent, "--track", "--json", "-").stdout)
        self.assertEqual([s["name"] for s in both["sequences"]], ["a", "b"])
        self.assertAlmostEqual(both["mean"]["hota"], sequence["hota"])
        self.assertIn("HOTA", self.run_well("eval", "--data", folder, "--track").stdout.decode())

    def test_a_stream_follows_as_many_objects_as_a_state_holds(self):
        folder = self.path("many")
        folder.mkdir()
        for i in range(3):
            points, colors = many_objects(shift=0.002 * i)
            (folder / f"{i}.0.pcd").write_bytes(pcd.ascii_file(points, colors))
        lines = self.follow(folder, "--server", self.server.address)
        self.assertGreater(min(line["track_state_bytes"] for line in lines), 64 << 10)
        done = self.run_well("stream", folder, "--track", "--wait", "--json", "-", "--server", self.server.address)
        told = json.loads(done.stdout)
        self.assertEqual((told["results"], told["failed"]), (3, 0), told)

    def test_misuse_is_explained(self):
        folder = self.moving()
        for flags, message in (((folder / "frame_0000.pcd",), "a folder"), ((folder, folder), "one folder"),
                               ((folder, "--max-speed", -1), "--max-speed: -1"),
                               ((folder, "--out-dir", folder), "would be overwritten")):
            with self.subTest(flags=flags):
                self.assertIn(message, self.run_badly(BAD_INPUT, "segment", "--track", "--local", *flags))
        self.assertIn("hollow and compact", self.run_badly(BAD_INPUT, "synth", "--moving", self.path("x"), "--compact",
                                                            "--hollow"))
        self.assertIn("--moving is for tables",
                      self.run_badly(BAD_INPUT, "synth", "--moving", self.path("x"), "--fused"))


class TrackedRecording(EndToEnd):
    def setUp(self):
        if recordings.missing:
            self.skipTest(f"no recording was tried: {recordings.missing}")
        recordings.node("check")

    def test_a_recording_is_followed(self):
        folder = self.path("moving")
        self.run_well("synth", "--moving", folder, "--frames", 4, "--width", 160, "--height", 120, "--objects", 4,
                      "--clutter", 0, "--quiet")
        clouds = []
        for i in range(4):
            x, y, z, color = pcd.read_points(folder / f"frame_{i:04}.pcd")
            points = [point + (0,) for point in zip(x, y, z, color)]
            clouds.append((i * 10**8, recordings.point_cloud2(recordings.FIRST + i * 10**8, points, "camera", 160)))
        run = recordings.write(self.path("run.mcap"), [recordings.clouds("/points", clouds)])
        told = []
        for flags in (("--local",), ("--server", self.server.address)):
            output = self.path(f"followed-{len(told)}.mcap")
            done = self.run_well("segment", run, "--topic", "/points", "--track", "-o", output, "--json", "-", *flags)
            lines = [json.loads(line) for line in done.stdout.splitlines()]
            told.append([line["track_ids"] for line in lines])
            for message, ids in zip(recordings.read(output)["messages"], told[-1]):
                labels, _ = recordings.labels_of(message["decoded"])
                self.assertEqual(set(labels) - {0}, set(ids) - {0})
        self.assertEqual(told[0], told[1])
        self.assertGreaterEqual(len(set.intersection(*(set(ids) - {0} for ids in told[0]))), 3)


if __name__ == "__main__":
    unittest.main()
