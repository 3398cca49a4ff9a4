# SPDX-License-Identifier: Apache-2.0
"""Behind HAProxy and nginx a server that is killed or drained loses no frame."""
import pathlib
import shutil
import socket
import subprocess
import time
import unittest

from test_fleet import SLACK, FleetTest

NGINX_CONF = pathlib.Path(__file__).parents[2] / "deploy/nginx/segserve.conf"

HAPROXY = """
defaults
  mode http
  timeout connect 2s
  timeout client 11m
  timeout server 11m
  retries 3
  retry-on conn-failure
  option redispatch 1
frontend grpc
  bind {listen} proto h2
  default_backend segserve
backend segserve
  balance leastconn
  option httpchk
  http-check send meth POST uri /grpc.health.v1.Health/Check ver HTTP/2 hdr content-type application/grpc hdr te trailers
  http-check expect status 200
{servers}
"""

NGINX = """
daemon off;
pid {folder}/nginx.pid;
error_log {folder}/error.log;
events {{}}
http {{
  access_log off;
  client_body_temp_path {folder}/body;
  proxy_temp_path {folder}/proxy;
  fastcgi_temp_path {folder}/fastcgi;
  uwsgi_temp_path {folder}/uwsgi;
  scgi_temp_path {folder}/scgi;
  {site}
}}
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Behind:
    """What every proxy has to stand."""

    def start(self, *command):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline:
            try:
                socket.create_connection(("127.0.0.1", self.port), timeout=1).close()
                return
            except OSError:
                if process.poll() is not None:
                    break
                time.sleep(0.05)
        process.terminate()
        self.fail(f"{command[0]} does not listen: {process.stderr.read().decode()}")

    def setUp(self):
        if shutil.which(self.program) is None:
            self.skipTest(f"{self.program} is not installed")
        self.port = free_port()
        self.servers = self.replicas()
        self.start_proxy()

    def lose(self, end):
        told = self.bench(f"127.0.0.1:{self.port}", 6, meanwhile=lambda: end(self.servers[0]))
        self.assertLess(told["latency_ms"]["max"], 2000 * SLACK)

    def test_killed(self):
        self.lose(lambda server: server.process.kill())

    def test_drained(self):
        self.lose(lambda server: server.process.terminate())

    def test_all_but_one_are_gone(self):
        for server in self.servers[1:]:
            server.close()
        self.bench(f"127.0.0.1:{self.port}", 3)


class HAProxy(Behind, FleetTest):
    program = "haproxy"

    def start_proxy(self):
        config = self.path("haproxy.cfg")
        servers = "".join(f"  server s{i} {server.address} proto h2 check inter 200ms fall 2 rise 1 "
                          "on-marked-down shutdown-sessions\n"
                          for i, server in enumerate(self.servers))
        config.write_text(HAPROXY.format(listen=f"127.0.0.1:{self.port}", servers=servers))
        self.start("haproxy", "-db", "-f", str(config))


    def test_cut_off_silently(self):
        """HAProxy asks the servers by gRPC, and closes the streams of one that does not answer."""
        told = self.bench(f"127.0.0.1:{self.port}", 8, meanwhile=self.servers[0].stop)
        self.assertLess(told["latency_ms"]["max"], 3000 * SLACK)


class Nginx(Behind, FleetTest):
    """With the file that is shipped, but for its names, certificate and temporary files."""

    program = "nginx"

    def site(self):
        site = NGINX_CONF.read_text()
        for server, address in zip(self.servers, ("10.0.0.1", "10.0.0.2", "10.0.0.3")):
            self.assertIn(f"server {address}:50051 ", site)
            site = site.replace(f"{address}:50051", server.address)
        self.assertIn("listen 50051 ssl http2;", site)
        site = site.replace("listen 50051 ssl http2;", f"listen 127.0.0.1:{self.port} http2;")
        return "\n".join(line for line in site.splitlines() if not line.lstrip().startswith("ssl_"))

    def start_proxy(self):
        folder = self.path("nginx")
        folder.mkdir()
        config = folder / "nginx.conf"
        config.write_text(NGINX.format(folder=folder, site=self.site()))
        self.start("nginx", "-c", str(config), "-p", str(folder), "-e", str(folder / "error.log"))


if __name__ == "__main__":
    unittest.main()
