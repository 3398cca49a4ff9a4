# SPDX-License-Identifier: Apache-2.0
"""segctl bench with loads that change, faults, files for other tools, and the metrics of the server."""
import csv
import json
import os
import pathlib
import signal
import socket
import subprocess
import time
import unittest

import node_packages
from harness import BAD_INPUT, FAILED, SEGCTL, SUCCESS, EndToEnd, segctl
from scrape import Scrape
from test_metrics import MeasuredServer

SMALL = ("--size", "80x60", "--scenes", "2", "--warm-up", "0.2", "--encoded-beforehand", "--json", "-")
HDR_LOG = pathlib.Path(__file__).parent / "clients" / "hdr_log.js"


class LoadTest(EndToEnd):
    def bench(self, *flags):
        return json.loads(self.run_well("bench", "--server", self.server.address, *SMALL, *flags).stdout)


class Schedules(LoadTest):
    def test_steps_are_points(self):
        told = self.bench("--steps", "10,30:1s", "--objective", "p50<60s")
        self.assertEqual([point["label"] for point in told["points"]], ["10 frames/s", "30 frames/s"])
        for point, rate in zip(told["points"], (10, 30)):
            self.assertAlmostEqual(point["offered_frames_per_s"], rate, delta=1.1)
            self.assertEqual(point["verdict"], "met")
        self.assertAlmostEqual(told["frames"]["sent"], 40, delta=1)
        self.assertAlmostEqual(told["window"]["measured_s"], 2, places=3)

    def test_a_ramp_is_reported_in_ten_parts(self):
        told = self.bench("--ramp", "10:50:2s")
        self.assertEqual(len(told["points"]), 10)
        self.assertAlmostEqual(told["frames"]["sent"], 60, delta=1)
        offered = [point["offered_frames_per_s"] for point in told["points"]]
        self.assertLess(sum(offered[:5]), 0.7 * sum(offered[5:]))

    def test_a_sweep_runs_each_number_of_clients(self):
        told = self.bench("--clients", "1..3", "--duration", "0.4", "--codec", "planar,rgbd")
        self.assertEqual([point["clients"] for point in told["points"]], [1, 2, 3])
        self.assertEqual([point["label"] for point in told["points"]], ["1 client", "2 clients", "3 clients"])
        self.assertEqual(told["clients"], 3)
        self.assertEqual([row["codec"] for row in told["codecs"]], ["planar", "rgbd"])
        self.assertEqual(sum(row["results"] for row in told["codecs"]), told["frames"]["results"])
        self.assertAlmostEqual(told["window"]["measured_s"], 1.2, places=2)
        times = [entry["t"] for entry in told["timeline"] if entry["t"] >= 0]
        self.assertEqual(times, sorted(times))

    def test_a_search_tells_both_ends(self):
        told = self.bench("--search", "p90<60s", "--duration", "0.3", "--rate", "400", "--drain", "0.5")
        found = told["search"]
        self.assertEqual(found["objective"], "p90<60s")
        self.assertEqual(found["capacity_frames_per_s"], found["low"])
        self.assertGreater(found["low"], 10)
        self.assertLess(found["low"], found["high"])
        self.assertEqual(len(found["tries"]), len(told["points"]))
        self.assertEqual({point["verdict"] for point in told["points"]} - {"met", "missed", "unstable"}, set())
        self.assertAlmostEqual(told["offered_frames_per_s"], found["low"], delta=0.1 * found["low"] + 5)

    def test_a_search_for_what_cannot_be_is_a_failure(self):
        done = segctl("bench", "--server", self.server.address, *SMALL, "--search", "p50<1us", "--duration", "0.1", "--rate", "1")
        self.assertEqual(done.returncode, FAILED)
        self.assertIn("no rate met p50<1us", done.stderr.decode())
        self.assertIsNone(json.loads(done.stdout)["search"]["capacity_frames_per_s"])

    def test_windows_follow_until_they_agree(self):
        told = self.bench("--until-stable", "100%", "--duration", "0.3", "--clients", "2")
        self.assertAlmostEqual(told["window"]["measured_s"], 0.9, places=2)
        told = self.bench("--until-stable", "0.001%", "--duration", "0.1", "--clients", "2")
        self.assertIn("UNSTABLE", [finding["code"] for finding in told["findings"]])
        self.assertIn("among 10 windows of 0.1 s", told["findings"][-1]["text"])
        self.assertAlmostEqual(told["window"]["measured_s"], 0.3, places=2)

    def test_a_soak_tells_how_it_goes(self):
        done = segctl("bench", "--server", self.server.address, *SMALL, "--soak", "3s", "--interval", "0.5", "--rate", "20")
        self.assertEqual(done.returncode, SUCCESS, done.stderr)
        lines = done.stderr.decode().splitlines()
        self.assertGreaterEqual(len(lines), 6)
        for line in lines:
            self.assertRegex(line, r"min: [0-9.]+ frames/s due, [0-9.]+ results/s, 0 failed; latency ms p50 ")
        told = json.loads(done.stdout)
        self.assertEqual([entry["t"] for entry in told["timeline"]][:3], [-0.2, 0, 0.5])

    def test_wrong_loads_are_refused(self):
        for flags, said in ((("--steps", "10,20"), "10,20,40:10s"), (("--steps", "10,x:1s"), "'x' is no rate"),
                            (("--steps", "10:1y"), "500ms, 10s, 2m or 4h"), (("--ramp", "1:2"), "10:200:10s"),
                            (("--ramp", "0:2:1s"), "'0' is no rate"), (("--clients", "4..2"), "1..32"),
                            (("--clients", "1..2000"), "1..32"), (("--search", "p99"), "p99<50ms"),
                            (("--until-stable", "5"), "5%"), (("--soak", "never"), "never"),
                            (("--clients", "1..4", "--search", "p99<5ms"), "one number of --clients"),
                            (("--fault", "vanish=2,melt=1%"), "'melt' is none of"), (("--metrics", "https://x"), "http://HOST:PORT"),
                            (("--rate", "5", "--steps", "5:1s"), "--rate")):
            with self.subTest(flags=flags):
                server = ("--server", self.server.address)
                self.assertIn(said, self.run_badly(BAD_INPUT, "bench", *server, *SMALL[:-2], *flags))


class Outputs(LoadTest):
    def test_the_timeline_is_a_table(self):
        path = self.path("run.csv")
        told = self.bench("--duration", "1.5", "--rate", "20", "--csv", path)
        with open(path, newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), len(told["timeline"]))
        for row, entry in zip(rows, told["timeline"]):
            self.assertEqual(set(row), set(entry))
            self.assertEqual(int(row["results"]), entry["results"])
            if entry["p50_ms"] is not None:
                self.assertAlmostEqual(float(row["p50_ms"]), entry["p50_ms"], places=2)

    def test_others_read_the_log_of_histograms(self):
        path = self.path("run.hlog")
        told = self.bench("--duration", "2", "--rate", "40", "--hdr-log", path)
        self.assertIn("#[Histogram log format version 1.3]", path.read_text())
        modules = node_packages.installed("hdr", {"hdr-histogram-js": "3.0.1"})
        done = subprocess.run(["node", HDR_LOG, path], env={**os.environ, "NODE_PATH": str(modules)}, capture_output=True,
                              timeout=60, check=True)
        read = json.loads(done.stdout)
        self.assertGreaterEqual(read["intervals"], 2)
        counted = sum(entry["results"] for entry in told["timeline"] if entry["t"] >= 0)
        self.assertEqual(read["count"], counted)
        # The log has all results of the window, and the JSON those of frames that were due in it.
        for name in ("p50", "p90"):
            self.assertAlmostEqual(read[name] / 1000, told["latency_ms"][name], delta=0.2 * told["latency_ms"][name] + 1)
        self.assertAlmostEqual(read["max"], max(entry["max_ms"] or 0 for entry in told["timeline"] if entry["t"] >= 0), places=2)


class Faults(LoadTest):
    def test_they_are_counted_apart(self):
        told = self.bench("--duration", "4", "--rate", "60", "--fault",
                          "slow-reader=2,vanish=5%,malformed=10%,cancel=10%", "--verify")
        self.assertEqual(told["errors"], {})
        self.assertEqual(told["frames"]["results"], told["frames"]["sent"])
        self.assertEqual(told["mismatches"], 0)
        faults = told["faults"]
        self.assertEqual(faults["slow-reader"], 2)
        for kind in ("vanish", "malformed", "cancel"):
            self.assertGreater(faults[kind], 3, faults)
        self.assertNotIn("malformed_not_refused", faults)
        self.assertNotIn("malformed_failed_otherwise", faults)
        self.assertNotIn("not_connected", faults)

    def test_none_are_null(self):
        self.assertIsNone(self.bench("--duration", "0.3")["faults"])


class Metrics(LoadTest):
    def test_the_server_s_figures_stand_beside(self):
        server = MeasuredServer(self.folder)
        self.addCleanup(server.close)
        told = json.loads(self.run_well("bench", "--server", server.address, *SMALL, "--steps", "20,40:1s", "--metrics",
                                        f"127.0.0.1:{server.metrics_port}").stdout)
        metrics = told["server_metrics"]
        self.assertGreater(metrics["cpu_seconds"], 0)
        self.assertGreater(metrics["cpu_ms_per_frame"], 0)
        self.assertGreater(metrics["memory_bytes_max"], 1e6)
        self.assertLessEqual(metrics["queue_wait_ms"]["p50"], metrics["queue_wait_ms"]["p99"])
        self.assertEqual(metrics["rejected"], {})
        name = 'segserve_frames_total{call="stream",outcome="result"}'
        sent = sum(entry["sent"] for entry in told["timeline"])
        self.assertEqual(metrics["after"][name] - metrics["before"][name], sent)
        for point in told["points"]:
            self.assertGreater(point["server_cpu_ms_per_frame"], 0)
        text = self.run_well("bench", "--server", server.address, *SMALL[:-2], "--duration", "0.3", "--metrics",
                             f"http://127.0.0.1:{server.metrics_port}/metrics").stdout.decode()
        self.assertRegex(text, r"server        queue wait ms p50 [0-9.]+, p99 [0-9.]+; [0-9.]+ ms of CPU a frame; at most \d+ MB")

    def test_prometheus_can_watch_the_client(self):
        command = [SEGCTL, "bench", "--server", self.server.address, *SMALL, "--duration", "4", "--rate", "20",
                   "--metrics-listen", "127.0.0.1:0"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            port = int(process.stderr.readline().decode().strip().rsplit(":", 1)[1])
            time.sleep(2)
            scrape = Scrape(port)
            output, _ = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0)
        results = scrape.sum("segctl_bench_frames_total", outcome="result")
        self.assertTrue(0 < results <= json.loads(output)["frames"]["results"])
        self.assertEqual(scrape.sum("segctl_bench_latency_seconds_count"), results)
        self.assertEqual(scrape.sum("segctl_bench_latency_seconds_bucket", le="+Inf"), results)

    def test_no_metrics_are_an_error_before_the_run(self):
        line = self.run_badly(FAILED, "bench", "--server", self.server.address, *SMALL[:-2], "--metrics", "127.0.0.1:1")
        self.assertIn("no metrics from 127.0.0.1:1/metrics", line)


class Agents(LoadTest):
    def start_agent(self, listen="127.0.0.1:0", *flags):
        process = subprocess.Popen([SEGCTL, "bench", "--agent", listen, *flags], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.communicate, timeout=60)
        self.addCleanup(process.terminate)
        return process.stdout.readline().decode().rsplit(" ", 1)[1].strip()

    def test_they_share_the_load_and_add_up(self):
        agents = [self.start_agent(), self.start_agent()]
        path = self.path("run.hlog")
        for clients, loop in (("3", ("--rate", "30")), ("2", ()), ("1..2", ())):
            with self.subTest(clients=clients, loop=loop):
                told = self.bench("--agents", ",".join(agents), "--clients", clients, "--duration", "1", *loop, "--codec",
                                  "planar,rgbd", "--verify", "--hdr-log", path)
                path.unlink()
                frames = told["frames"]
                self.assertEqual(told["errors"], {})
                self.assertEqual((told["verified"], told["mismatches"]), (frames["results"], 0))
                self.assertEqual(sum(count for _, count in told["latency_histogram"]["buckets"]), frames["results"])
                self.assertEqual(sum(row["results"] for row in told["codecs"]), frames["results"])
                if loop:
                    self.assertAlmostEqual(frames["sent"], 30, delta=1)
                    self.assertEqual(len(told["results_of_client"]), 3)
                if clients == "1..2":
                    self.assertEqual([point["clients"] for point in told["points"]], [1, 2])
                window = [entry for entry in told["timeline"] if entry["t"] == 0]
                self.assertGreater(window[0]["results"], 0)
                self.assertLessEqual(window[0]["p50_ms"], window[0]["p99_ms"])

    def test_an_interrupt_reaches_them(self):
        command = [SEGCTL, "bench", "--server", self.server.address, *SMALL, "--agents", self.start_agent(), "--soak", "1h"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            time.sleep(3)
            process.send_signal(signal.SIGINT)
            output, errors = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130, errors)
        self.assertGreater(json.loads(output)["frames"]["results"], 0)

    def test_what_goes_wrong_there_is_told_here(self):
        agent = self.start_agent()
        flags = ("bench", "--server", self.server.address, "--agents")
        self.assertIn("agent 127.0.0.1:1: Connection refused", self.run_badly(FAILED, *flags, "127.0.0.1:1"))
        self.assertIn("it must be HOST:PORT", self.run_badly(BAD_INPUT, *flags, "nowhere"))
        host, port = agent.rsplit(":", 1)
        for line, said in ((b"nonsense\n", b"no JSON object"), (b'{"segserve_bench_agent": 9}\n', b"another version"),
                           (b'{"segserve_bench_agent": 2, "arguments": ["--input", "/no/such.pcd"]}\n', b"/no/such.pcd"),
                           (b'{"segserve_bench_agent": 2, "arguments": ["--melt"]}\n', b"--melt")):
            with socket.create_connection((host, int(port)), timeout=30) as connection:
                connection.sendall(line)
                reader = connection.makefile("rb")
                self.assertEqual(json.loads(reader.readline())["asks_for_proof"], False)
                self.assertIn(said, reader.readline())
        self.assertGreater(self.bench("--agents", agent, "--duration", "0.5")["frames"]["results"], 0)

    def test_an_agent_beyond_this_machine_has_a_secret(self):
        line = self.run_badly(BAD_INPUT, "bench", "--agent", "0.0.0.0:0")
        self.assertIn("--agent-token-file admits only who has its secret, --agent-for-anyone admits all", line)
        short = self.path("short")
        short.write_text("1234\n")
        for said, *flags in (("holds a secret of 4 bytes", "--agent", "127.0.0.1:0", "--agent-token-file", short),
                             ("--agent-token-file does not go with --agent-for-anyone", "--agent", "0.0.0.0:0", "--agent-token-file",
                              short, "--agent-for-anyone"),
                             ("--agent-token-file needs --agents or --agent", "--agent-token-file", short)):
            self.assertIn(said, self.run_badly(BAD_INPUT, "bench", *flags))

    def test_only_who_knows_the_secret_gets_work_done(self):
        right, wrong = self.path("right"), self.path("wrong")
        right.write_text("a secret of some length\n")
        wrong.write_text("another secret of some length\n")
        agent = self.start_agent("0.0.0.0:0", "--agent-token-file", right).replace("0.0.0.0", "127.0.0.1")
        load = ("bench", "--server", self.server.address, *SMALL, "--agents", agent, "--duration", "0.5")
        self.assertIn("it asks for a secret: --agent-token-file names", self.run_badly(FAILED, *load))
        self.assertIn("this agent has another secret", self.run_badly(FAILED, *load, "--agent-token-file", wrong))
        told = self.bench("--agents", agent, "--duration", "0.5", "--agent-token-file", right)
        self.assertGreater(told["frames"]["results"], 0)
        host, port = agent.rsplit(":", 1)
        heard = []
        for proof in ({}, {"proof": ""}, {"proof": "0" * 64}, {"proof": 3}):
            with socket.create_connection((host, int(port)), timeout=30) as connection:
                reader = connection.makefile("rb")
                heard.append(json.loads(reader.readline()))
                connection.sendall(json.dumps({"segserve_bench_agent": 2, "arguments": []} | proof).encode() + b"\n")
                self.assertIn(b"another secret", reader.readline())
                self.assertEqual(reader.readline(), b"")
        self.assertEqual(len({greeting["challenge"] for greeting in heard}), len(heard))
        self.assertNotIn("a secret", json.dumps(heard))


if __name__ == "__main__":
    unittest.main()
