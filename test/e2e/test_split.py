# SPDX-License-Identifier: Apache-2.0
"""--split writes each segment as a file, and --drop-unlabeled leaves the rest out."""
import json
import unittest

from harness import BAD_INPUT, FAILED, EndToEnd
import pcd

SMALL = ("--width", "160", "--height", "120")


class Split(EndToEnd):
    """One file a segment."""

    def setUp(self):
        self.scene, self.parts = self.synth(*SMALL), self.path("made") / "parts"

    def rows(self, path):
        """The points with label, as bytes; NaN compares equal then."""
        fields, body = pcd.read_binary(path)
        size = 4 * len(fields)
        return [body[i:i + size] for i in range(0, len(body), size)]

    def check(self, *command):
        whole = self.path("whole.pcd")
        told = json.loads(self.run_well(*command, "-o", whole, "--split", f"{self.parts}/", "--json", "-").stdout)
        files = sorted(self.parts.iterdir())
        self.assertEqual([path.name for path in files], [f"segment_{i:04}.pcd" for i in range(1, told["segments"] + 1)])
        labels, rows = pcd.read_labels(whole), self.rows(whole)
        for label, path in enumerate(files, 1):
            self.assertEqual(self.rows(path), [row for row, of in zip(rows, labels) if of == label])
        view = [line for line in whole.read_bytes()[:400].split(b"\n") if line.startswith(b"VIEWPOINT")]
        self.assertIn(view[0], files[0].read_bytes()[:400])
        return told

    def test_has_the_points_of_each_segment(self):
        result = self.path("saved.segres")
        self.check("segment", self.scene, "--local", "--support-plane-distance", "0.01")
        many = self.check("segment", self.scene, "--server", self.server.address, "--threshold", "0.1", "--result", result)
        few = self.check("cut", result, "--regions", "4", "--cloud", self.scene)
        self.assertLess(few["segments"], many["segments"], "files of the cut before are gone")

    def test_leaves_other_files_alone(self):
        self.parts.mkdir(parents=True)
        others = ("segment_9.pcd", "segment_0900.ply", "segment_x.pcd", "notes.txt")
        for name in others:
            (self.parts / name).write_text("mine")
        (self.parts / "segment_0900.pcd").write_text("old")
        self.run_well("segment", self.scene, "--local", "-q", "--regions", "2", "--split", self.parts)
        self.assertEqual({path.name for path in self.parts.iterdir()}, {"segment_0001.pcd", "segment_0002.pcd", *others})

    def test_writes_nothing_if_something_fails(self):
        before = set(self.folder.rglob("*"))
        self.run_badly(FAILED, "segment", self.scene, "--local", "--split", self.parts, "--result", "/dev/full")
        self.assertEqual(set(self.folder.rglob("*")), before)
        line = self.run_badly(BAD_INPUT, "segment", self.scene, "--local", "--split", self.scene / "x")
        self.assertIn(f"{self.scene} is a file", line)
        line = self.run_badly(BAD_INPUT, "segment", self.scene, "--out-dir", self.parts, "--split", self.parts)
        self.assertRegex(line, "--out-dir .*exclude.* --split")

    def test_writes_no_file_for_each_point(self):
        points = [(float(i % 110), float(i // 110), 0.0) for i in range(110 * 110)]
        self.scene.write_bytes(pcd.binary_file(points))  # as if meters were millimeters
        line = self.run_badly(BAD_INPUT, "segment", self.scene, "--local", "--view", "world", "--split", self.parts,
                              "--voxel-resolution", "0.0075")
        self.assertRegex(line, "--split writes at most 10000 files, but there are [0-9]+ segments")
        self.assertFalse(self.parts.exists())

    def test_unlabeled_points_are_left_out_of_every_output(self):
        for name in ("out.pcd", "out.ply"):
            output = self.path(name)
            self.run_well("segment", self.scene, "--local", "-q", "-o", output, "--encoding", "ascii",
                          "--support-plane-distance", "0.01", "--drop-unlabeled")
            header = "DATA ascii\n" if name.endswith("pcd") else "end_header\n"
            rows = output.read_text().split(header)[1].splitlines()
            self.assertGreater(len(rows), 100)
            self.assertTrue(all(int(row.split()[-1]) > 0 for row in rows))


if __name__ == "__main__":
    unittest.main()
