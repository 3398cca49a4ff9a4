# SPDX-License-Identifier: Apache-2.0
"""segctl cut makes any cut of a saved result, without the server."""
import json
import unittest

from harness import BAD_INPUT, EndToEnd
import pcd


class Cut(EndToEnd):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        case = cls("run_well")
        cls.scene, cls.result = cls.folder / "scene.pcd", cls.folder / "scene.segres"
        case.run_well("synth", "-o", cls.scene, "-q", "--width", "200", "--height", "150")
        case.run_well("segment", cls.scene, "-q", "--server", cls.server.address, "--result", cls.result)

    def test_equals_segmenting_with_that_cut(self):
        for cut in (("--threshold", "0"), ("--threshold", "0.05"), ("--threshold", "0.4"), ("--threshold", "1"),
                    ("--regions", "1"), ("--regions", "9"), ("--regions", "1000000")):
            with self.subTest(cut=cut):
                output = self.path("cut.pcd")
                done = self.run_well("cut", self.result, *cut, "--cloud", self.scene, "-o", output, "--json", "-")
                labels, told = self.segment(self.scene, *cut)
                self.assertEqual(pcd.read_labels(output), labels)
                cut_told = json.loads(done.stdout)
                for key in ("points", "finite", "supervoxels", "segments", "method", "threshold", "regions", "lambda"):
                    self.assertEqual(cut_told[key], told[key], key)

    def test_a_local_run_saves_the_same_tree(self):
        local = self.path("local.segres")
        self.run_well("segment", self.scene, "-q", "--local", "--result", local)
        cuts = [json.loads(self.run_well("cut", result, "--threshold", "0.2", "--json", "-").stdout)
                for result in (local, self.result)]
        self.assertEqual(cuts[0]["segment_points"], cuts[1]["segment_points"])

    def test_reads_standard_input(self):
        done = self.run_well("cut", "-", "--regions", "3", "--json", "-", stdin=self.result.read_bytes())
        self.assertEqual(json.loads(done.stdout)["segments"], 3)

    def test_needs_exactly_one_cut_in_range(self):
        for cut in ((), ("--threshold", "0.1", "--regions", "3"), ("--threshold", "-1"), ("--threshold", "nan"),
                    ("--regions", "0"), ("--regions", "2.5"), ("--regions", "-3")):
            with self.subTest(cut=cut):
                self.run_badly(BAD_INPUT, "cut", self.result, *cut)

    def test_refuses_files_that_are_no_result(self):
        content = self.result.read_bytes()
        bad = {"empty": b"", "foreign": self.scene.read_bytes(), "truncated": content[:-10], "header only": content[:30],
               "longer": content + b"\n", "damaged": content[:500] + b"\x00\x01" + content[502:]}
        for name, content in bad.items():
            with self.subTest(name):
                path = self.path("bad.segres")
                path.write_bytes(content)
                self.assertIn(str(path), self.run_badly(BAD_INPUT, "cut", path, "--regions", "3"))
        self.run_badly(BAD_INPUT, "cut", self.path("missing.segres"), "--regions", "3")

    def test_describes_the_segments_of_the_new_cut(self):
        done = self.run_well("cut", self.result, "--regions", "7", "--cloud", self.scene, "--segments", "--json", "-")
        _, told = self.segment(self.scene, "--regions", "7", "--segments")
        expected = [segment | {"normal": None} for segment in told["segment_statistics"]]
        self.assertEqual(json.loads(done.stdout)["segment_statistics"], expected)
        for flags in (("--json", "-"), ("--cloud", self.scene)):
            line = self.run_badly(BAD_INPUT, "cut", self.result, "--regions", "7", "--segments", *flags)
            self.assertIn("--segments needs --cloud", line)

    def test_refuses_another_scenes_cloud(self):
        other = self.synth("--width", "100", "--height", "100")
        output = self.path("out.pcd")
        line = self.run_badly(BAD_INPUT, "cut", self.result, "--regions", "3", "--cloud", other, "-o", output)
        self.assertIn("10000 points", line)
        self.assertFalse(output.exists())
        self.run_badly(BAD_INPUT, "cut", self.result, "--regions", "3", "-o", output)  # no cloud at all


if __name__ == "__main__":
    unittest.main()
