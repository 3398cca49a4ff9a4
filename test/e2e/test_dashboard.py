# SPDX-License-Identifier: Apache-2.0
"""Every query of the dashboard, and every alert rule, gives an answer in a real Prometheus that reads a loaded server."""
import json
import pathlib
import re
import time
import unittest
import urllib.parse

import grpc

from harness import EndToEnd
from scrape import Prometheus, get
from test_metrics import UNARY, MeasuredServer

DEPLOY = pathlib.Path(__file__).parents[2] / "deploy"


def dashboard_queries():
    dashboard = json.loads((DEPLOY / "grafana" / "dashboards" / "segserve.json").read_text())
    for panel in dashboard["panels"]:
        for target in panel.get("targets", []):
            yield panel["title"], target["expr"].replace("$__rate_interval", "1m").replace("$instance", ".*")


@unittest.skipUnless(Prometheus.installed, "there is no Prometheus")
class Dashboard(EndToEnd):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.server.close()
        cls.server = MeasuredServer(cls.folder)
        cls.addClassCleanup(cls.server.close)
        cls.prometheus = Prometheus(cls.folder, cls.server.metrics_port)
        cls.addClassCleanup(cls.prometheus.close)
        assert cls.prometheus.wait_for('up{job="segserve"}', 1) == 1, "Prometheus has not read the server within 30 s"

    def answer(self, query):
        told = json.loads(get(f"{self.prometheus.url}/api/v1/query?" + urllib.parse.urlencode({"query": query})))
        self.assertEqual(told["status"], "success", query)
        return told["data"]["result"]

    def test_every_query_of_the_dashboard_has_an_answer(self):
        deadline = time.monotonic() + 60
        failures = "rate(segserve_frame_failures_total[1m]) > 0"
        while not (self.prometheus.value(failures) and self.prometheus.value("rate(segserve_frames_total[1m]) > 0")):
            self.assertLess(time.monotonic(), deadline)
            self.run_well("bench", "--server", self.server.address, "--size", "160x120", "--scenes", "1", "--warm-up", "0",
                          "--duration", "0.5", "--clients", "2")
            with grpc.insecure_channel(self.server.address) as channel, self.assertRaises(grpc.RpcError):
                channel.unary_unary(UNARY)(b"", timeout=30)
        for panel, query in dashboard_queries():
            with self.subTest(panel=panel, query=query):
                self.assertNotEqual(self.answer(query), [])

    def test_every_alert_rule_can_be_asked(self):
        rules = re.findall(r"expr: (?:>-\n)?((?:.|\n)*?)\n +(?:for|labels):", (DEPLOY / "prometheus" / "alerts.yml").read_text())
        self.assertGreaterEqual(len(rules), 5)
        for rule in rules:
            with self.subTest(rule=rule):
                self.answer(rule)


if __name__ == "__main__":
    unittest.main()
