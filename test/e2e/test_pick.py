# SPDX-License-Identifier: Apache-2.0
"""segctl pick picks objects of a saved result by places, and the page of segctl view picks the same ones."""
import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from harness import BAD_INPUT, SUCCESS, segctl
import pcd

HERE = pathlib.Path(__file__).resolve().parent
WIDTH, HEIGHT = 160, 120


class Pick(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-pick-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.scene, cls.result, labeled = (cls.folder / name for name in ("scene.pcd", "scene.segres", "labeled.pcd"))
        cls.run_well("synth", "-o", cls.scene, "-q", "--width", WIDTH, "--height", HEIGHT, "--seed", 5)
        cls.run_well("segment", cls.scene, "--local", "-q", "--result", cls.result, "-o", labeled)
        cls.labels = pcd.read_labels(labeled)

    @staticmethod
    def run_well(*arguments):
        done = segctl(*arguments)
        if done.returncode != SUCCESS:
            raise AssertionError(f"segctl {arguments}: {done.stderr.decode()}")
        return done

    def pick(self, *arguments):
        return json.loads(self.run_well("pick", self.result, "--cloud", self.scene, *arguments, "--json", "-").stdout)

    def pixel_of(self, label):
        """A pixel in the middle of those with a label."""
        pixels = [i for i, value in enumerate(self.labels) if value == label]
        middle = pixels[len(pixels) // 2]
        return middle % WIDTH, middle // WIDTH

    def place(self, label):
        return "{},{}".format(*self.pixel_of(label))

    def test_one_place_picks_its_segment(self):
        for label in (1, 2, 3):
            output = self.folder / "picked.pcd"
            told = self.pick("--include", self.place(label), "-o", output)
            self.assertEqual(pcd.read_labels(output), [int(value == label) for value in self.labels])
            self.assertEqual(told["picked"]["points"], self.labels.count(label))
            self.assertEqual(told["segment"]["points"], self.labels.count(label))
            self.assertEqual(told["picked"], told["candidates"][told["candidate"]])

    def test_a_position_means_the_nearest_point(self):
        told = self.pick("--include", self.place(2))
        x, y, z = told["segment"]["centroid"]
        again = self.pick("--include", f"{x},{y},{z}")
        [place] = again["include"]
        self.assertEqual(self.labels[place["point"]], 2)
        self.assertLess(place["distance"], 0.2)
        self.assertEqual(again["segment"], told["segment"])
        self.pick("--include", f"-0.5,{y},{z}")  # It begins like a flag.

    def test_excluding_leaves_what_is_excluded(self):
        both = self.pick("--include", self.place(1), "--include", self.place(2))
        self.assertEqual(len(both["picked"]["nodes"]), 1)
        self.assertGreaterEqual(both["picked"]["points"], self.labels.count(1) + self.labels.count(2))
        output = self.folder / "without.pcd"
        without = self.pick("--include", self.place(1), "--include", self.place(2), "--exclude", self.place(3), "-o",
                            output)
        picked = pcd.read_labels(output)
        for label, expected in ((1, 1), (2, 1), (3, 0)):
            u, v = self.pixel_of(label)
            self.assertEqual(picked[v * WIDTH + u], expected)
        self.assertGreaterEqual(len(without["picked"]["nodes"]), 1)

    def test_larger_and_smaller_go_through_the_candidates(self):
        usual = self.pick("--include", self.place(2))
        larger = self.pick("--include", self.place(2), "--larger", "1")
        smaller = self.pick("--include", self.place(2), "--smaller", "1")
        self.assertEqual(larger["candidate"], usual["candidate"] + 1)
        self.assertEqual(smaller["candidate"], usual["candidate"] - 1)
        self.assertGreater(larger["picked"]["points"], usual["picked"]["points"])
        self.assertLess(smaller["picked"]["points"], usual["picked"]["points"])
        self.assertEqual(self.pick("--include", self.place(2), "--smaller", "1000")["candidate"], 0)
        largest = self.pick("--include", self.place(2), "--larger", "1000")
        self.assertEqual(largest["picked"], largest["candidates"][-1])
        self.assertEqual(self.pick("--include", self.place(2), "--regions", "1")["picked"], largest["picked"])

    def test_json_tells_what_a_format_cannot_hold(self):
        output = self.folder / "object.las"
        warnings = self.pick("--include", self.place(2), "-o", output)["warnings"]
        self.assertTrue(warnings and all(str(output) in warning["message"] for warning in warnings), warnings)
        self.assertEqual(self.pick("--include", self.place(2))["warnings"], [])

    def test_the_page_picks_the_same(self):
        page, queries = self.folder / "page.html", self.folder / "queries.json"
        done = segctl("view", self.result, "--cloud", self.scene, "-o", page)
        if b"was built without its page" in done.stderr:
            self.skipTest("segctl was built without npm: there is no page to test")
        told = [self.pick("--include", self.place(1)), self.pick("--include", self.place(2), "--smaller", "2"),
                self.pick("--include", self.place(1), "--include", self.place(3), "--exclude", self.place(2)),
                self.pick("--include", self.place(1), "--include", self.place(2), "--include", self.place(4),
                          "--exclude", self.place(3), "--exclude", self.place(5), "--larger", "3")]
        leaves = lambda places: [place["supervoxel"] - 1 for place in places]
        queries.write_text(json.dumps([{"include": leaves(pick["include"]), "exclude": leaves(pick["exclude"]),
                                        "candidate": pick["candidate"]} for pick in told]))
        script = subprocess.run(["node", HERE / "clients/page_select.js", page, queries], capture_output=True, timeout=100)
        self.assertEqual(script.returncode, 0, script.stderr.decode())
        for pick, answer in zip(told, json.loads(script.stdout), strict=True):
            for candidate, expected in zip(answer["candidates"], pick["candidates"], strict=True):
                self.assertEqual(candidate["nodes"], expected["nodes"])
                self.assertEqual(candidate["points"], expected["points"])
                self.assertEqual(candidate["thresholds"], expected["thresholds"])
            segment = pick["segment"]
            for name, expected, by in (("centroid", segment["centroid"], 1e-6), ("color", segment["color"], 1e-6),
                                       ("half_extents", segment["box"]["half_extents"], 1e-4)):
                for value, wanted in zip(answer[name], expected, strict=True):
                    self.assertAlmostEqual(value, wanted, delta=by, msg=name)

    def test_refuses_places_that_are_none(self):
        for arguments, reason in ((("--include", "nowhere"), "'nowhere' is neither a position X,Y,Z nor a pixel U,V"),
                                  (("--include", "1,2,3,4"), "neither"), (("--include", "160,5"), "outside the image"),
                                  (("--include", self.place(1), "--exclude", self.place(1)), "both included and excluded"),
                                  (("--exclude", "1,2"), "--include is required")):
            with self.subTest(arguments):
                done = segctl("pick", self.result, "--cloud", self.scene, *arguments)
                self.assertEqual(done.returncode, BAD_INPUT)
                self.assertIn(reason, done.stderr.decode())
        flat = self.folder / "flat.xyz"
        self.run_well("segment", self.scene, "--local", "-q", "-o", flat, "--drop-unlabeled")
        result = self.folder / "flat.segres"
        self.run_well("segment", flat, "--local", "-q", "--result", result)
        done = segctl("pick", result, "--cloud", flat, "--include", "3,4")
        self.assertIn("the cloud is no image", done.stderr.decode())


if __name__ == "__main__":
    unittest.main()
