# SPDX-License-Identifier: Apache-2.0
"""One of three machines loses its cable: it hears nothing more, and nobody hears from it. No frame is lost."""
import shutil
import subprocess
import unittest

from harness import SEGCTL
from test_fleet import SLACK, FleetTest
from test_fleet_proxies import PINGS, haproxy, nginx
from test_slow_link import Namespace, ServerIn

# Runs on the machine of the clients, and joins it with others by a switch. The processes that are named live on the others.
SWITCH = """
set -e
ip link set lo up
ip link add fleet type bridge
ip address add 10.77.1.254/24 dev fleet
ip link set fleet up
number=0
for process; do
  number=$((number + 1))
  ip link add "port$number" type veth peer name cable
  ip link set cable netns "$process"
  ip link set "port$number" master fleet up
  nsenter --net="/proc/$process/ns/net" sh -c "ip link set lo up && ip address add 10.77.1.$number/24 dev cable && ip link set cable up"
done
"""


class Cut(FleetTest):
    def setUp(self):
        self.here, *others = machines = [Namespace() for _ in range(4)]
        for machine in machines:
            self.addCleanup(machine.close)
        if not all(machine.ready for machine in machines):
            self.skipTest("there are no network namespaces here")
        made = subprocess.run(self.here.command("sh", "-c", SWITCH, "sh", *(machine.process.pid for machine in others)),
                              capture_output=True, check=False)
        if made.returncode != 0:
            self.skipTest(f"there are no virtual links here: {made.stderr.decode().strip()}")
        self.servers = []
        for number, machine in enumerate(others, 1):
            self.servers.append(ServerIn(self.folder, machine, f"10.77.1.{number}", PINGS))
            self.addCleanup(self.servers[-1].close)
        self.addresses = [server.address for server in self.servers]

    def cut(self):
        """Neither side of the cable notices that the switch has forgotten it."""
        subprocess.run(self.here.command("ip", "link", "set", "port1", "nomaster"), check=True)

    def lose(self, address, most_seconds):
        told = self.bench(address, 12, before=self.here.command(), meanwhile=self.cut)
        self.assertLess(told["latency_ms"]["max"], 1000 * most_seconds * SLACK)

    def lose_behind(self, proxy):
        if shutil.which(proxy.__name__) is None:
            self.skipTest(f"{proxy.__name__} is not installed")
        command = proxy(self.path(proxy.__name__), "127.0.0.1:50051", self.addresses)
        with subprocess.Popen(self.here.command(*command), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            try:
                subprocess.run(self.here.command(SEGCTL, "health", "--server", "127.0.0.1:50051", "--wait", "20", "--quiet"), check=True)
                self.lose("127.0.0.1:50051", 5)
            finally:
                process.terminate()

    def test_clients_over_the_servers(self):
        self.lose(",".join(self.addresses), 2.5)

    def test_behind_haproxy(self):
        self.lose_behind(haproxy)

    def test_behind_nginx(self):
        self.lose_behind(nginx)


if __name__ == "__main__":
    unittest.main()
