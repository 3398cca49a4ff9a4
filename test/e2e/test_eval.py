# SPDX-License-Identifier: Apache-2.0
"""segctl eval scores a folder with ground truth, learns thresholds and compares results; test/table1 uses it."""
import base64
import json
import pathlib
import re
import subprocess
import unittest
import urllib.parse

from harness import BAD_INPUT, SEGCTL, EndToEnd, segctl
import pcd

PARTS = {"one_to_one": {"wov", "tp", "fp", "fn", "f"}, "paper_all": {"wov", "tp", "fp", "fn"},
         "paper_objects": {"wov", "tp", "fp", "fn"},
         "instance": {"ap", "ap50", "ap75", "ar", "ar50", "ar75"}, "panoptic_all": {"pq", "sq", "rq"},
         "panoptic_objects": {"pq", "sq", "rq"}, "overlap_objects": {"precision", "recall", "f", "objects_f75"},
         "boundary": {"precision", "recall", "f"},
         "supervoxel_quality": {"achievable_accuracy", "undersegmentation_error", "boundary_recall"}}


class Eval(EndToEnd):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        case = cls("run_well")
        cls.data, cls.rooms, cls.empty = cls.folder / "data", cls.folder / "rooms", cls.folder / "empty"
        for folder in (cls.data, cls.rooms, cls.empty):
            folder.mkdir()
        for seed in (1, 2, 3):
            case.run_well("synth", "-q", "--seed", seed, "--width", "160", "--height", "120",
                          "-o", cls.data / f"{seed}.pcd")
        case.run_well("synth", "-q", "--fused", "--points", "20000", "-o", cls.rooms / "1.pcd")

    def eval(self, *flags, data=None):
        return json.loads(self.run_well("eval", "--data", data or self.data, "--json", "-", *flags).stdout)

    def test_the_json_has_means_and_rows(self):
        told = self.eval("--method", "lambda", "--threshold", "0.2")
        self.assertEqual((told["scenes"], told["method"], told["threshold"]), (3, "lambda", 0.2))
        self.assertEqual([row["file"] for row in told["per_scene"]], ["1.pcd", "2.pcd", "3.pcd"])
        for row in (told, *told["per_scene"]):
            for part, scores in PARTS.items():
                self.assertEqual(set(row[part]), scores)
                self.assertTrue(all(0 <= value <= 1 for value in row[part].values()), row[part])
            self.assertGreaterEqual(row["supervoxels"], row["segments"])
            counts = row["object_counts"]
            self.assertEqual(set(counts), {"objects", "over_segmented", "under_segmented", "missed"})
            self.assertGreaterEqual(counts["objects"], counts["over_segmented"])
            self.assertGreater(row["ms"], 0)
        wov = [row["one_to_one"]["wov"] for row in told["per_scene"]]
        self.assertAlmostEqual(told["one_to_one"]["wov"], sum(wov) / 3, places=12)

    def test_the_counts_are_those_of_segment(self):
        told = self.eval("--method", "geometry")
        scene = json.loads(self.run_well("segment", self.data / "2.pcd", "--local", "--method", "geometry",
                                         "--json", "-").stdout)
        row = told["per_scene"][1]
        self.assertEqual((row["supervoxels"], row["segments"]), (scene["supervoxels"], scene["segments"]))
        self.assertEqual(told["threshold"], scene["threshold"])  # the method's default

    def test_learns_the_threshold_of_highest_tp(self):
        told = self.eval("--method", "lambda-convex", "--learn", self.data, "--curve")
        learnt = told["learnt"]
        self.assertEqual(told["threshold"], learnt["threshold"])
        self.assertEqual([point["threshold"] for point in learnt["curve"]], [i / 100 for i in range(101)])
        best = max(point["one_to_one_tp"] for point in learnt["curve"])
        first = next(point for point in learnt["curve"] if point["one_to_one_tp"] == best)
        self.assertEqual((first["threshold"], best), (learnt["threshold"], learnt["one_to_one_tp"]))
        self.assertAlmostEqual(told["one_to_one"]["tp"], best, places=12)
        self.assertNotIn("curve", self.eval("--method", "lambda-convex", "--learn", self.data)["learnt"])

    def test_degrades_scenes_the_same_way_each_time(self):
        clean = self.eval()
        for flags in (("--noise-mm", "20"), ("--keep", "0.25"), ("--no-color", "--method", "color"), ("--scale", "4")):
            with self.subTest(flags=flags):
                first, again = (self.eval(*flags)["per_scene"] for _ in range(2))
                for row in (*first, *again):
                    del row["ms"]
                self.assertEqual(first, again)
                self.assertNotEqual([row["one_to_one"] for row in first],
                                    [row["one_to_one"] for row in clean["per_scene"]])

    def test_scores_a_fused_room_in_its_world_view(self):
        told = self.eval("--method", "lambda-convex", "--threshold", "0.15", data=self.rooms)
        self.assertIsNone(told["supervoxel_quality"]["boundary_recall"])  # no image
        self.assertGreater(told["one_to_one"]["wov"], 0)

    def test_scores_under_a_given_view(self):
        told = self.eval("--method", "lambda-convex")
        self.assertIsNone(told["view"])
        same = self.eval("--method", "lambda-convex", "--view", "camera")
        self.assertEqual((same["view"], same["one_to_one"]), ("camera", told["one_to_one"]))
        other = self.eval("--method", "lambda-convex", "--view", "world:0,0,0.5")
        self.assertEqual(other["view"], "world:0,0,0.5")
        self.assertNotEqual(other["supervoxels"], told["supervoxels"])

    def test_takes_every_format_with_labels(self):
        formats = self.path("formats")
        formats.mkdir()
        for end in ("pcd", "ply", "las", "csv", "xyz", "npy"):
            done = segctl("synth", "-q", "--seed", "1", "--width", "160", "--height", "120",
                          "-o", formats / f"1.{end}")  # LAS warns that it cannot hold points that are missing
            self.assertEqual(done.returncode, 0)
        (formats / "notes.txt").write_text("These are scenes.")
        # LAS rounds coordinates, so a resolution that follows the cloud could be another one.
        told = self.eval("--view", "world", "--voxel-resolution", "0.0075", data=formats)
        self.assertEqual([row["file"][2:] for row in told["per_scene"]], ["csv", "las", "npy", "pcd", "ply", "xyz"])
        for row in told["per_scene"]:
            self.assertAlmostEqual(row["one_to_one"]["wov"], told["one_to_one"]["wov"], places=2)

    def test_the_text_is_a_table(self):
        text = self.run_well("eval", "--data", self.data, "--noise-mm", "3").stdout.decode()
        for part in ("1.pcd", "3.pcd", "mean", "one_to_one", "3 mm depth noise at 1 m", "achievable_accuracy"):
            self.assertIn(part, text)

    def test_compares_two_results(self):
        a, b = self.path("a.json"), self.path("b.json")
        self.run_well("eval", "--data", self.data, "-q", "--method", "lambda-convex", "--json", a)
        self.run_well("eval", "--data", self.data, "-q", "--method", "lambda-convex", "--threshold", "1", "--json", b)
        told = json.loads(self.run_well("eval", "--compare", a, b, "--json", "-").stdout)
        mean_a, mean_b = (json.loads(path.read_text())["one_to_one"]["wov"] for path in (a, b))
        wov = told["differences"]["one_to_one.wov"]
        self.assertAlmostEqual(wov["difference"], mean_a - mean_b, places=12)
        self.assertLessEqual(wov["interval95"][0], wov["difference"])
        self.assertGreaterEqual(wov["interval95"][1], wov["difference"])
        self.assertEqual(wov["scenes"], 3)
        self.assertIn("one_to_one.wov", self.run_well("eval", "--compare", a, b).stdout.decode())

    def test_sets_a_peer_beside(self):
        result = self.path("result.json")
        done = segctl("eval", "--data", self.data, "--peer", "lccp", "--json", result)
        if b"built without PCL" in done.stderr:
            self.assertEqual((done.returncode, result.exists()), (BAD_INPUT, False))
            return
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        told = json.loads(result.read_text())
        peer = told["peer"]
        self.assertEqual((peer["method"], peer["scenes"]), ("pcl-lccp", 3))
        self.assertEqual([row["file"] for row in peer["per_scene"]], ["1.pcd", "2.pcd", "3.pcd"])
        wov = told["differences"]["one_to_one.wov"]
        self.assertAlmostEqual(wov["difference"], told["one_to_one"]["wov"] - peer["one_to_one"]["wov"], places=12)
        for part in (b"border on 3 scenes", b"pcl-lccp on 3 scenes", b"A border", b"B pcl-lccp", b"p, A better"):
            self.assertIn(part, done.stdout)
        coarse = self.eval("--peer", "lccp:0.02,0.08")["peer"]
        self.assertEqual(coarse["method"], "pcl-lccp:0.02,0.08")
        self.assertLess(coarse["supervoxels"], peer["supervoxels"])
        self.assertNotIn("peer", self.eval())

    def test_writes_pages_with_pictures(self):
        odd = self.path("odd")
        odd.mkdir()
        for seed in (1, 2):
            (odd / f"<b>|{seed}.pcd").write_bytes((self.data / f"{seed}.pcd").read_bytes())
        (odd / "<i>.pcd").write_bytes(b"no cloud")
        page, text = self.path("scores.html"), self.path("the scores.md")
        done = segctl("eval", "--data", odd, "--html", page, "--markdown", text, "--worst", "1", "-q")
        self.assertEqual((done.returncode, done.stdout), (BAD_INPUT, b""))  # for the file that is no cloud
        html = page.read_text()
        self.assertEqual(html.count("src=\"data:image/png;base64,"), 2)
        self.assertIn("&lt;b&gt;|1.pcd", html)
        self.assertIn("&lt;i&gt;.pcd", html)
        for raw in ("<b>", "<i>", "<script", "http"):
            self.assertNotIn(raw, html)
        images = [base64.b64decode(image) for image in re.findall("base64,([^\"]*)\"", html)]
        pictures = text.with_name(text.stem + "_pictures")
        self.assertEqual([(pictures / name).read_bytes() for name in ("truth-1.png", "segments-1.png")], images)
        self.assertTrue(images[0].startswith(b"\x89PNG"))
        self.assertIn(f"![truth]({urllib.parse.quote(pictures.name)}/truth-1.png)", text.read_text())
        self.assertIn("\\<b\\>\\|2.pcd", text.read_text())
        self.assertEqual(sorted(path.name for path in pictures.iterdir()), ["segments-1.png", "truth-1.png"])
        printed = self.run_well("eval", "--data", self.data, "--markdown", "-").stdout.decode()
        self.assertTrue(printed.startswith("# Scores of border\n"))
        self.assertNotIn(".png", printed)

    def test_table1_scores_every_variant(self):
        learn = self.path("data") / "osd" / "learn"
        learn.parent.mkdir(parents=True)
        learn.symlink_to(self.data)
        scores = self.path("scores")
        table1 = pathlib.Path(__file__).resolve().parents[1] / "table1"
        flags = ("--data", learn.parents[1], "--rooms", "0", "--segctl", SEGCTL, "--scores", scores)
        done = subprocess.run([table1, *flags], capture_output=True, timeout=120, check=True, text=True)
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in done.stdout.splitlines()
                if line.startswith("|")][2:]
        self.assertEqual([row[0] for row in rows], ["color", "geometry", "equalization", "equalization-convex",
                                                    "lambda", "lambda-convex"])
        for row in rows:
            told = json.loads((scores / f"learn-{row[0]}-published.json").read_text())
            self.assertEqual(float(row[1]), told["threshold"])
            self.assertIn(f"{100 * told['one_to_one']['wov']:.2f}", row[4])

    def test_tells_what_is_wrong(self):
        unlabeled = self.path("unlabeled")
        unlabeled.mkdir()
        (unlabeled / "x.pcd").write_bytes(pcd.ascii_file([(0, 0, 1), (0, 1, 1)]))
        result = self.path("result.json")
        self.run_well("eval", "--data", self.data, "-q", "--json", result)
        for part, *flags in (("--data or --compare",),
                             ("no cloud that can have labels: no file whose name ends in .pcd, .ply, .las, .xyz, .txt, .csv, .pts, .npy or "
                              ".npz, also compressed as .gz or .zst", "--data", self.empty),
                             ("there is no folder", "--data", self.folder / "absent"),
                             ("--view sky: must be", "--data", self.data, "--view", "sky"),
                             ("is no folder", "--data", self.data / "1.pcd"),
                             ("no field \"label\"", "--data", unlabeled),
                             ("not one of", "--data", self.data, "--method", "best"),
                             ("keep: 0 is not in (0, 1]", "--data", self.data, "--keep", "0"),
                             ("--peer kmeans: must be lccp", "--data", self.data, "--peer", "kmeans"),
                             ("--peer lccp:0.03,0.01: must be", "--data", self.data, "--peer", "lccp:0.03,0.01"),
                             ("--peer lccp:nan,1: must be", "--data", self.data, "--peer", "lccp:nan,1"),
                             ("there is no folder", "--data", self.data, "--html", self.folder / "absent" / "x.html"),
                             ("--learn excludes", "--data", self.data, "--learn", self.data, "--threshold", "0.1"),
                             ("no cloud that can have labels", "--data", self.data, "--learn", self.empty),
                             ("one thread", "--data", self.data, "--threads", "2"),
                             ("absent", "--compare", result, self.path("absent")),
                             ("not a result of segctl eval", "--compare", result, self.data / "1.pcd"),
                             ("--compare", "--compare", result),
                             ("--data", "--compare", result, result, "--data", self.data),
                             ("there is no folder", "--data", self.data, "--json", self.folder / "absent" / "x.json")):
            with self.subTest(flags=flags):
                self.assertIn(part, self.run_badly(BAD_INPUT, "eval", *flags))


if __name__ == "__main__":
    unittest.main()
