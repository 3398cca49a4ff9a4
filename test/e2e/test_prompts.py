# SPDX-License-Identifier: Apache-2.0
"""segctl segment --include: an object is picked in the same step, alike through a server and in this process."""
import json

from harness import BAD_INPUT, EndToEnd, segctl
import pcd

WIDTH, HEIGHT = 160, 120
CODECS = ("planar", "planar-zstd", "strided", "strided-zstd", "pcd", "quantised")


class Prompts(EndToEnd):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = cls.folder / "scene.pcd"
        assert segctl("synth", "-o", cls.scene, "-q", "--width", WIDTH, "--height", HEIGHT, "--seed", 5).returncode == 0

    def setUp(self):
        labels, _ = self.segment_locally(self.scene)
        first, second = (min(i for i, value in enumerate(labels) if value == label) for label in (2, 3))
        self.places = ["--include", f"{first % WIDTH},{first // WIDTH}", "--exclude", f"{second % WIDTH},{second // WIDTH}"]
        self.labels = labels

    def test_the_server_picks_what_segctl_picks(self):
        for codec in CODECS:
            with self.subTest(codec):
                local, told = self.segment_locally(self.scene, "--codec", codec, *self.places)
                remote, answered = self.segment(self.scene, "--codec", codec, *self.places)
                self.assertEqual(remote, local)
                self.assertEqual(answered["selection"], told["selection"])
                self.assertGreater(sum(local), 0)

    def test_is_the_choice_of_segctl_pick(self):
        result = self.path("scene.segres")
        picked, told = self.segment(self.scene, *self.places, "--result", result)
        output = self.path("picked.pcd")
        done = self.run_well("pick", result, "--cloud", self.scene, *self.places, "-o", output, "--json", "-")
        self.assertEqual(pcd.read_labels(output), picked)
        by_pick = json.loads(done.stdout)
        by_pick.pop("candidates")
        self.assertEqual(by_pick.pop("warnings"), [])
        self.assertEqual(told["selection"], by_pick)
        cut = self.run_well("cut", result, "--threshold", "0.5", "--json", "-")
        self.assertEqual(json.loads(cut.stdout)["segments"], told["segments"])

    def test_larger_and_smaller_are_neighbors(self):
        at = [self.segment(self.scene, *self.places, *flags)[1]["selection"]["candidate"]
              for flags in ((), ("--larger", "1"), ("--smaller", "1"))]
        self.assertLessEqual(at[0], at[1])
        self.assertLessEqual(at[2], at[0])
        self.assertLess(at[2], at[1])

    def test_segments_tell_how_stable_they_are(self):
        _, told = self.segment(self.scene, "--segments")
        _, here = self.segment_locally(self.scene, "--segments")
        self.assertEqual(told["segment_statistics"], here["segment_statistics"])
        for segment in told["segment_statistics"]:
            low, high = segment["thresholds"]
            self.assertEqual(segment["stability"], high - low)
            self.assertTrue(low < 0.5 <= high, "the cut at 0.5 has the segment")

    def test_wrong_places_are_named(self):
        line = self.run_badly(BAD_INPUT, "segment", self.scene, "--server", self.server.address, "--include", "500,1",
                              "--include", "1,500")
        self.assertIn("pixel 500,1 is outside", line)
        self.assertIn("pixel 1,500 is outside", line)
        self.assertIn("is neither a position", self.run_badly(BAD_INPUT, "segment", self.scene, "--local", "--include", "x"))
        self.assertIn("--include is empty", self.run_badly(BAD_INPUT, "segment", self.scene, "--local", "--exclude", "1,1"))
        self.assertIn("for one cloud", self.run_badly(BAD_INPUT, "segment", self.scene, "--local", "--out-dir", self.path("d"),
                                                      "--include", "1,1"))
