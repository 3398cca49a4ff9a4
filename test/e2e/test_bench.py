# SPDX-License-Identifier: Apache-2.0
"""segctl bench measures a real server, checks its labels, and judges by objectives."""
import json
import os
import subprocess
import unittest

from harness import BAD_INPUT, FAILED, EndToEnd, Server, segctl

SMALL = ("--size", "160x120", "--scenes", "2", "--warm-up", "0.2")
EXAMPLE_STREAM = os.environ["EXAMPLE_STREAM"]


class Bench(EndToEnd):
    def bench(self, *flags):
        return ("bench", "--server", self.server.address, *SMALL, *flags)

    def test_a_closed_loop_measures_and_verifies(self):
        done = self.run_well(*self.bench("--clients", "3", "--duration", "2", "--verify", "--json", "-", "--objective",
                                         "p99<60s", "--objective", "errors<=0%"))
        told = json.loads(done.stdout)
        self.assertGreater(told["frames"]["results"], 3)
        self.assertEqual(told["frames"]["sent"], told["frames"]["results"])
        self.assertEqual((told["verified"], told["mismatches"]), (told["frames"]["results"], 0))
        self.assertEqual([o["met"] for o in told["objectives"]], [True, True])
        latency = told["latency_ms"]
        self.assertTrue(0 < latency["p50"] <= latency["p90"] <= latency["p99"] <= latency["p99.9"] <= latency["max"])
        self.assertAlmostEqual(sum(ms for stage, ms in told["stages_ms"].items() if stage != "total"),
                               told["stages_ms"]["total"], places=6)
        self.assertGreater(told["bytes_up"] / told["frames"]["results"], 160 * 120 * 15)
        self.assertGreater(told["client_cpu_ms_per_frame"], 0)

    def test_an_open_loop_offers_its_rate(self):
        for arrivals in ("constant", "poisson"):
            with self.subTest(arrivals=arrivals):
                done = self.run_well(*self.bench("--rate", "10", "--arrivals", arrivals, "--clients", "2",
                                                 "--duration", "2", "--codec", "planar-zstd", "--json", "-"))
                told = json.loads(done.stdout)
                self.assertEqual((told["loop"], told["arrivals"]), ("open", arrivals))
                self.assertGreater(told["frames"]["sent"], 4)
                if arrivals == "constant":
                    self.assertAlmostEqual(told["frames"]["sent"], 20, delta=1)

    def test_a_missed_objective_is_a_failure_and_the_figures_come_all_the_same(self):
        done = segctl(*self.bench("--duration", "0.5", "--objective", "fps>=1", "--objective", "p50<1us"))
        self.assertEqual(done.returncode, FAILED)
        self.assertIn("p50<1us: MISSED", done.stdout.decode())
        self.assertRegex(done.stderr.decode(), r"\Asegctl: missed: p50<1us \(reached [0-9.]+\)\n\Z")

    def test_frames_of_a_lossy_codec_are_verified_as_the_server_decodes_them(self):
        for codec in ("quantised", "rgbd"):
            with self.subTest(codec=codec):
                done = self.run_well(*self.bench("--codec", codec, "--duration", "0.5", "--verify", "--json", "-"))
                told = json.loads(done.stdout)
                self.assertEqual((told["verified"], told["mismatches"]), (told["frames"]["results"], 0))
                self.assertGreater(told["verified"], 0)

    def test_clients_take_the_codecs_in_turn(self):
        done = self.run_well(*self.bench("--codec", "planar,rgbd", "--clients", "3", "--duration", "1", "--verify",
                                         "--objective", "least-share>0%", "--json", "-"))
        told = json.loads(done.stdout)
        self.assertEqual(told["codec"], "planar, rgbd")
        self.assertEqual(len(told["results_of_client"]), 3)
        self.assertEqual(sum(told["results_of_client"]), told["verified"])
        self.assertEqual(told["mismatches"], 0)

    def test_files_are_frames_too(self):
        scene = self.synth("--width", "160", "--height", "120")
        done = self.run_well("bench", "--server", self.server.address, "--input", scene, "--duration", "0.5",
                             "--warm-up", "0", "--encoded-beforehand", "--verify")
        self.assertIn(", 0 differ", done.stdout.decode())

    def test_figures_of_nothing_are_null(self):
        server = Server(self.folder, "--max-points", "100")
        self.addCleanup(server.close)
        flags = ("bench", "--server", server.address, *SMALL, "--duration", "0.3")
        done = segctl(*flags, "--json", "-")
        self.assertEqual(done.returncode, FAILED)
        self.assertIn("no frame got a result", done.stderr.decode())
        told = json.loads(done.stdout)
        self.assertEqual(told["frames"]["results"], 0)
        for part in ("latency_ms", "since_sent_ms", "stages_ms"):
            self.assertEqual(set(told[part].values()), {None}, part)
        self.assertIsNone(told["client_cpu_ms_per_frame"])
        self.assertIsNone(told["least_share_percent"])
        self.assertIn("latency ms    no results", segctl(*flags).stdout.decode())

    def test_no_server_is_a_failure(self):
        line = self.run_badly(FAILED, "bench", "--server", "127.0.0.1:1", *SMALL, "--duration", "0.3")
        self.assertIn("no answer from 127.0.0.1:1", line)

    def test_wrong_usage(self):
        for flags, said in ((("--objective", "p99=5"), "p99<50ms"), (("--objective", "p42<5ms"), "p42"),
                            (("--size", "640"), "WIDTHxHEIGHT"), (("--arrivals", "poisson"), "--rate"),
                            (("--verify", "--outputs", "tree"), "labels"), (("--clients", "0"), "--clients"), (("--seed", "-1"), "--seed: -1 is negative"),
                            (("--codec", "none"), "--codec"), (("--codec", "planar,pcd", "--zstd"), "--zstd"),
                            (("--codec", "planar,pcd", "--error-bound", "1"), "--error-bound")):
            with self.subTest(flags=flags):
                self.assertIn(said, self.run_badly(BAD_INPUT, "bench", *flags))


class Example(EndToEnd):
    def test_the_example_of_a_stream_gets_an_outcome_for_every_frame(self):
        done = subprocess.run([EXAMPLE_STREAM, self.server.address], capture_output=True, timeout=120, check=True)
        lines = done.stdout.decode().splitlines()
        self.assertEqual([line.split(":")[0] for line in lines], [f"frame {i}" for i in range(1, 21)])
        self.assertRegex(done.stdout.decode(), r"frame \d+: \d+ segments")


if __name__ == "__main__":
    unittest.main()
