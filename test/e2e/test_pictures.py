# SPDX-License-Identifier: Apache-2.0
"""Pictures of segctl: segments with a legend, from other places, merge trees and contact sheets."""
import json
import struct
import unittest

import png
from harness import BAD_INPUT, EndToEnd, segctl

SMALL = ("--width", "160", "--height", "120")
BACKGROUND, CUT = (0x18, 0x18, 0x1B), (0x7C, 0xC4, 0xFF)


def size(content):
    return struct.unpack(">2I", content[16:24])


class Pictures(EndToEnd):
    def picture(self, scene, *flags, command="segment", where=("--local",)):
        path = self.path("picture.png")
        self.run_well(command, scene, *where, "-q", *flags, path)
        return path.read_bytes()

    def test_a_legend_stands_beside_the_same_picture(self):
        scene = self.synth(*SMALL)
        plain = png.read_rgb8(self.picture(scene, "--picture"))
        width, height, rows = png.read_rgb8(self.picture(scene, "--legend", "--picture"))
        self.assertEqual(plain[:2], (160, 120))
        self.assertGreater(width, 160 + 150)
        self.assertGreaterEqual(height, 120)
        self.assertEqual([row[:20] for row in rows[:20]], [row[:20] for row in plain[2][:20]])
        self.assertGreater(len({pixel for row in rows for pixel in row[160:]}), 3, "it has swatches and text")

    def test_pictures_are_the_same_with_and_without_server(self):
        scene = self.synth(*SMALL)
        flags = ("--legend", "--picture")
        self.assertEqual(self.picture(scene, *flags), self.picture(scene, *flags, where=("--server", self.server.address)))

    def test_another_place_is_another_picture(self):
        scene, lidar = self.synth(*SMALL), self.synth("--lidar", "16", "--columns", "256", name="lidar.pcd")
        for cloud in (scene, lidar):
            seen = {self.picture(cloud, "--view-from", place, "--picture") for place in ("3,0,1", "0,-4,2.5", "0,-4,-2")}
            self.assertEqual(len(seen), 3)
            for content in seen:
                self.assertEqual(size(content), (960, 720))
        self.assertEqual(size(self.picture(lidar, "--picture")), (960, 720))

    def test_the_place_is_in_the_coordinates_of_the_file(self):
        near, far = self.path("near.xyz"), self.path("far.xyz")
        points = [(0.01 * x, 0.01 * y, 0.02 * ((x // 20 + y // 20) % 2)) for x in range(60) for y in range(60)]
        for path, east, north in ((near, 0, 0), (far, 500_000, 4_000_000)):
            path.write_text("".join(f"{x + east:.2f} {y + north:.2f} {z:.2f}\n" for x, y, z in points))
        first = png.read_rgb8(self.picture(near, "--view-from", "2,-1,1.5", "--plain-picture"))
        second = png.read_rgb8(self.picture(far, "--view-from", "500002,3999999,1.5", "--plain-picture"))
        pairs = [(a, b) for row_a, row_b in zip(first[2], second[2]) for a, b in zip(row_a, row_b)]
        differing = sum((a == BACKGROUND) != (b == BACKGROUND) for a, b in pairs)
        self.assertLess(differing, 0.01 * len(pairs))
        self.assertGreater(sum(a != BACKGROUND for a, _ in pairs), 0.1 * len(pairs))

    def test_a_merge_tree_has_its_cut(self):
        scene, result = self.synth(*SMALL), self.path("scene.segres")
        tree = self.picture(scene, "--result", result, "--dendrogram")
        self.assertEqual(size(tree), (1440, 900))
        for where in (("--server", self.server.address),):
            self.assertEqual(self.picture(scene, "--dendrogram", where=where), tree)
        told = json.loads(self.run_well("segment", scene, "--local", "--json", "-").stdout)
        same_cut = ("--threshold", told["threshold"], "--cloud", scene, "--dendrogram")
        self.assertEqual(self.picture(result, *same_cut, command="cut", where=()), tree)
        other = self.picture(result, "--regions", "5", "--dendrogram", command="cut", where=())
        self.assertNotEqual(other, tree)

    def test_tells_what_is_wrong(self):
        scene = self.synth(*SMALL)
        for said, *flags in (("--view-from 1,2: must be X,Y,Z", "--picture", "x.png", "--view-from", "1,2"),
                             ("--view-from 1,2,x: must be", "--picture", "x.png", "--view-from", "1,2,x"),
                             ("--view-from 1,2,3,4: must be", "--picture", "x.png", "--view-from", "1,2,3,4"),
                             ("--view-from nan,0,0: must be", "--picture", "x.png", "--view-from", "nan,0,0"),
                             ("--legend needs --picture", "--legend"),
                             ("for the pictures of one cloud", "--out-dir", self.path("out"), "--view-from", "1,2,3"),
                             ("for the pictures of one cloud", "--contact-sheet", "x.png", "--legend"),
                             ("--picture x.jpg: a picture is written as PNG, so that the name must end in .png", "--picture", "x.jpg"),
                             ("--plain-picture x.PDF: a picture is written as PNG", "--plain-picture", "x.PDF"),
                             ("--dendrogram x.json: a picture is written as PNG", "--dendrogram", "x.json"),
                             ("--contact-sheet x.jpeg: a picture is written as PNG", "--contact-sheet", "x.jpeg"),
                             ("--view-from is empty", "--picture", "x.png", "--view-from", ""),
                             ("no/tree.png", "--dendrogram", self.folder / "no/tree.png"),
                             ("--dendrogram", "--out-dir", self.path("out"), "--dendrogram", "x.png")):
            with self.subTest(said=said):
                self.assertIn(said, self.run_badly(BAD_INPUT, "segment", scene, "--local", *flags))


class ContactSheet(EndToEnd):
    def setUp(self):
        self.inputs = self.path("in")
        self.inputs.mkdir()
        for seed in range(1, 6):
            self.run_well("synth", "-o", self.inputs / f"scene{seed}.pcd", "-q", "--seed", seed, *SMALL)
        (self.inputs / "broken.ply").write_text("ply\nformat ascii 1.0\n")

    def sheet(self, *flags):
        path = self.path("sheet.png")
        done = segctl("segment", self.inputs, "--local", "--json", "-", "--contact-sheet", path, *flags)
        return path.read_bytes(), done

    def test_shows_every_file_without_an_output_folder(self):
        (self.inputs / "broken.ply").unlink()
        content, done = self.sheet()
        self.assertEqual((done.returncode, done.stderr), (0, b""))
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        self.assertEqual([line["state"] for line in lines], ["segmented"] * 5)
        self.assertEqual({line["output"] for line in lines}, {None})
        self.assertEqual(len(list(self.inputs.iterdir())), 5, "nothing is written beside the files")
        width, height, rows = png.read_rgb8(content)
        # Three columns and two rows of 240 x 180.
        self.assertEqual((width, height), (16 + 3 * 256, 40 + 2 * 242 + 8))
        middles = {rows[40 + 90 + 242 * row][16 + 120 + 256 * column] for row in range(2) for column in range(3)}
        self.assertGreater(len(middles), 3)
        through_server, done = self.sheet()
        self.assertEqual(through_server, content)

    def test_a_file_that_fails_keeps_its_place(self):
        content, done = self.sheet()
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertIn(b"broken.ply", done.stderr)
        self.assertEqual(size(content), (16 + 3 * 256, 40 + 2 * 242 + 8))

    def test_files_that_were_done_before_are_drawn_too(self):
        (self.inputs / "broken.ply").unlink()
        first, _ = self.sheet("--out-dir", self.path("out"))
        again, done = self.sheet("--out-dir", self.path("out"))
        self.assertEqual({json.loads(line)["state"] for line in done.stdout.splitlines()}, {"skipped"})
        self.assertEqual(again, first)

    def test_wrong_usage(self):
        scene = self.inputs / "scene1.pcd"
        for said, *flags in (("exclude -o", scene, "-o", "x.pcd"), ("no/x.png", scene, "--contact-sheet", self.folder / "no/x.png"),
                             ("no file of a cloud", self.path("empty")), ("--track excludes", self.inputs, "--track")):
            if said.startswith("no file"):
                flags[0].mkdir()
            sheet = () if "--contact-sheet" in flags else ("--contact-sheet", "x.png")
            with self.subTest(said=said):
                self.assertIn(said, self.run_badly(BAD_INPUT, "segment", *flags, *sheet, "--local"))


if __name__ == "__main__":
    unittest.main()
