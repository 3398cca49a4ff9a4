# SPDX-License-Identifier: Apache-2.0
"""segctl segment on many files runs in parallel and goes on where it was stopped, and a bad file stops no other."""
import json
import os
import pathlib
import unittest

from harness import BAD_INPUT, FAILED, SUCCESS, EndToEnd, Server, segctl
import pcd

SMALL = ("--width", "160", "--height", "120")


class Batch(EndToEnd):
    def setUp(self):
        self.inputs, self.outputs = self.path("in"), self.path("out")
        self.inputs.mkdir()
        self.outputs.mkdir()
        for seed in range(1, 5):
            self.run_well("synth", "-o", self.inputs / f"scene{seed}.pcd", "-q", "--seed", seed, *SMALL)
        self.run_well("synth", "-o", self.inputs / "last.ply", "--json", "-", "--seed", 9, *SMALL)
        (self.inputs / "notes.txt").write_text("not a cloud, not an input")

    def batch(self, *flags, where=None):
        where = ("--server", self.server.address) if where is None else where
        return segctl("segment", self.inputs, "--out-dir", self.outputs, "--json", "-", *where, *flags)

    def lines(self, done):
        return [json.loads(line) for line in done.stdout.decode().splitlines()]

    def states(self, done):
        return {pathlib.Path(line["input"]).name: line["state"] for line in self.lines(done)}

    def contents(self):
        return {path.name: path.read_bytes() for path in self.outputs.iterdir() if path.suffix == ".pcd"}

    def test_a_pose_is_kept_or_its_loss_is_told(self):
        pose, lost = b"VIEWPOINT 1 2 3 0.5 -0.5 0.5 -0.5\n", "VIEWPOINT is not kept"
        scene, parts = self.inputs / "scene1.pcd", self.path("parts")
        scene.write_bytes(scene.read_bytes().replace(b"VIEWPOINT 0 0 0 1 0 0 0\n", pose))
        for view, is_lost in (("camera", False), ("world:0,0,-1", True)):
            done = self.batch("--view", view, where=("--local",))
            self.assertEqual(done.returncode, SUCCESS, done.stderr)
            line = next(line for line in self.lines(done) if line["input"].endswith("scene1.pcd"))
            summary = json.loads((self.outputs / "scene1.json").read_bytes())
            split = self.run_well("segment", scene, "--local", "--view", view, "--split", parts, "--json", "-").stdout
            for told in (line, summary, json.loads(split)):
                self.assertEqual(lost in json.dumps(told["warnings"]), is_lost, told["warnings"])
            for file in (self.outputs / "scene1.pcd", parts / "segment_0001.pcd"):
                self.assertEqual(pose in file.read_bytes(), not is_lost)

    def test_gives_what_one_by_one_gives_with_and_without_server(self):
        done = self.batch()
        self.assertEqual((done.returncode, done.stderr), (SUCCESS, b""))
        self.assertEqual(set(self.states(done).values()), {"segmented"})
        self.assertEqual(sorted(path.name for path in self.outputs.iterdir()),
                         sorted(f"{stem}.{kind}" for stem in ("scene1", "scene2", "scene3", "scene4", "last")
                                for kind in ("pcd", "json")))
        for name in ("scene1.pcd", "scene4.pcd", "last.ply"):
            expected, _ = self.segment_locally(self.inputs / name)
            self.assertEqual(pcd.read_labels(self.outputs / f"{pathlib.Path(name).stem}.pcd"), expected)
        through_server = self.contents()
        for path in self.outputs.iterdir():
            path.unlink()
        done = self.batch("--parallel", "3", where=("--local",))
        self.assertEqual((done.returncode, done.stderr), (SUCCESS, b""))
        self.assertEqual(self.contents(), through_server)

    def test_describes_segments_in_the_summaries(self):
        self.batch("--segments")
        told = json.loads((self.outputs / "scene2.json").read_text())
        expected = self.segment_locally(self.inputs / "scene2.pcd", "--segments")[1]["segment_statistics"]
        self.assertEqual(told["segment_statistics"], expected)
        self.assertEqual(set(self.states(self.batch("--segments", where=("--local",))).values()), {"skipped"})
        self.assertEqual(set(self.states(self.batch()).values()), {"segmented"}, "it is asked for something else")

    def test_falls_back_to_this_process_if_told_to(self):
        nobody = ("--server", "127.0.0.1:1", "--fallback-local")
        done = self.batch(*nobody, where=())
        self.assertEqual(done.returncode, SUCCESS)
        self.assertEqual(done.stderr.decode(), "segctl: no server is in reach at 127.0.0.1:1: segmented in this process\n")
        self.assertEqual(set(self.states(done).values()), {"segmented"})
        self.assertIsNone(json.loads((self.outputs / "scene1.json").read_text())["server"])
        here = self.contents()
        for path in self.outputs.iterdir():
            path.unlink()
        done = self.batch("--fallback-local")
        self.assertEqual((done.returncode, done.stderr), (SUCCESS, b""), "a server that is in reach is asked")
        self.assertEqual(json.loads((self.outputs / "scene1.json").read_text())["server"], self.server.address)
        self.assertEqual(self.contents(), here)

    def test_describes_segments_if_it_falls_back(self):
        done = self.batch("--segments", "--server", "127.0.0.1:1", "--fallback-local", where=())
        self.assertEqual(done.returncode, SUCCESS)
        self.assertEqual(set(self.states(done).values()), {"segmented"})
        told = json.loads((self.outputs / "scene2.json").read_text())
        expected = self.segment_locally(self.inputs / "scene2.pcd", "--segments")[1]["segment_statistics"]
        self.assertEqual(told["segment_statistics"], expected)

    def test_goes_on_where_it_stopped(self):
        self.batch()
        (self.outputs / "scene2.pcd").unlink()
        (self.outputs / "scene3.json").write_text('{"batch": ')  # No run of segctl leaves such a file.
        done = self.batch()
        self.assertEqual(self.states(done), {"last.ply": "skipped", "scene1.pcd": "skipped", "scene2.pcd": "segmented",
                                             "scene3.pcd": "segmented", "scene4.pcd": "skipped"})
        self.assertEqual(set(self.states(self.batch()).values()), {"skipped"})
        self.assertEqual(set(self.states(self.batch("--regions", "5")).values()), {"segmented"})
        self.assertEqual(set(self.states(self.batch("--regions", "5", where=("--local",))).values()), {"skipped"})
        self.assertEqual(set(self.states(self.batch("--codec", "quantised")).values()), {"segmented"})
        through_server = self.contents()
        for path in self.outputs.glob("*.json"):
            path.unlink()
        self.assertEqual(set(self.states(self.batch("--codec", "quantised", where=("--local",))).values()), {"segmented"})
        self.assertEqual(self.contents(), through_server)

    def test_a_bad_file_stops_no_other_and_is_told_at_the_end(self):
        (self.inputs / "scene2.pcd").write_bytes(b"# .PCD v0.7\nno cloud")
        os.symlink(self.path("nowhere"), self.inputs / "broken.pcd")
        for where in (None, ("--local",)):
            with self.subTest(where=where):
                done = self.batch(where=where)
                self.assertEqual(done.returncode, BAD_INPUT)
                states = self.states(done)
                self.assertEqual((states.pop("scene2.pcd"), states.pop("broken.pcd")), ("failed", "failed"))
                self.assertEqual(set(states.values()) - {"skipped"}, {"segmented"} if where is None else set())
                errors = done.stderr.decode().splitlines()
                self.assertEqual(len(errors), 3)
                self.assertEqual(sorted(line.split("/")[-1].split(": ")[0] for line in errors[:2]), ["broken.pcd", "scene2.pcd"])
                self.assertEqual(errors[2], "segctl: 2 of 6 files failed")
                self.assertFalse((self.outputs / "scene2.pcd").exists())

    def test_an_error_of_one_cloud_comes_from_the_server_too(self):
        (self.inputs / "behind.pcd").write_bytes(pcd.binary_file([(0.0, 0.0, -1.0), (0.0, 0.0, 1.0)] * 4))
        done = self.batch("--view", "camera")
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertEqual(self.states(done)["behind.pcd"], "failed")
        self.assertEqual(self.states(done)["scene1.pcd"], "segmented")

    def test_an_output_that_cannot_be_written_is_a_failure(self):
        (self.outputs / "scene3.pcd").mkdir()
        done = self.batch()
        self.assertEqual(self.states(done)["scene3.pcd"], "failed")
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertEqual(sorted(path.name for path in self.outputs.iterdir() if "tmp" in path.name), [])

    def test_without_server_nothing_is_tried(self):
        line = self.run_badly(FAILED, "segment", self.inputs, "--out-dir", self.outputs, "--server", "127.0.0.1:1")
        self.assertIn("no answer from 127.0.0.1:1", line)
        self.assertEqual(list(self.outputs.iterdir()), [])
        missing = self.path("missing")
        self.run_badly(FAILED, "segment", self.inputs, "--out-dir", missing, "--server", "127.0.0.1:1")
        self.assertFalse(missing.exists())

    def test_makes_the_output_folder_if_it_is_missing(self):
        missing = self.path("missing") / "labels"
        self.run_well("segment", self.inputs, "--out-dir", missing, "--local")
        self.assertEqual(len(list(missing.glob("*.pcd"))), 5)

    def test_files_that_were_done_before_tell_their_counts(self):
        first, second = self.lines(self.batch()), self.lines(self.batch())
        self.assertEqual({line["state"] for line in second}, {"skipped"})
        for key in ("input", "output", "points", "segments"):
            self.assertEqual([line[key] for line in first], [line[key] for line in second])
        self.assertEqual({line["points"] for line in second}, {160 * 120})

    def test_another_format_is_another_output(self):
        self.batch("--support-plane-distance", "0.01")
        whole = self.contents()
        done = self.batch("--support-plane-distance", "0.01", "--drop-unlabeled", "--color", "segment")
        self.assertEqual(set(self.states(done).values()), {"segmented"})
        self.assertEqual(self.contents().keys(), whole.keys())
        for path in self.outputs.glob("*.pcd"):
            labels = pcd.read_labels(path)
            self.assertNotIn(0, labels)
            self.assertLess(len(labels), 160 * 120)
        done = self.batch("--support-plane-distance", "0.01", "--drop-unlabeled", "--color", "segment")
        self.assertEqual(set(self.states(done).values()), {"skipped"})

    def test_two_servers_and_one_stops(self):
        other = Server(self.folder)
        self.addCleanup(other.close)
        other.terminate()
        done = self.batch(where=("--server", f"{other.address},{self.server.address}"))
        self.assertEqual((done.returncode, done.stderr), (SUCCESS, b""))
        self.assertEqual(set(self.states(done).values()), {"segmented"})

    def test_wrong_usage(self):
        scene = self.inputs / "scene1.pcd"
        twin = self.inputs / "scene1.PCD"
        twin.write_bytes(b"")
        for arguments, said in (((scene, scene), "--out-dir"), ((scene, "--out-dir", scene, "--local"), "cannot make the folder"),
                                ((scene, "--out-dir", scene / "x", "--local"), "cannot make the folder"),
                                ((scene, twin, "--out-dir", self.outputs), "both be written"),
                                ((scene, "--out-dir", self.inputs), "overwritten"),
                                ((self.outputs, "--out-dir", self.outputs),
                                 f"no file of a cloud in {self.outputs}: none whose name ends in .pcd, .ply, .las, .xyz, .txt, .csv, .pts, "
                                 ".obj, .npy, .npz or .bin, also compressed as .gz or .zst;"),
                                ((self.path("none"), "--out-dir", self.outputs), "there is no"),
                                (("-", "--out-dir", self.outputs), "standard input"),
                                ((scene, "--out-dir", self.outputs, "-o", "x.pcd"), "--out-dir and --contact-sheet exclude"),
                                ((scene, "--parallel", "2"), "--out-dir")):
            with self.subTest(said=said):
                self.assertIn(said, self.run_badly(BAD_INPUT, "segment", *arguments))


if __name__ == "__main__":
    unittest.main()
