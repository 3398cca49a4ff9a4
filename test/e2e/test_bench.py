# SPDX-License-Identifier: Apache-2.0
"""segctl bench measures a real server, checks its labels, and judges by objectives."""
import json
import os
import signal
import subprocess
import time
import unittest

from harness import BAD_INPUT, FAILED, SEGCTL, EndToEnd, Server, segctl

SMALL = ("--size", "160x120", "--scenes", "2", "--warm-up", "0.2")
INTERRUPTED = 130
SLACK = float(os.environ.get("FLEET_SLACK", "1"))  # what a sanitizer adds
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
        self.assertEqual(told["results_of_server"], {self.server.address: told["frames"]["results"]})
        latency = told["latency_ms"]
        self.assertTrue(0 < latency["p50"] <= latency["p90"] <= latency["p95"] <= latency["p99"] <= latency["p99.9"] <=
                        latency["p99.99"] <= latency["max"])
        self.assertEqual(sum(count for _, count in told["latency_histogram"]["buckets"]), told["frames"]["results"])
        # A result at the very edge of the window may go to the interval beside.
        self.assertAlmostEqual(sum(entry["results"] for entry in told["timeline"] if entry["t"] >= 0), told["frames"]["finished"] +
                               sum(entry["results"] for entry in told["timeline"] if entry["t"] >= 2), delta=2)
        self.assertIn("p99.99", told["too_few_samples_for"])
        self.assertEqual(told["format"], "segserve-bench-1")
        self.assertEqual(told["command"][1], "bench")
        self.assertEqual(told["server_info"]["version"], told["client_build"]["version"])
        self.assertAlmostEqual(told["window"]["measured_s"], 2, places=3)
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

    def test_a_robot_that_drops_old_frames_says_so(self):
        done = self.run_well("bench", "--server", self.server.address, "--size", "320x240", "--scenes", "1", "--warm-up", "0",
                             "--rate", "400", "--drop-oldest", "--in-flight", "1", "--duration", "1", "--encoded-beforehand", "--json", "-")
        told = json.loads(done.stdout)
        self.assertEqual(set(told["errors"]), {"DROPPED"})
        self.assertEqual(told["errors"]["DROPPED"] + told["frames"]["results"], told["frames"]["sent"])

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
        self.assertEqual((told["verified"], told["mismatches"]), (told["frames"]["results"], 0))
        self.assertEqual([row["codec"] for row in told["codecs"]], ["planar", "rgbd"])
        for key in ("sent", "results"):
            self.assertEqual(sum(row[key] for row in told["codecs"]), told["frames"][key])
        planar, rgbd = told["codecs"]
        self.assertGreater(planar["bytes_up_per_frame"], 2 * rgbd["bytes_up_per_frame"])
        self.assertAlmostEqual(planar["frames_per_s"] + rgbd["frames_per_s"], told["frames_per_s"])

    def test_a_run_with_failures_is_no_success(self):
        server = Server(self.folder, "--max-points", "30000")
        self.addCleanup(server.close)
        small = self.synth("--width", "160", "--height", "120", name="small.pcd")
        large = self.synth("--width", "320", "--height", "240", name="large.pcd")
        flags = ("bench", "--server", server.address, "--input", small, small, large, "--duration", "0.5", "--warm-up", "0",
                 "--json", "-")
        done = segctl(*flags)
        self.assertEqual(done.returncode, FAILED)
        self.assertRegex(done.stderr.decode(), r"\d+ of \d+ frames failed .*LIMIT_EXCEEDED.*errors<=1%")
        told = json.loads(done.stdout)
        failed = told["frames"]["failed"]
        self.assertGreater(failed, 0)
        self.assertEqual(told["latency_histogram"]["failed"], failed)
        self.assertIsNotNone(told["latency_ms"]["p50"])
        self.assertIsNone(told["latency_ms"]["p90"], "it is that of a failed frame")
        self.assertEqual(told["latency_beyond"], ["p90", "p95", "p99", "p99.9", "p99.99"])
        self.assertIn("FAILURES", self.codes(told))
        self.run_well(*flags, "--objective", "errors<=40%")
        missed = segctl(*flags, "--objective", "errors<=40%", "--objective", "p99<60s")
        self.assertEqual(missed.returncode, FAILED)
        self.assertIn("missed: p99<60s (frames failed)", missed.stderr.decode())

    def test_a_run_ends_when_it_says(self):
        began = time.monotonic()
        done = segctl("bench", "--server", self.server.address, "--scenes", "1", "--warm-up", "0", "--rate", "400", "--clients",
                      "2", "--in-flight", "1", "--duration", "2", "--drain", "0.5", "--encoded-beforehand", "--json", "-")
        self.assertLess(time.monotonic() - began, 6 * SLACK)
        self.assertEqual(done.returncode, FAILED)
        told = json.loads(done.stdout)
        frames = told["frames"]
        self.assertAlmostEqual(frames["sent"], 800, delta=2)
        self.assertEqual(frames["failed"], frames["sent"] - frames["results"])
        self.assertEqual(set(told["errors"]) - {"UNFINISHED", "NOT_SENT"}, set())
        self.assertLess(told["window"]["drain_s"], 1)
        self.assertIn("UNSTABLE", self.codes(told))
        # The wait in the client is part of the latency, and not of the time since a frame was sent.
        self.assertLess(self.mean(told["since_sent_histogram"]), self.mean(told["latency_histogram"]) / 2)

    @staticmethod
    def mean(histogram):
        buckets = histogram["buckets"]
        return sum(value * count for value, count in buckets) / sum(count for _, count in buckets)

    @staticmethod
    def codes(told):
        return [finding["code"] for finding in told["findings"]]

    def test_an_interrupted_run_tells_what_it_measured(self):
        command = [SEGCTL, *self.bench("--duration", "600", "--json", "-")]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            time.sleep(2)
            process.send_signal(signal.SIGINT)
            output, errors = process.communicate(timeout=30)
        self.assertEqual(process.returncode, INTERRUPTED, errors)
        told = json.loads(output)
        self.assertGreater(told["frames"]["results"], 0)
        self.assertEqual(told["errors"], {})
        self.assertIn("INTERRUPTED", self.codes(told))
        self.assertLess(told["window"]["measured_s"], 10 * SLACK)

    def test_files_are_frames_too(self):
        scene = self.synth("--width", "160", "--height", "120")
        done = self.run_well("bench", "--server", self.server.address, "--input", scene, "--duration", "0.5",
                             "--warm-up", "0", "--encoded-beforehand", "--verify")
        self.assertIn(", 0 differ", done.stdout.decode())

    def test_a_folder_with_times_is_replayed(self):
        moving = self.path("moving")
        self.run_well("synth", "--moving", moving, "-q", "--rate", "10", "--frames", "4", "--width", "160", "--height", "120")
        bench = ("bench", "--server", self.server.address, "--warm-up", "0", "--json", "-", "--input")
        told = json.loads(self.run_well(*bench, moving, "--duration", "1", "--speed", "2").stdout)
        self.assertEqual((told["loop"], told["arrivals"], told["speed"]), ("open", "recorded", 2))
        # A round of four frames takes 0.3 s + a gap of 0.1 s, halved.
        self.assertAlmostEqual(told["frames"]["sent"], 20, delta=2)
        by_name = self.path("by_name")
        by_name.mkdir()
        times = (1305031102.175304, 1305031102.225304, 1305031102.375304)
        for time, frame in zip(times, sorted(moving.glob("*.pcd"))):
            frame.rename(by_name / f"cloud_{time:.6f}.pcd")
        told = json.loads(self.run_well(*bench, by_name, "--duration", "1").stdout)
        self.assertEqual(told["arrivals"], "recorded")
        self.assertAlmostEqual(told["frames"]["sent"], 10, delta=2)  # rounds of 0.2 s + 0.1 s
        told = json.loads(self.run_well(*bench, by_name, "--duration", "0.5", "--speed", "0").stdout)
        self.assertEqual(told["loop"], "closed")
        # Without times, a folder is the clouds in it.
        (by_name / f"cloud_{times[0]:.6f}.pcd").rename(by_name / "first.pcd")
        told = json.loads(self.run_well(*bench, by_name, "--duration", "0.3").stdout)
        self.assertEqual(told["loop"], "closed")
        self.assertIn("--speed", self.run_badly(BAD_INPUT, *bench, by_name, "--speed", "2"))
        empty = self.path("empty")
        empty.mkdir()
        self.assertIn("no file of a cloud", self.run_badly(BAD_INPUT, *bench, empty))

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
                            (("--verify", "--outputs", "tree"), "labels"), (("--drop-oldest",), "--rate"), (("--clients", "0"), "--clients"), (("--seed", "-1"), "--seed: -1 is negative"),
                            (("--codec", "none"), "--codec"), (("--codec", "planar,pcd", "--zstd"), "--zstd"),
                            (("--codec", "planar,pcd,rgbd", "--clients", "2"), "3 codecs, but there are only 2 clients"),
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
