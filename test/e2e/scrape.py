# SPDX-License-Identifier: Apache-2.0
"""Reads metrics as a server shows them, and starts a real Prometheus that reads them."""
import collections
import json
import re
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.parse
import urllib.request

LINE = re.compile(r"^([a-zA-Z_:][a-zA-Z0-9_:]*)(?:\{(.*)\})? (\S+)$")
LABEL = re.compile(r'(\w+)="([^"]*)"')


def get(url, timeout=30):
    with urllib.request.urlopen(url, timeout=timeout) as answer:
        return answer.read().decode()


class Scrape:
    """What a server shows at one moment."""

    def __init__(self, port):
        self.text = get(f"http://127.0.0.1:{port}/metrics")
        self.types = dict(re.findall(r"^# TYPE (\S+) (\S+)$", self.text, re.M))
        self.labels = collections.defaultdict(set)  # the names of labels, by the name of the metric
        self._values = []
        for line in self.text.splitlines():
            if line.startswith("#"):
                continue
            name, labels, value = LINE.match(line).groups()
            labels = dict(LABEL.findall(labels or ""))
            self._values.append((name, labels, float(value)))
            base = name if name in self.types else re.sub(r"_(bucket|sum|count)$", "", name)
            self.labels[base] |= labels.keys() - {"le", "quantile"}

    def sum(self, name, **labels):
        """The sum over all values with this name and these labels; at least one must be there."""
        found = [value for other, has, value in self._values if other == name and labels.items() <= has.items()]
        assert found, f"there is no {name} with {labels}"
        return sum(found)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Prometheus:
    """A real Prometheus on loopback that reads a server's metrics several times a second."""

    installed = shutil.which("prometheus") is not None and shutil.which("promtool") is not None

    def __init__(self, folder, metrics_port):
        config = folder / "prometheus.json"  # which is YAML, too
        config.write_text(json.dumps({
            "global": {"scrape_interval": "250ms", "scrape_timeout": "250ms"},
            "scrape_configs": [{"job_name": "segserve",
                                "static_configs": [{"targets": [f"127.0.0.1:{metrics_port}"]}]}]}))
        self.url = f"http://127.0.0.1:{free_port()}"
        self.process = subprocess.Popen(
            ["prometheus", f"--config.file={config}", f"--storage.tsdb.path={folder / 'tsdb'}",
             f"--web.listen-address={self.url.removeprefix('http://')}", "--log.level=error"])

    def value(self, query):
        """The value of a query that gives one; None if it gives none, or if Prometheus has not started yet."""
        try:
            told = json.loads(get(f"{self.url}/api/v1/query?" + urllib.parse.urlencode({"query": query})))
        except (urllib.error.URLError, ConnectionError):
            return None
        values = told["data"]["result"]
        return float(values[0]["value"][1]) if values else None

    def wait_for(self, query, value):
        """Waits until a query gives this value, which the server shows already; returns what it gives in the end."""
        deadline = time.monotonic() + 30
        while (found := self.value(query)) != value and time.monotonic() < deadline:
            time.sleep(0.1)
        return found

    def close(self):
        self.process.kill()
        self.process.wait()
