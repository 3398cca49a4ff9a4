# SPDX-License-Identifier: Apache-2.0
"""Over a link of 20 Mbit/s a robot that drops old frames gets young results."""
import json
import os
import subprocess
import unittest

from harness import SEGCTL, SUCCESS, EndToEnd, Server

LINK = """
set -e
ip link add sl-server type veth peer name sl-client
ip link set sl-client netns "$1"
ip address add 10.77.0.1/24 dev sl-server
ip link set lo up
ip link set sl-server up
nsenter --net="/proc/$1/ns/net" sh -c 'ip address add 10.77.0.2/24 dev sl-client && ip link set sl-client up &&
  tc qdisc add dev sl-client root tbf rate 20mbit burst 32kb latency 100ms'
tc qdisc add dev sl-server root tbf rate 20mbit burst 32kb latency 100ms
"""


class Namespace:
    """A network namespace, which lives as long as its process."""

    def __init__(self):
        self.process = subprocess.Popen(["unshare", "-n", "sh", "-c", "echo ready; exec sleep 600"], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE)
        self.ready = self.process.stdout.readline() == b"ready\n"

    def command(self, *arguments):
        return ["nsenter", f"--net=/proc/{self.process.pid}/ns/net", *map(str, arguments)]

    def close(self):
        self.process.kill()
        self.process.communicate()


class ServerIn(Server):
    """A server in a network namespace, reached at its address there."""

    def __init__(self, folder, namespace, host="10.77.0.1", flags=()):
        handle = os.open(f"/proc/{namespace.process.pid}/ns/net", os.O_RDONLY)
        os.set_inheritable(handle, True)
        try:
            super().__init__(folder, "--insecure-beyond-loopback", *flags, listen=f"{host}:0", before=lambda: enter(handle))
        finally:
            os.close(handle)
        self.address = f"{host}:{self.address.rsplit(':', 1)[1]}"


def enter(handle):
    import ctypes  # only the child process of the server needs it
    if ctypes.CDLL(None, use_errno=True).setns(handle, 0) != 0:
        raise OSError(ctypes.get_errno(), "setns")


class SlowLink(EndToEnd):
    def setUp(self):
        self.server_side, self.client_side = Namespace(), Namespace()
        self.addCleanup(self.server_side.close)
        self.addCleanup(self.client_side.close)
        if not (self.server_side.ready and self.client_side.ready):
            self.skipTest("there are no network namespaces here")
        made = subprocess.run(self.server_side.command("sh", "-c", LINK, "sh", self.client_side.process.pid),
                              capture_output=True, check=False)
        if made.returncode != 0:
            self.skipTest(f"there are no virtual links here: {made.stderr.decode().strip()}")
        self.slow_server = ServerIn(self.folder, self.server_side)
        self.addCleanup(self.slow_server.close)

    def bench(self, *flags):
        done = subprocess.run(
            self.client_side.command(SEGCTL, "bench", "--server", self.slow_server.address, "--rate", "30", "--drop-oldest",
                                     "--in-flight", "2", "--duration", "8", "--json", "-", *flags),
            capture_output=True, timeout=120, check=False)
        self.assertEqual(done.returncode, SUCCESS, done.stderr.decode())
        return json.loads(done.stdout)

    def test_results_of_rgbd_are_young(self):
        told = self.bench("--codec", "rgbd", "--encoded-beforehand")
        self.assertGreater(told["frames"]["results"], 20)
        self.assertLess(told["latency_ms"]["p99"], 500)
        self.assertEqual(set(told["errors"]) - {"DROPPED"}, set())


if __name__ == "__main__":
    unittest.main()
