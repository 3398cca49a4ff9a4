# SPDX-License-Identifier: Apache-2.0
"""The web entrance of a server, and requests to it."""
import http.client
import json
import pathlib
import time

from harness import Server


class WebServer(Server):
    """A server with a web entrance on a free port."""

    def __init__(self, folder, *flags, **options):
        port_file = pathlib.Path(folder) / f"http-port-{time.monotonic_ns()}"
        super().__init__(folder, "--http", "127.0.0.1:0", "--http-port-file", str(port_file), *flags, **options)
        self.http_port = int(port_file.read_text())

    def request(self, method, target, body=None, headers=None, timeout=60):
        """The answer: status, headers, body."""
        connection = http.client.HTTPConnection("127.0.0.1", self.http_port, timeout=timeout)
        try:
            connection.request(method, target, body, headers or {})
            answer = connection.getresponse()
            return answer.status, dict((name.lower(), value) for name, value in answer.getheaders()), answer.read()
        finally:
            connection.close()

    def segment(self, scene, query="", accept="application/json", headers=None):
        body = pathlib.Path(scene).read_bytes() if not isinstance(scene, bytes) else scene
        return self.request("POST", f"/v1/segment?{query}", body, {"Accept": accept, **(headers or {})})

    def segment_well(self, scene, query=""):
        status, _, body = self.segment(scene, query)
        if status != 200:
            raise AssertionError(f"{status}: {body[:400]}")
        return json.loads(body)
