# SPDX-License-Identifier: Apache-2.0
"""segctl bench diff compares saved load tests, and its exit code judges for CI."""
import json
import pathlib
import shutil
import tempfile
import unittest

from harness import BAD_INPUT, FAILED, SUCCESS, segctl
import bench_files


class BenchDiff(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-bench-diff-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.before = cls.write("before", bench_files.load_test(bench_files.lognormal_seconds(1)))

    @classmethod
    def write(cls, name, told):
        path = cls.folder / f"{name}.json"
        path.write_text(json.dumps(told))
        return path

    def diff(self, after, *flags):
        return segctl("bench", "diff", self.before, self.write(self.id(), after), *flags)

    def test_an_equal_run_is_no_worse(self):
        done = self.diff(bench_files.load_test(bench_files.lognormal_seconds(2)))
        self.assertEqual((done.returncode, done.stderr), (SUCCESS, b""))
        lines = done.stdout.decode().splitlines()
        self.assertEqual([line.split(",")[0] for line in lines[1:7]],
                         ["throughput", "p50", "p95", "p99", "errors", "CPU of segctl"])
        for line in lines[1:4]:
            self.assertTrue(line.endswith(" same"), line)

    def test_a_slower_run_is_worse_unless_that_is_allowed(self):
        slower = bench_files.load_test(bench_files.lognormal_seconds(2, scale=1.15))
        done = self.diff(slower, "--allow", "10%", "--json", "-")
        self.assertEqual(done.returncode, FAILED)
        self.assertRegex(done.stderr.decode(), r"\Asegctl: worse: p50 by \+1\d\.\d %, p95 by .* \(10 % is allowed\)\n\Z")
        told = json.loads(done.stdout)
        p50 = told["rows"][1]
        self.assertEqual((told["verdict"], p50["figure"], p50["verdict"]), ("worse", "p50", "worse"))
        self.assertAlmostEqual(p50["change_percent"], 15, delta=3)
        self.assertTrue(10 < p50["interval"][0] < p50["change_percent"] < p50["interval"][1] < 20, p50)
        self.assertEqual(p50["interval_from"], "histogram")
        self.assertEqual(self.diff(slower, "--allow", "30").returncode, SUCCESS)

    def test_failing_frames_are_worse(self):
        seconds = bench_files.lognormal_seconds(2)
        done = self.diff(bench_files.load_test([s[:-2] for s in seconds], [2] * len(seconds)))
        self.assertEqual(done.returncode, FAILED)
        self.assertIn("p99 by infinite", done.stderr.decode())
        self.assertRegex(done.stderr.decode(), r"errors by \+3\.\d+ points")

    def test_another_load_cannot_be_compared(self):
        other = bench_files.load_test(bench_files.lognormal_seconds(2), clients=8, codec="rgbd")
        done = self.diff(other)
        self.assertEqual((done.returncode, done.stdout), (BAD_INPUT, b""))
        self.assertIn("cannot be compared: clients: 4 and 8; codec: 'planar' and 'rgbd'", done.stderr.decode())

    def test_caveats_are_told(self):
        other = bench_files.load_test(bench_files.lognormal_seconds(2), findings=[{"code": "X", "text": "The\x1b run was unstable."}])
        other["host"]["cpus"] = 64
        text = self.diff(other).stdout.decode()
        self.assertIn("the number of CPUs is another one: 2 and 64\nthe second load test says: The? run was unstable.\n", text)

    def test_wrong_usage(self):
        for flags, said in ((("--allow", "much"), "--allow: 'much' is no percentage from 0% to 1000%"),
                            (("--confidence", "100%"), "no percentage from 50% to 99.9%"), (("--seed", "-1"), "negative")):
            with self.subTest(flags=flags):
                done = self.diff(bench_files.load_test(bench_files.lognormal_seconds(2)), *flags)
                self.assertEqual(done.returncode, BAD_INPUT)
                self.assertIn(said, done.stderr.decode())
        done = segctl("bench", "diff", self.before, self.folder / "missing.json")
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertIn("missing.json", done.stderr.decode())


if __name__ == "__main__":
    unittest.main()
