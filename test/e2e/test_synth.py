# SPDX-License-Identifier: Apache-2.0
"""segctl synth: scenes with ground truth as clouds, images and pictures."""
import collections
import json
import struct
import unittest

from harness import BAD_INPUT, EndToEnd, segctl
import pcd

SMALL = ("--width", "160", "--height", "120")


class Synth(EndToEnd):
    def test_json_tells_what_the_scene_holds(self):
        scene = self.path("scene.pcd")
        told = json.loads(self.run_well("synth", "-o", scene, *SMALL, "--seed", "3", "--objects", "4", "--json", "-").stdout)
        self.assertEqual((told["width"], told["height"], told["points"]), (160, 120, 160 * 120))
        self.assertEqual(told["finite"], sum(x == x for x in pcd.read_points(scene)[0]))
        self.assertEqual((told["seed"], told["objects"]), (3, 4))
        self.assertEqual(told["regions"], len(set(pcd.read_labels(scene)) - {0}))
        self.assertEqual(told["intrinsics"], {"fx": 131.25, "fy": 131.25, "cx": 79.5, "cy": 59.5})
        self.assertIsNone(told["depth_scale"])
        room = json.loads(self.run_well("synth", "--fused", "--points", "2000", "-o", scene, "--json", "-").stdout)
        self.assertEqual((room["points"], room["height"], room["intrinsics"]), (2000, 1, None))

    def test_json_tells_what_a_format_cannot_hold(self):
        scene = self.path("scene.las")
        told = json.loads(self.run_well("synth", "-o", scene, *SMALL, "--json", "-").stdout)
        self.assertTrue(told["warnings"] and all(str(scene) in w["message"] for w in told["warnings"]), told["warnings"])
        self.assertIn(f"warning: {scene}: ", self.run_well("synth", "-o", scene, *SMALL).stdout.decode())
        self.assertIn(str(scene), segctl("synth", "-o", scene, *SMALL, "-q").stderr.decode())
        told = self.run_well("synth", "--moving", self.path("moving"), "--frames", "1", *SMALL, "--json", "-").stdout
        self.assertEqual(json.loads(told)["warnings"], [])

    def test_images_are_the_scene(self):
        scene, depth, summary = self.path("scene.pcd"), self.path("depth.png"), self.path("summary.json")
        for color in (self.path("color.jpg"), self.path("color.png")):
            with self.subTest(color=color.suffix):
                said = self.run_well("synth", *SMALL, "-o", scene, "--depth", depth, "--rgb", color, "--json", summary)
                flags = said.stdout.decode().split("segctl segment ")[1].split()
                self.assertEqual(flags, ["--depth", str(depth), "--rgb", str(color), "--intrinsics",
                                         "131.25,131.25,79.5,59.5"])
                self.assertEqual(json.loads(summary.read_text())["depth_scale"], 0.001)
                decoded = self.path("decoded.pcd")
                told = json.loads(self.run_well("segment", *flags, "--local", "-o", decoded, "--json", "-").stdout)
                self.assertEqual(told["finite"], json.loads(summary.read_text())["finite"])
                self.assertGreater(told["segments"], 3)
                expected, got = pcd.read_points(scene), pcd.read_points(decoded)
                for axis in range(3):
                    for a, b in zip(expected[axis], got[axis]):
                        self.assertTrue(abs(a - b) < 0.001 or (a != a and b != b))
                if color.suffix == ".png":
                    visible = [i for i, x in enumerate(expected[0]) if x == x]
                    self.assertEqual([expected[3][i] for i in visible], [got[3][i] for i in visible])

    def test_a_depth_image_may_be_alone_and_in_another_unit(self):
        depth = self.path("depth.png")
        said = self.run_well("synth", *SMALL, "--depth", depth, "--depth-scale", "0.0005").stdout.decode()
        flags = said.split("segctl segment ")[1].split()
        self.assertEqual(flags[-2:], ["--depth-scale", "0.0005"])
        self.run_well("segment", *flags, "--local")

    def test_pictures_of_labels_and_of_the_scene_itself(self):
        labels, plain = self.path("labels.png"), self.path("plain.png")
        self.run_well("synth", *SMALL, "-q", "--picture", labels, "--plain-picture", plain)
        for picture in (labels, plain):
            self.assertEqual(struct.unpack(">2I", picture.read_bytes()[16:24]), (160, 120))
        self.assertNotEqual(labels.read_bytes(), plain.read_bytes())
        scene, again = self.path("scene.pcd"), self.path("again.png")
        self.run_well("synth", *SMALL, "-q", "-o", scene)
        self.run_well("segment", scene, "--local", "-q", "--plain-picture", again)
        self.assertEqual(again.read_bytes(), plain.read_bytes(), "labels do not show in it")

    def test_the_same_seed_gives_the_same_scene(self):
        scenes = [self.synth("--seed", seed, *SMALL, name=f"{i}.pcd").read_bytes() for i, seed in enumerate((1, 1, 2))]
        self.assertEqual(scenes[0], scenes[1])
        self.assertNotEqual(scenes[0], scenes[2])

    def test_sensors_measure_one_scene_differently(self):
        for kind in ((), ("--room-view",)):
            clouds = {}
            for sensor in ("kinect1", "stereo", "passive-stereo", "tof", "ideal"):
                with self.subTest(kind=kind, sensor=sensor):
                    scene = self.path("scene.pcd")
                    told = json.loads(self.run_well("synth", *SMALL, *kind, "--sensor", sensor, "-o", scene, "--json",
                                                    "-").stdout)
                    self.assertEqual(told["intrinsics"]["fx"], 131.25)
                    self.assertGreater(told["objects"], 3)
                    clouds[sensor] = scene.read_bytes()
            self.assertEqual(len(set(clouds.values())), 5)

    def test_a_view_of_a_room_reaches_far(self):
        scene = self.path("scene.pcd")
        self.run_well("synth", "--room-view", *SMALL, "--sensor", "ideal", "-o", scene)
        depths = pcd.read_points(scene)[2]
        self.assertTrue(all(z == z for z in depths), "an ideal sensor sees the closed room at every pixel")
        self.assertGreater(max(depths), 7)
        self.run_well("synth", "--room-view", *SMALL, "--sensor", "ideal", "--size", "1", "-o", scene)
        self.assertLess(max(pcd.read_points(scene)[2]), 5)

    def test_hollow_things_and_more_furniture(self):
        for plain, more in (((), ("--hollow",)), (("--fused", "--points", "20000"), ("--furnished",)),
                            (("--room-view",), ("--furnished",)), (("--lidar", "16"), ("--furnished",))):
            with self.subTest(flags=plain):
                size = SMALL if plain in ((), ("--room-view",)) else ()
                scenes = [self.synth(*plain, *size, *flags, name=f"{len(flags)}.pcd").read_bytes() for flags in ((), more)]
                self.assertNotEqual(*scenes)

    def test_a_lidar_sweep_is_seen_from_the_origin(self):
        for flags, height in ((("--street",), 1), (("--street", "--organized"), 16), ((), 1), (("--organized",), 16)):
            with self.subTest(flags=flags):
                sweep = self.path("sweep.pcd")
                told = json.loads(self.run_well("synth", "--lidar", "16", "--columns", "360", *flags, "-o", sweep,
                                                "--json", "-").stdout)
                self.assertEqual((told["height"], told["intrinsics"]), (height, None))
                self.assertGreater(told["objects"], 2)
                seen = json.loads(self.run_well("info", sweep, "--json", "-").stdout)
                self.assertEqual(seen["view"], "world:0,0,0")

    def test_wrong_usage(self):
        for said, *flags in (("-o, --depth, --picture", "--seed", "2"), ("--seed: -1 is negative", "-o", "x.pcd", "--seed", "-1"),
                             ("--objects: -1 is negative", "-o", "x.pcd", "--objects", "-1"),
                             ("--rgb", "--rgb", "x.jpg"), ("must end in .png", "--depth", "x.jpg"),
                             ("must end in .jpg", "--depth", "x.png", "--rgb", "x.bmp"),
                             ("--depth", "--depth", "x.png", "--fused"),
                             ("--sensor", "-o", "x.pcd", "--sensor", "sonar"), ("--sensor", "-o", "x.pcd", "--fused", "--sensor", "tof"),
                             ("--furnished is for a room", "-o", "x.pcd", "--furnished"),
                             ("--hollow", "-o", "x.pcd", "--fused", "--hollow"),
                             ("rings is 17", "-o", "x.pcd", "--lidar", "17"),
                             ("--street", "-o", "x.pcd", "--street"), ("--lidar", "-o", "x.pcd", "--lidar", "16", "--fused"),
                             ("--depth does not go with --lidar", "--lidar", "16", "--depth", "x.png"),
                             ("--size is for a room", "-o", "x.pcd", "--lidar", "16", "--street", "--size", "2"),
                             ("--clutter", "-o", "x.pcd", "--room-view", "--clutter", "1"),
                             ("--size is for a room", "-o", "x.pcd", "--size", "2"),
                             ("--depth-scale", "--depth", "x.png", "--depth-scale", "0"),
                             ("does not fit", "--depth", "x.png", "--depth-scale", "1e-6")):
            with self.subTest(flags=flags):
                self.assertIn(said, self.run_badly(BAD_INPUT, "synth", *flags))


class SyntheticImages(EndToEnd):
    """The images of a synthetic scene are segmented like its points."""

    def test_give_the_segments_of_the_cloud(self):
        for flags in ((), ("--no-holes", "--noise", "0"), ("--all-finite",), ("--objects", "1", "--distance", "2"),
                      ("--clutter", "1", "--stacked", "1", "--seed", "5")):
            with self.subTest(flags=flags):
                scene, depth, color = self.path("scene.pcd"), self.path("depth.png"), self.path("color.png")
                said = self.run_well("synth", *SMALL, *flags, "-o", scene, "--depth", depth, "--rgb", color,
                                     "--depth-scale", "0.0001").stdout.decode()
                expected, _ = self.segment_locally(scene)
                output = self.path("out.pcd")
                self.run_well("segment", *said.split("segctl segment ")[1].split(), "--local", "-q", "-o", output)
                labels = pcd.read_labels(output)
                self.assertEqual([label == 0 for label in labels], [label == 0 for label in expected])
                pairs = collections.Counter((a, b) for a, b in zip(expected, labels) if a > 0)
                best = collections.Counter()
                for (a, _), count in pairs.items():
                    best[a] = max(best[a], count)
                self.assertGreater(sum(best.values()) / sum(pairs.values()), 0.8)

    def test_may_come_from_standard_input(self):
        depth = self.path("depth.png")
        said = self.run_well("synth", *SMALL, "--depth", depth).stdout.decode()
        flags = ["-" if word == str(depth) else word for word in said.split("segctl segment ")[1].split()]
        self.run_well("segment", *flags, "--local", stdin=depth.read_bytes())
        line = self.run_badly(BAD_INPUT, "segment", *flags, "--local", stdin=b"no picture")
        self.assertIn("segctl: standard input: depth: ", line)

    def test_a_room_has_none(self):
        line = self.run_badly(BAD_INPUT, "synth", "--fused", "--depth", "depth.png")
        self.assertIn("--depth does not go with --fused: no camera sees a whole room", line)


if __name__ == "__main__":
    unittest.main()
