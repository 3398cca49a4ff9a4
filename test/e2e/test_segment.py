# SPDX-License-Identifier: Apache-2.0
"""segctl segment gives the same result with and without the server, for every format of files."""
import json
import struct
import unittest

from harness import BAD_INPUT, FAILED, SUCCESS, EndToEnd, segctl
import pcd

SMALL = ("--width", "160", "--height", "120")


class LocalAndRemote(EndToEnd):
    def outputs(self, scene, *flags):
        """The bytes of all output files."""
        cloud, picture = self.path("out.pcd"), self.path("out.png")
        self.run_well("segment", scene, "-o", cloud, "--picture", picture, "--quiet", *flags)
        return cloud.read_bytes(), picture.read_bytes()

    def test_give_the_same_files_byte_for_byte(self):
        scene = self.synth("--seed", "11")
        local = self.outputs(scene, "--local")
        for payload in ((), ("--zstd",), ("--codec", "pcd")):
            with self.subTest(payload=payload):
                self.assertEqual(self.outputs(scene, "--server", self.server.address, *payload), local)

    def test_agree_for_every_method_and_cut(self):
        scene = self.synth(*SMALL)
        info = json.loads(self.run_well("info", "--server", self.server.address, "--json", "-").stdout)
        methods = [method["name"] for method in info["methods"]]
        self.assertIn("lambda-convex", methods)
        for method in methods:
            for cut in ((), ("--regions", "7"), ("--threshold", "0.3")):
                with self.subTest(method=method, cut=cut):
                    flags = ("--method", method, *cut)
                    remote, told = self.segment(scene, *flags)
                    self.assertEqual((remote, told["method"]), (self.segment_locally(scene, *flags)[0], method))

    def test_agree_on_a_fused_room(self):
        scene = self.synth("--fused", "--points", "30000")
        flags = ("--voxel-resolution", "0.03", "--seed-resolution", "0.3")
        self.assertEqual(self.segment(scene, *flags)[0], self.segment_locally(scene, *flags)[0])


class Formats(EndToEnd):
    def test_every_encoding_gives_the_same_labels(self):
        scene = self.synth(*SMALL)
        expected, _ = self.segment(scene)
        self.assertGreater(max(expected), 1)
        for name, encoding in (("a.pcd", "ascii"), ("b.pcd", "binary"), ("c.pcd", "binary_compressed"),
                               ("a.ply", "ascii"), ("b.PLY", "binary")):
            with self.subTest(name=name, encoding=encoding):
                copy = self.path(name)
                self.run_well("segment", scene, "--local", "--json", "-", "-o", copy, "--encoding", encoding)
                labels, _ = self.segment(copy, "--view", "camera")  # PLY files do not tell the view.
                self.assertEqual(labels, expected)

    def test_big_endian_ply_gives_the_same_labels(self):
        points = [(0.01 * (i % 20), 0.01 * (i // 20), 1.0 + 0.1 * (i % 20 > 9)) for i in range(400)]
        head = ("ply\nformat binary_big_endian 1.0\nelement vertex 400\nproperty float x\nproperty float y\n"
                "property float z\nend_header\n")
        ply, plain = self.path("big.ply"), self.path("plain.pcd")
        ply.write_bytes(head.encode() + b"".join(struct.pack(">3f", *p) for p in points))
        plain.write_bytes(pcd.binary_file(points))
        self.assertEqual(self.segment(ply, "--view", "world")[0], self.segment(plain, "--view", "world")[0])

    def test_standard_streams(self):
        scene = self.synth(*SMALL)
        named = self.path("named.pcd")
        self.run_well("segment", scene, "--local", "-q", "-o", named)
        piped = self.run_well("segment", "-", "--local", "-o", "-", stdin=scene.read_bytes())
        self.assertEqual(piped.stdout, named.read_bytes())

    def test_the_own_color_is_kept_unless_asked_otherwise(self):
        scene = self.path("red.pcd")
        scene.write_bytes(pcd.ascii_file([(0.01 * i, 0.0, 1.0) for i in range(50)], [0xFF0000] * 50))
        own, painted = self.path("own.pcd"), self.path("painted.pcd")
        self.run_well("segment", scene, "--local", "-q", "-o", own, "--encoding", "ascii")
        self.run_well("segment", scene, "--local", "-q", "-o", painted, "--encoding", "ascii", "--color", "segment")
        self.assertIn(b"rgb label", own.read_bytes())
        rows = [line.split() for line in own.read_text().split("DATA ascii\n")[1].splitlines()]
        colors = [line.split()[3] for line in painted.read_text().split("DATA ascii\n")[1].splitlines()]
        self.assertEqual(len(rows), 50)
        self.assertNotEqual([row[3] for row in rows], colors)

    def test_points_without_a_segment_can_be_left_out(self):
        scene = self.synth(*SMALL)
        flags = ("--support-plane-distance", "0.01")
        labels, told = self.segment_locally(scene, *flags)
        x, y, z, color = pcd.read_points(scene)
        kept = [i for i, label in enumerate(labels) if label > 0]
        self.assertTrue(0 < len(kept) < told["finite"])
        result = self.path("scene.segres")
        self.run_well("segment", scene, "--local", "-q", *flags, "--result", result)
        for command in (("segment", scene, "--local", *flags), ("cut", result, "--cloud", scene, "--threshold", told["threshold"])):
            objects = self.path("objects.pcd")
            self.run_well(*command, "-q", "-o", objects, "--drop-unlabeled")
            self.assertEqual(pcd.read_labels(objects), [labels[i] for i in kept])
            self.assertEqual(pcd.read_points(objects), [[channel[i] for i in kept] for channel in (x, y, z, color)])
        ply = self.path("objects.ply")
        self.run_well("segment", scene, "--local", "-q", *flags, "-o", ply, "--drop-unlabeled", "--encoding", "ascii")
        self.assertIn(f"element vertex {len(kept)}\n", ply.read_text())

    def test_a_picture_is_a_png(self):
        scene, picture = self.synth(*SMALL), self.path("segments.png")
        self.run_well("segment", scene, "--local", "-q", "--picture", picture)
        content = picture.read_bytes()
        self.assertEqual(content[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">2I", content[16:24]), (160, 120))


class Summary(EndToEnd):
    KEYS = {"points", "finite", "supervoxels", "segments", "method", "threshold", "timings_ms"}

    def test_json_tells_everything_promised(self):
        scene = self.synth(*SMALL)
        for where in (("--local",), ("--server", self.server.address)):
            labels, told = self._segment(scene, "--method", "lambda-convex", *where)
            self.assertLessEqual(self.KEYS, told.keys())
            self.assertEqual(told["points"], 160 * 120)
            self.assertEqual(told["finite"], sum(label > 0 for label in labels))
            self.assertEqual(told["segments"], max(labels))
            self.assertEqual((told["method"], told["threshold"], told["regions"]), ("lambda-convex", 0.15, None))
            self.assertEqual(told["view"], "camera")
            self.assertGreater(told["timings_ms"]["total"], 0)

    def test_a_preset_says_what_kind_of_cloud_it_is(self):
        sweep, table = self.synth("--lidar", "32", "--street", name="sweep.pcd"), self.path("sweep.xyz")
        fields, body = pcd.read_binary(sweep)
        points = struct.iter_unpack("<3f" + "4x" * (len(fields) - 3), body)
        table.write_text("".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points))  # tells of no sensor
        for where in (("--local",), ("--server", self.server.address)):
            labels, told = self._segment(table, "--preset", "lidar", *where)
            self.assertEqual((told["resolution"]["reason"], told["warnings"]), ("sweep", []))
            self.assertTrue(labels == self._segment(sweep, *where)[0])
            _, told = self._segment(self.synth(*SMALL), "--view", "world", "--preset", "tabletop", *where)
            self.assertEqual((told["view"], told["view_rule"]), ("camera", "preset tabletop"))
            _, told = self._segment(self.synth(*SMALL), "--preset", "room", *where)
            self.assertEqual([warning["reason"] for warning in told["warnings"]], ["PRESET_NOT_FIT"])
            line = self.run_badly(BAD_INPUT, "segment", table, "--preset", "kitchen", *where)
            self.assertIn("preset: 'kitchen' is not one of auto, tabletop, room, lidar, scan", line)
            line = self.run_badly(BAD_INPUT, "segment", self.synth(*SMALL), "--preset", "lidar", *where)
            self.assertIn("'lidar' needs a WORLD view", line)

    def test_falls_back_to_this_process_if_told_to(self):
        scene = self.synth(*SMALL)
        expected, _ = self.segment_locally(scene)
        labeled = self.path("labeled.pcd")
        flags = ("segment", scene, "-o", labeled, "--json", "-", "--fallback-local", "--server")
        done = segctl(*flags, "127.0.0.1:1")
        self.assertEqual(done.returncode, SUCCESS)
        self.assertEqual(done.stderr.decode(), "segctl: no server is in reach at 127.0.0.1:1: segmented in this process\n")
        self.assertIsNone(json.loads(done.stdout)["server"])
        self.assertEqual(pcd.read_labels(labeled), expected)
        done = self.run_well(*flags, self.server.address)
        self.assertEqual(json.loads(done.stdout)["server"], self.server.address)
        self.run_badly(FAILED, "segment", scene, "--server", "127.0.0.1:1", "--timeout", "2")
        line = self.run_badly(BAD_INPUT, "segment", scene, "--local", "--fallback-local")
        self.assertIn("--local asks no server", line)

    def test_parts_are_told(self):
        scene = self.synth(*SMALL)
        _, whole = self.segment(scene)
        self.assertEqual((whole["segmented"], whole["support_plane"]), (whole["finite"], None))
        for flags in (("--crop-min-x", "-0.1", "--crop-max-y", "0.1"), ("--range-min", "0.5", "--range-max", "1")):
            labels, told = self.segment(scene, *flags)
            self.assertEqual(told["finite"], whole["finite"])
            self.assertEqual(told["segmented"], sum(label > 0 for label in labels))
            self.assertLess(told["segmented"], told["finite"])
            self.assertGreater(told["segmented"], 0)
            self.assertEqual(labels, self.segment_locally(scene, *flags)[0])

    def test_the_support_plane_is_told(self):
        scene = self.synth(*SMALL)
        flags = ("--support-plane-distance", "0.01")
        labels, told = self.segment(scene, *flags)
        plane = told["support_plane"]
        self.assertEqual(told["segmented"], sum(label > 0 for label in labels))
        self.assertEqual(told["segmented"] + plane["points"], told["finite"])
        self.assertGreater(plane["points"], told["finite"] / 2)
        self.assertAlmostEqual(sum(n * n for n in plane["normal"]), 1)
        here, also_told = self.segment_locally(scene, *flags)
        self.assertEqual((labels, plane), (here, also_told["support_plane"]))
        said = self.run_well("segment", scene, "--local", *flags).stdout.decode()
        self.assertIn(f"support plane removed: {plane['points']} points", said)
        none = self.run_well("segment", scene, "--local", "--view", "world:0,0,0", *flags).stdout.decode()
        self.assertIn("no support plane found", none)

    def test_segments_are_described(self):
        scene = self.synth(*SMALL)
        labels, told = self.segment(scene, "--segments")
        segments = told["segment_statistics"]
        self.assertEqual([s["label"] for s in segments], list(range(1, told["segments"] + 1)))
        self.assertEqual([s["points"] for s in segments], told["segment_points"])
        self.assertGreater(told["timings_ms"]["segments"], 0)
        x, y, z, color = pcd.read_points(scene)
        for s in segments:
            mine = [i for i, label in enumerate(labels) if label == s["label"]]
            for axis, values in enumerate((x, y, z)):
                self.assertAlmostEqual(s["centroid"][axis], sum(values[i] for i in mine) / len(mine), places=6)
            self.assertAlmostEqual(s["color"][2], sum(color[i] & 255 for i in mine) / len(mine), places=6)
            for axis, half in zip(s["box"]["axes"], s["box"]["half_extents"]):
                along = [sum(a * (v[i] - c) for a, v, c in zip(axis, (x, y, z), s["box"]["center"])) for i in mine]
                self.assertAlmostEqual(max(along), half, places=6)
                self.assertAlmostEqual(min(along), -half, places=6)
        normal, centroid = segments[0]["normal"], segments[0]["centroid"]
        self.assertLess(sum(n * c for n, c in zip(normal, centroid)), 0, "it faces the camera")
        self.assertEqual(self.segment_locally(scene, "--segments")[1]["segment_statistics"], segments)
        self.assertNotIn("segment_statistics", self.segment(scene)[1])

    def test_descriptions_of_segments_need_a_place_to_go(self):
        line = self.run_badly(BAD_INPUT, "segment", self.synth(*SMALL), "--local", "--segments")
        self.assertIn("--segments needs --json, --result or --out-dir", line)

    def test_threshold_is_null_after_a_cut_at_regions(self):
        labels, told = self.segment(self.synth(*SMALL), "--regions", "6")
        self.assertEqual((told["threshold"], told["regions"], told["segments"], max(labels)), (None, 6, 6, 6))

    def test_segments_are_numbered_by_descending_size(self):
        labels, told = self.segment(self.synth(*SMALL))
        sizes = [labels.count(s) for s in range(1, told["segments"] + 1)]
        self.assertEqual(sizes, sorted(sizes, reverse=True))
        self.assertEqual(sizes, told["segment_points"])

    def test_json_goes_to_a_file_beside_the_text(self):
        target = self.path("summary.json")
        done = self.run_well("segment", self.synth(*SMALL), "--local", "--json", target)
        self.assertEqual(json.loads(target.read_text())["points"], 160 * 120)
        self.assertIn(b"19200 points", done.stdout)

    def test_the_view_is_the_files_or_the_callers(self):
        scene = self.synth(*SMALL)
        self.assertEqual(self.segment(scene, "--view", "world:0,0,-0.5")[1]["view"], "world:0,0,-0.5")
        for payload in ("planar", "pcd"):
            self.assertIn("CAMERA", self.segment(scene, "--codec", payload)[1]["view_rule"])


if __name__ == "__main__":
    unittest.main()
