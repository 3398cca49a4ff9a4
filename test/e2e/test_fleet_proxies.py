# SPDX-License-Identifier: Apache-2.0
"""Behind HAProxy and nginx a server that is killed, drained or cut off silently loses no frame."""
import pathlib
import shutil
import socket
import subprocess
import time
import unittest

from test_fleet import SCENES, SLACK, FleetTest

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


def haproxy(folder, listen, servers):
    """The command of an HAProxy before the servers at these addresses, with its files in a new folder."""
    folder.mkdir()
    lines = "".join(f"  server s{i} {server} proto h2 check inter 200ms fall 2 rise 1 on-marked-down shutdown-sessions\n"
                    for i, server in enumerate(servers))
    config = folder / "haproxy.cfg"
    config.write_text(HAPROXY.format(listen=listen, servers=lines))
    return ["haproxy", "-db", "-f", str(config)]


def nginx(folder, listen, servers):
    """The same of nginx, with the file that is shipped, but for its names, certificate and temporary files."""
    folder.mkdir()
    site = NGINX_CONF.read_text()
    replaced = {"listen 50051 ssl http2;": f"listen {listen} http2;"}
    replaced |= {f"server 10.0.0.{i}:50051 ": f"server {server} " for i, server in enumerate(servers, 1)}
    for old, new in replaced.items():
        assert old in site, old
        site = site.replace(old, new)
    site = "\n".join(line for line in site.splitlines() if not line.lstrip().startswith("ssl_"))
    config = folder / "nginx.conf"
    config.write_text(NGINX.format(folder=folder, site=site))
    return ["nginx", "-c", str(config), "-p", str(folder), "-e", str(folder / "error.log")]


# As the file of nginx asks for.
PINGS = ("--ping-interval", "1")


class Behind:
    """What every proxy has to stand."""

    def setUp(self):
        name = self.proxy.__name__
        if shutil.which(name) is None:
            self.skipTest(f"{name} is not installed")
        self.port = free_port()
        self.servers = self.replicas(flags=PINGS if name == "nginx" else ())
        command = type(self).proxy(self.path(name), f"127.0.0.1:{self.port}", [server.address for server in self.servers])
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        self.wait_until_it_listens(name, process)

    def wait_until_it_listens(self, name, process):
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
        self.fail(f"{name} does not listen: {process.stderr.read().decode()}")

    def lose(self, end, most_seconds=2, seconds=6):
        told = self.bench(f"127.0.0.1:{self.port}", seconds, meanwhile=lambda: end(self.servers[0]))
        self.assertLess(told["latency_ms"]["max"], 1000 * most_seconds * SLACK)

    def test_killed(self):
        self.lose(lambda server: server.process.kill())

    def test_drained(self):
        self.lose(lambda server: server.process.terminate())

    def test_cut_off_silently(self):
        """The kernel of a server that stands still takes connections, and acknowledges what arrives."""
        self.lose(lambda server: server.stop(), most_seconds=5, seconds=12)

    def test_all_but_one_are_gone(self):
        for server in self.servers[1:]:
            server.close()
        self.bench(f"127.0.0.1:{self.port}", 3)


class HAProxy(Behind, FleetTest):
    """It asks the servers by gRPC, and closes the streams of one that does not answer."""

    proxy = haproxy


class Nginx(Behind, FleetTest):
    """It closes a stream whose server it has not heard for two seconds."""

    proxy = nginx

    def test_a_stream_without_frames_stays_open(self):
        """The server's pings are signs of life."""
        told = self.bench(f"127.0.0.1:{self.port}", 9, load=SCENES + ("--clients", "8", "--rate", "2.4"))
        self.assertEqual(told["frames"]["repeated"], 0)
        self.assertNotIn("timed out", (self.path("nginx") / "error.log").read_text())


if __name__ == "__main__":
    unittest.main()
