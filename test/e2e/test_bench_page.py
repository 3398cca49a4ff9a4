# SPDX-License-Identifier: Apache-2.0
"""segctl bench show writes a page in a browser, whose figures are those of the load test."""
import copy
import json
import pathlib
import shutil
import tempfile

import unittest

from harness import BAD_INPUT, SUCCESS, segctl
import bench_files
import browser

# Every table as {id: [[[text, value or null], ..] for each row]}, and the tiles as {key: value}.
READ_TABLES = """Object.fromEntries([...document.querySelectorAll('table[id]')].map((table) => [table.id, [...table.tBodies[0].rows].map(
    (row) => [...row.cells].map((cell) => [cell.textContent, 'value' in cell.dataset ? Number(cell.dataset.value) : null]))]))"""
READ_TILES = """Object.fromEntries([...document.querySelectorAll('.tile')].map((tile) => [tile.dataset.key, Number(tile.dataset.value)]))"""
READ_CHARTS = """Object.fromEntries([...document.querySelectorAll('figure')].map((figure) => [figure.id, figure.plot.data.map((list) => [...list])]))"""
# How many pixels of a chart have a color.
INK = """[...document.querySelectorAll('figure canvas')].map((canvas) => { const bytes = canvas.getContext('2d').getImageData(0, 0,
    canvas.width, canvas.height).data; let ink = 0; for (let i = 3; i < bytes.length; i += 4) ink += bytes[i] > 0; return ink; })"""


class BenchPage(browser.PageTest):
    @classmethod
    def setUpClass(cls):
        done = segctl("bench", "show", "missing.json", "--html", "-")
        if b"was built without its pages" in done.stderr:
            raise unittest.SkipTest("segctl was built without npm: there is no page to test")
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-bench-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.start_browser()

    def show(self, told):
        """The path of the page of a load test."""
        path, page = self.folder / f"{self.id()}.json", self.folder / f"{self.id()}.html"
        path.write_text(json.dumps(told))
        done = segctl("bench", "show", path, "--html", page)
        self.assertEqual(done.returncode, SUCCESS, done.stderr.decode())
        return page

    def test_the_figures_of_the_page_are_those_of_the_load_test(self):
        told = bench_files.eventful()
        tables, tiles, charts, ink, search = self.open(self.show(told), ["settle"], ["run", READ_TABLES], ["run", READ_TILES],
                                                       ["run", READ_CHARTS], ["run", INK], ["text", "#search"])[1:]
        frames = told["frames"]
        self.assertEqual(tiles, {
            "achieved_frames_per_s": told["achieved_frames_per_s"], "latency_ms.p50": told["latency_ms"]["p50"],
            "latency_ms.p99": told["latency_ms"]["p99"], "errors_percent": 100 * (frames["sent"] - frames["results"]) / frames["sent"],
            "mpoints_per_s": told["mpoints_per_s"], "client_cpu_ms_per_frame": 3.2, "server_metrics.cpu_ms_per_frame": 28.4})

        def values(table, *columns):
            return [[row[c][1] for c in columns] for row in tables[f"table-{table}"]]

        timeline = told["timeline"]
        self.assertEqual(values("latency-timeline", 1, 2, 3, 4),
                         [[second[key] for key in ("p50_ms", "p90_ms", "p99_ms", "max_ms")] for second in timeline])
        self.assertEqual(charts["chart-latency"],
                         [[second[key] for second in timeline] for key in ("t", "p50_ms", "p90_ms", "p99_ms", "max_ms")])
        self.assertEqual(charts["chart-throughput"][1:],
                         [[second[key] for second in timeline] for key in ("offered", "sent", "results", "failed")])
        self.assertEqual(values("latency", 1), [[told["latency_ms"][name]] for name in
                                                ("p50", "p90", "p95", "p99", "p99.9", "p99.99", "max", "mean")])
        self.assertEqual(tables["table-latency"][4][1][0], "∞")  # It falls among failed frames.
        self.assertEqual(values("points", 1, 2, 5, 6), [[point["clients"], point["achieved_frames_per_s"], point["latency_ms"]["p50"],
                                                        point["latency_ms"]["p99"]] for point in told["points"]])
        self.assertEqual(charts["chart-load"][:2], [[p["clients"] for p in told["points"]],
                                                    [p["achieved_frames_per_s"] for p in told["points"]]])
        stages = told["stages_ms"]
        split = values("split", 1, 2, 3, 4, 5)[0]
        self.assertAlmostEqual(split[0], stages["client_encode"] + stages["client_wait"] + stages["client_decode"])
        self.assertEqual([split[1], split[3], split[4]], [stages["queue"], stages["rest"], stages["total"]])
        self.assertAlmostEqual(sum(split[:4]), stages["total"])
        self.assertEqual({row[0][0]: row[2][1] for row in tables["table-stages"]}, stages)
        self.assertEqual({row[0][0]: row[1][1] for row in tables["table-errors"]}, told["errors"])
        self.assertEqual(search, "64.1 frames/s met p99<100ms, and 65.6 frames/s missed it. The search took 2 tries.")
        self.assertEqual([row[0][0] for row in tables["table-codecs"]], ["planar", "rgbd"])
        self.assertEqual(values("codecs", 2, 8), [[codec["results"], codec["bytes_up_per_frame"]] for codec in told["codecs"]])
        self.assertEqual(values("clients", 0, 1)[0], [6, 195])  # the least served
        self.assertEqual(values("clients", 0, 1)[-1], [5, 232])
        metrics = {row[0][0]: row[1][1] for row in tables["table-server-metrics"]}
        self.assertEqual((metrics["queue wait p99, ms"], metrics["rejected: QUEUE_FULL"], metrics["most memory"]), (40.2, 4, 350_000_000))
        self.assertEqual(len(ink), 6)
        self.assertTrue(all(count > 1000 for count in ink), ink)

    def test_the_percentile_curve_tells_the_percentiles(self):
        told = bench_files.eventful()
        tables, charts = self.open(self.show(told), ["settle"], ["run", READ_TABLES], ["run", READ_CHARTS])[1:]
        rows = {row[0][0]: row[1][1] for row in tables["table-percentile-curve"]}
        for percent, name in (("50 %", "p50"), ("90 %", "p90"), ("95 %", "p95"), ("99 %", "p99")):
            self.assertAlmostEqual(rows[percent], told["latency_ms"][name], delta=0.002 * told["latency_ms"][name])
        x, intended, _ = charts["chart-percentiles"]
        self.assertEqual(x, sorted(x))
        steps = [(at, ms) for at, ms in zip(x, intended) if ms is not None]
        at_p90 = [ms for at, ms in steps if at <= 10][-1]
        self.assertAlmostEqual(at_p90, told["latency_ms"]["p90"], delta=0.002 * at_p90)
        # It ends at the share of the frames that failed, 11 of 1,811.
        self.assertAlmostEqual(steps[-1][0], 1811 / 11)

    def test_each_codec_of_a_capacity_page_has_a_line(self):
        told = bench_files.eventful()
        planar = [point | {"codec": "planar"} for point in told["points"]]
        told["points"] = [point | {"codec": "rgbd", "achieved_frames_per_s": 5.0 + k, "clients": 2 * point["clients"]}
                          for k, point in enumerate(told["points"])] + planar
        charts, labels = self.open(self.show(told), ["settle"], ["run", READ_CHARTS],
                                   ["run", "document.getElementById('chart-load').plot.series.map((series) => series.label)"])[1:]
        self.assertEqual(labels, ["clients", "planar", "rgbd"])
        clients, of_planar, of_rgbd = charts["chart-load"]
        self.assertEqual(clients, [1, 2, 4, 8, 16, 32])
        self.assertEqual(of_planar[:5], [point["achieved_frames_per_s"] for point in planar])
        self.assertEqual(of_rgbd[1:], [5, 6, 7, 8, 9])

    def test_findings_stand_at_the_top_in_words(self):
        told = bench_files.eventful()
        text, first = self.open(self.show(told), ["settle"], ["text", "#findings"],
                                ["run", "document.getElementById('report').firstElementChild.id"])[1:]
        for finding in told["findings"]:
            self.assertIn(finding["text"], text)
        self.assertEqual(first, "findings")
        quiet = self.open(self.show(bench_files.load_test(bench_files.lognormal_seconds(1))), ["settle"], ["text", "#findings"],
                          ["text", "#no-errors"])
        self.assertEqual(quiet[1:], ["Nothing speaks against these figures.", "Every frame got its result."])

    def test_names_are_text_and_nothing_else(self):
        hostile = "</script><script>alert(1)</script><img src=x onerror=alert(2)><!--"
        told = bench_files.eventful()
        told["server"] = told["codec"] = told["host"]["name"] = told["host"]["cpu_model"] = told["client_build"]["version"] = hostile
        told["codecs"][0]["codec"] = told["points"][0]["label"] = told["search"]["objective"] = hostile
        told["findings"][0] = {"code": hostile, "text": hostile}
        told["objectives"][0]["objective"] = hostile
        told["errors"] = {hostile: 11}
        told["faults"] = told["results_of_server"] = {hostile: 3, "b": 4}
        told["command"] = ["segctl", "bench", hostile]
        told["stages_ms"][hostile] = 1.0
        told["server_info"] = {hostile: {hostile: hostile}, "list": [{"name": hostile}, {hostile: 1}]}
        told["server_metrics"]["rejected"] = told["server_metrics"]["before"] = {hostile: 1}
        page = self.show(told)
        self.assertNotIn("<img", page.read_text())
        answers = self.open(page, ["settle"], ["run", "document.querySelectorAll('img, iframe, object, embed, link, base').length"],
                            ["run", "document.scripts.length"], ["run", "document.title"], ["text", "#table-errors"],
                            ["text", "#findings"], ["text", "#command"])
        self.assertEqual(answers[1:4], [0, 2, f"Load test of {hostile} - segctl bench"])
        for text in answers[4:6]:
            self.assertIn(hostile, text)
        self.assertEqual(answers[6], f"segctl bench '{hostile}'")

    def test_keys_of_objects_are_no_properties_of_the_language(self):
        told = bench_files.load_test(bench_files.lognormal_seconds(1))
        told["errors"] = {"__proto__": 3, "constructor": 4}
        told["stages_ms"] |= {"toString": 2.0, "__proto__": 1.0}
        rows = self.open(self.show(told), ["settle"], ["run", READ_TABLES])[1]
        self.assertEqual({row[0][0]: row[1][1] for row in rows["table-errors"]}, told["errors"])
        self.assertEqual({row[0][0]: row[2][1] for row in rows["table-stages"]}, told["stages_ms"])

    def test_a_phone_is_wide_enough_and_both_color_schemes_are_drawn(self):
        color = ["run", "getComputedStyle(document.body).backgroundColor"]
        width = ["run", "[document.documentElement.scrollWidth, innerWidth]"]
        answers = self.open(self.show(bench_files.eventful()), ["settle"], width, ["media", {"colorScheme": "dark"}], color,
                            ["media", {"colorScheme": "light"}], color, size=(400, 800))
        self.assertLessEqual(*answers[1])
        self.assertEqual([answers[3], answers[5]], ["rgb(20, 22, 26)", "rgb(255, 255, 255)"])

    def test_paper_is_light(self):
        answers = self.open(self.show(bench_files.eventful()), ["media", {"colorScheme": "dark"}], ["settle"],
                            ["run", "dispatchEvent(new Event('beforeprint')) && getComputedStyle(document.body).backgroundColor"],
                            ["run", "dispatchEvent(new Event('afterprint')) && getComputedStyle(document.body).backgroundColor"])
        self.assertEqual(answers[2:], ["rgb(255, 255, 255)", "rgb(20, 22, 26)"])

    def test_the_page_gives_the_json_back(self):
        told = bench_files.eventful()
        name = self.open(self.show(told), ["settle"], ["download", "#save-json"])[1]
        self.assertEqual(json.loads((self.folder / self.id() / name).read_text()), told)

    def test_a_load_test_without_a_result_is_shown_as_such(self):
        told = bench_files.load_test([[], [], []], [5, 5, 5])
        told["stages_ms"] = dict.fromkeys(told["stages_ms"])
        tables = self.open(self.show(told), ["settle"], ["run", READ_TABLES])[1]
        self.assertEqual([row[1][0] for row in tables["table-latency"]][:6], ["∞"] * 6)
        self.assertEqual(tables["table-errors"][0][1][1], 15)

    def test_only_what_must_be_there_is_enough(self):
        told = bench_files.load_test(bench_files.lognormal_seconds(1))
        least = {key: told[key] for key in ("format", "server", "clients", "frames", "latency_ms")}
        tables = self.open(self.show(least), ["settle"], ["run", READ_TABLES])[1]
        self.assertEqual(tables["table-latency"][0][1][1], told["latency_ms"]["p50"])


class BenchShow(unittest.TestCase):
    def show(self, bytes_in, *flags):
        return segctl("bench", "show", "-", *flags, stdin=bytes_in)

    def test_prints_the_key_figures(self):
        done = self.show(json.dumps(bench_files.eventful()).encode())
        self.assertEqual(done.returncode, SUCCESS, done.stderr.decode())
        text = done.stdout.decode()
        for expected in ("throughput    60.0 frames/s", "p99.9 infinite", "7 times FAILED DEADLINE_EXCEEDED", "16 clients", "UNSTABLE: "):
            self.assertIn(expected, text)

    def test_terminals_get_no_commands_of_the_file(self):
        done = self.show(json.dumps(bench_files.load_test([[1.0]], server="\x1b[2Jx\ny")).encode())
        self.assertIn(b"at ?[2Jx?y", done.stdout)

    def test_refuses_what_is_no_load_test_and_tells_every_fault(self):
        good = bench_files.load_test(bench_files.lognormal_seconds(1))
        wrong = copy.deepcopy(good) | {"clients": "many", "findings": [{"code": 7}]}
        wrong["timeline"][3]["p50_ms"] = [1]
        unordered = copy.deepcopy(good)
        unordered["timeline"].reverse()
        many = copy.deepcopy(good)
        for second in many["timeline"]:
            second["results"] = -1
        histogram = copy.deepcopy(good)
        histogram["latency_histogram"]["buckets"].reverse()
        for told, said in ((b"", "it is no JSON"), (b"[]", "it has no \"format\""), (b"{\"format\": \"other\"}", "its format is 'other'"),
                           (b"[" * 100_000, "it is no JSON"), (b"[" * 20 + b"]" * 20, "more than 16 levels"),
                           (json.dumps(good).replace("60.0", "1e999").encode(), "it is no JSON"),
                           (json.dumps(wrong).encode(), "clients is no number of at least 0; timeline[3].p50_ms is no number; "
                                                        "findings[0].code is no text; findings[0].text is missing"),
                           (json.dumps(many).encode(), "timeline[7].results is no number of at least 0; and 24 more"),
                           (json.dumps(histogram).encode(), "latency_histogram.buckets is no list of pairs"),
                           (json.dumps(unordered).encode(), "times that do not ascend")):
            with self.subTest(said=said):
                done = self.show(told)
                self.assertEqual(done.returncode, BAD_INPUT)
                self.assertIn("segctl: standard input: ", done.stderr.decode())
                self.assertIn(said, done.stderr.decode())
                self.assertEqual(done.stdout, b"")

    def test_wrong_usage_names_the_command(self):
        for flags, said in ((("show",), "RUN is required (see segctl bench show --help)"),
                            (("show", "x.json", "--htlm", "y"), "did you mean --html?")):
            with self.subTest(flags=flags):
                done = segctl("bench", *flags)
                self.assertEqual(done.returncode, BAD_INPUT)
                self.assertIn(said, done.stderr.decode())


if __name__ == "__main__":
    unittest.main()
