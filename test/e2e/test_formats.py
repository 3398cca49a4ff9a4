# SPDX-License-Identifier: Apache-2.0
"""Files of every format are segmented alike, and every format out and in again has the same labels and sensor."""
import csv
import gzip
import json
import struct
import unittest

try:
    import numpy
except ImportError:
    numpy = None

from harness import BAD_INPUT, DATA, EndToEnd, SUCCESS, segctl

LAS = DATA / "las"


def two_boxes():
    """Two squares of different colors, apart from each other, with an intensity."""
    points = [(x + 0.004 * (i % 20), 0.004 * (i // 20), 1.0) for x in (0.0, 2.0) for i in range(400)]
    colors = [(255, 0, 0)] * 400 + [(0, 0, 255)] * 400
    return points, colors


class Formats(EndToEnd):
    def segment_file(self, scene, *flags):
        out = self.path("out.segs.json")
        self.run_well("segment", scene, "--local", "--view", "world", "-o", out, "-q", *flags)
        return json.loads(out.read_text())["segIndices"]

    def write_text(self, name, row, head=""):
        scene = self.path(name)
        points, colors = two_boxes()
        scene.write_text(head + "".join(row(p, c) for p, c in zip(points, colors)))
        return scene

    def scenes(self):
        yield self.write_text("a.xyz", lambda p, c: "{} {} {} {} {} {}\n".format(*p, *c))
        yield self.write_text("a.csv", lambda p, c: "{},{},{},{},{},{}\n".format(*p, *c), "x,y,z,red,green,blue\n")
        yield self.write_text("a.pts", lambda p, c: "{} {} {} -100 {} {} {}\n".format(*p, *c), "800\n")
        points, _ = two_boxes()
        kitti = self.path("a.bin")
        kitti.write_bytes(b"".join(struct.pack("<4f", *p, 0.25) for p in points))
        yield kitti
        sweep = self.path("sweep.pcd.bin")  # of nuScenes
        sweep.write_bytes(b"".join(struct.pack("<5f", *p, 17, i % 32) for i, p in enumerate(points)))
        yield sweep
        yield self.write_text("a.obj", lambda p, c: "v {} {} {} {} {} {}\n".format(*p, *(v / 255 for v in c)), "o boxes\n")
        packed = self.path("b.xyz.gz")
        packed.write_bytes(gzip.compress(self.path("a.xyz").read_bytes()))
        yield packed

    def test_files_of_every_format_are_segmented_alike(self):
        expected = [1] * 400 + [2] * 400
        for scene in self.scenes():
            with self.subTest(scene.name):
                self.assertEqual(self.segment_file(scene), expected)
                done = self.run_well("segment", "-", "--local", "--view", "world", "--json", "-",
                                     stdin=scene.read_bytes())
                self.assertEqual(json.loads(done.stdout)["segments"], 2)

    def test_every_format_out_and_in_again(self):
        scene = self.write_text("in.csv", lambda p, c: "{},{},{},{},{},{},7\n".format(*p, *c),
                                "x,y,z,red,green,blue,intensity\n")
        for end in ("pcd", "ply", "las", "csv", "xyz", "npy"):
            with self.subTest(end):
                out = self.path("out." + end)
                self.run_well("segment", scene, "--local", "--view", "world:0,0,3", "-o", out, "-q")
                again = self.path("again.csv")
                done = self.run_well("segment", out, "--local", "-o", again, "--json", "-")
                told = json.loads(done.stdout)
                self.assertEqual(told["view"], "world:0,0,3")
                self.assertEqual(told["segments"], 2)
                with open(again) as file:
                    self.assertEqual(file.readline(), "# segserve view world 0 0 3\n")
                    rows = list(csv.DictReader(file))
                self.assertEqual([int(float(row["input_label"])) for row in rows], [1] * 400 + [2] * 400)
                self.assertEqual({float(row["intensity"]) for row in rows}, {7})
                self.assertEqual(rows[0]["red"], "255")

    def test_lists_of_labels(self):
        scene = self.write_text("scene7.xyz", lambda p, c: "{} {} {} {} {} {}\n".format(*p, *c))
        segs, label = self.path("scene7.segs.json"), self.path("000000.label")
        self.run_well("segment", scene, "--local", "-o", segs, "-q")
        told = json.loads(segs.read_text())
        self.assertEqual(told["segIndices"], [1] * 400 + [2] * 400)
        self.assertTrue(told["sceneId"].endswith("scene7"))
        self.run_well("segment", scene, "--local", "-o", label, "-q")
        self.assertEqual(struct.unpack("<800I", label.read_bytes()), (1 << 16,) * 400 + (2 << 16,) * 400)
        self.run_badly(BAD_INPUT, "segment", scene, "--local", "-o", label, "--drop-unlabeled")
        self.run_badly(BAD_INPUT, "segment", scene, "--local", "-o", self.path("x.las"), "--encoding", "ascii")

    @unittest.skipUnless(numpy, "there is no NumPy")
    def test_arrays_as_numpy_has_them(self):
        points, colors = two_boxes()
        xyz, rgb = numpy.array(points, dtype="f4"), numpy.array(colors, dtype="u1")
        numpy.save(self.path("a.npy"), numpy.hstack([xyz, rgb.astype("f4")]))
        numpy.save(self.path("b.npy"), numpy.asfortranarray(numpy.hstack([xyz, rgb.astype("f4")]).astype(">f8")))
        numpy.savez(self.path("c.npz"), points=xyz, colors=rgb)
        numpy.savez_compressed(self.path("d.npz"), x=xyz[:, 0], y=xyz[:, 1], z=xyz[:, 2], rgb=rgb / 255)
        for name in ("a.npy", "b.npy", "c.npz", "d.npz"):
            with self.subTest(name):
                self.assertEqual(self.segment_file(self.path(name)), [1] * 400 + [2] * 400)
        out = self.path("out.npy")
        self.run_well("segment", self.path("c.npz"), "--local", "-o", out, "-q")
        array = numpy.load(out)
        self.assertEqual(array.dtype.names, ("x", "y", "z", "red", "green", "blue", "label"))
        self.assertEqual(array["label"].tolist(), [1] * 400 + [2] * 400)
        self.assertTrue((array["x"] == xyz[:, 0]).all())
        numpy.save(out, numpy.array([None, {}], dtype=object), allow_pickle=True)
        self.assertIn("Python objects", self.run_badly(BAD_INPUT, "segment", out, "--local"))

    @unittest.skipUnless(LAS.is_dir(), "there are no LAS files of others")
    def test_what_a_format_cannot_hold_is_told_in_json(self):
        points, colors = two_boxes()
        scene = self.path("one-is-unknown.csv")
        scene.write_text("x,y,z,intensity\nnan,nan,nan,5\n" + "".join("{},{},{},5\n".format(*p) for p in points))
        for name in ("out.las", "out.glb"):
            out = self.path(name)
            done = self.run_well("segment", scene, "--local", "-o", out, "-q", "--json", "-")
            warnings = json.loads(done.stdout)["warnings"]
            self.assertTrue(warnings and all(str(out) in w["message"] for w in warnings), warnings)
            done = segctl("segment", scene, "--local", "-o", out, "-q")
            self.assertEqual(done.stderr.decode().count(str(out)), len(warnings), done.stderr)

    def told_by(self, *arguments):
        """The warnings of a command that succeeds."""
        return json.loads(self.run_well("segment", *arguments, "--local", "-q", "--json", "-").stdout)["warnings"]

    def test_what_was_in_millimeters_is_read_again_in_millimeters(self):
        points, _ = two_boxes()
        rows = "".join("{:g},{:g},{:g}\n".format(*(1000 * v for v in p)) for p in points)
        named, plain = self.path("named.csv"), self.path("plain.csv")
        named.write_text("x_mm,y_mm,z_mm\n" + rows)
        plain.write_text("x,y,z\n" + rows)
        for scene, flags in ((named, ()), (plain, ("--unit", "mm"))):
            for end in ("pcd", "ply", "las", "csv", "xyz", "npy"):
                with self.subTest(scene=scene.name, end=end):
                    out = self.path("out." + end)
                    self.told_by(scene, "-o", out, *flags)
                    self.assertIn("taken as mm, as the file says", self.told_by(out)[0]["message"])
                    self.assertEqual(self.told_by(out, "--unit", "mm"), [])
                    info = json.loads(self.run_well("info", out, "--json", "-").stdout)
                    self.assertEqual(info["unit"]["taken"], "mm")

    def test_a_unit_that_is_given_wins_over_that_of_a_pcd_that_is_sent_as_it_is(self):
        scene = self.path("mm.pcd")
        points, _ = two_boxes()
        scene.write_text("# segserve unit mm\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 800\nHEIGHT 1\n"
                         "POINTS 800\nDATA ascii\n" + "".join("{} {} {}\n".format(*p) for p in points))
        _, in_meters = self.segment(scene, "--codec", "pcd", "--unit", "m", "-q")
        self.assertEqual(in_meters["segments"], 2)
        self.assertEqual([w for w in in_meters["warnings"] if "taken as" in w["message"]], [])

    def test_the_rows_of_an_organized_cloud_are_mentioned_if_they_are_not_kept(self):
        scene = self.path("organized.pcd")
        scene.write_text("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 40\nHEIGHT 20\nPOINTS 800\nDATA ascii\n" +
                         "".join(f"{0.004 * (i % 40)} {0.004 * (i // 40)} 1\n" for i in range(800)))
        for end in ("ply", "las", "csv", "xyz"):
            out = self.path("out." + end)
            self.assertIn("the rows and columns of the organized cloud (40 x 20)", self.told_by(scene, "-o", out)[0]["message"])
        for end in ("pcd", "npy", "label", "segs.json"):
            self.assertEqual(self.told_by(scene, "-o", self.path("out." + end)), [])
        self.assertEqual(self.told_by(scene), [])

    def test_integers_that_ply_rounds_are_mentioned(self):
        scene = self.path("stamps.csv")
        points, _ = two_boxes()
        scene.write_text("x,y,z,stamp\n" + "".join("{},{},{},1700000000123456789\n".format(*p) for p in points))
        self.assertIn("800 of 800 values of 'stamp' are rounded", self.told_by(scene, "-o", self.path("out.ply"))[0]["message"])
        for end in ("pcd", "las", "csv", "npy"):
            self.assertEqual(self.told_by(scene, "-o", self.path("out." + end)), [])

    def test_las_files_of_others(self):
        out = self.path("out.las")
        for name in ("1.2-with-color.las", "test1_4.las", "spec_3.las"):
            with self.subTest(name):
                done = segctl("segment", LAS / name, "--local", "--voxel-resolution", "1", "--seed-resolution", "10", "-o",
                              out, "-q")
                self.assertEqual(done.returncode, SUCCESS, done.stderr)
                self.assertTrue(out.read_bytes().startswith(b"LASF"))
        for name, words in (("simple.laz", "las2las"), ("1.2-with-color.copc.laz", "COPC"), ("A4.e57", "E57"),
                            ("spurious.las", "latitudes and longitudes")):
            self.assertIn(words, self.run_badly(BAD_INPUT, "segment", LAS / name, "--local"))


if __name__ == "__main__":
    unittest.main()
