# SPDX-License-Identifier: Apache-2.0
"""A name stands for all of its addresses, and for others when they change."""
import subprocess
import unittest

from certificates import Authority
from harness import SEGCTL
from test_fleet import FAIR, SLACK, FleetTest, Replica


class Names(FleetTest):
    """The client sees an /etc/hosts of its own, which changes while it runs."""

    def setUp(self):
        self.hosts = self.path("hosts")
        probe = subprocess.run(["unshare", "-m", "true"], capture_output=True, check=False)
        if probe.returncode != 0:
            self.skipTest(f"there are no mount namespaces here: {probe.stderr.decode().strip()}")

    def set_hosts(self, servers):
        self.hosts.write_text("127.0.0.1 localhost\n" + "".join(f"{server.host} robots.test\n" for server in servers))

    def with_hosts(self):
        return ("unshare", "-m", "sh", "-c", f'mount --bind "{self.hosts}" /etc/hosts && exec "$@"', "sh")

    def name_of_three(self, flags=()):
        """Three servers at the same port."""
        first, = self.replicas(1, flags=flags)
        servers = [first] + [Replica(self.folder, f"127.0.0.{i}", first.port, flags) for i in (2, 3)]
        for server in servers[1:]:
            self.addCleanup(server.close)
        return servers

    def test_a_name_stands_for_all_its_addresses(self):
        servers = self.name_of_three()
        self.set_hosts(servers)
        for name in (f"robots.test:{servers[0].port}", f"dns:///robots.test:{servers[0].port}"):
            with self.subTest(name=name):
                told = self.bench(name, 3, before=self.with_hosts())
                for server in servers:
                    self.assertGreater(self.share(told, server), FAIR, told["results_of_server"])

    def test_a_name_changes_its_addresses(self):
        servers = self.name_of_three()
        self.set_hosts(servers[:2])
        told = self.bench(f"robots.test:{servers[0].port}", 9, before=self.with_hosts(),
                          meanwhile=lambda: self.set_hosts(servers[1:]))
        self.assertEqual(told["frames"]["repeated"], 0)
        shares = [self.share(told, server) for server in servers]
        self.assertGreater(shares[2], 0.1, shares)
        self.assertLess(shares[0], 0.4, shares)
        self.assertGreater(shares[1], 0.3, shares)

    def test_a_name_moves_to_another_server(self):
        first, = self.replicas(1)
        second = Replica(self.folder, "127.0.0.2", first.port)
        self.addCleanup(second.close)
        self.set_hosts([first])

        def move():
            self.set_hosts([second])
            first.process.kill()

        told = self.bench(f"robots.test:{first.port}", 6, before=self.with_hosts(), meanwhile=move)
        self.assertLess(told["latency_ms"]["max"], 4000 * SLACK)
        self.assertGreater(self.share(told, second), 0.3)

    def test_tls_expects_the_name_at_every_address(self):
        certificates = self.path("certificates")
        certificates.mkdir()
        authority = Authority(certificates, "authority")
        certificate, key = authority.sign("server", names="DNS:robots.test")
        flags = ("--tls-cert", str(certificate), "--tls-key", str(key))
        servers = self.name_of_three(flags)
        self.set_hosts(servers)
        told = self.bench(f"robots.test:{servers[0].port}", 3, "--tls-ca", str(authority.certificate), before=self.with_hosts())
        self.assertEqual(len(told["results_of_server"]), 3, told["results_of_server"])
        self.hosts.write_text("127.0.0.1 others.test\n127.0.0.2 others.test\n")
        done = subprocess.run([*self.with_hosts(), SEGCTL, "health", "--server", f"others.test:{servers[0].port}", "--tls-ca",
                               str(authority.certificate)], capture_output=True, timeout=60, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("is for robots.test, and not for others.test", done.stderr.decode())

    def test_an_unknown_name_is_told(self):
        self.set_hosts([])
        done = subprocess.run([*self.with_hosts(), SEGCTL, "health", "--server", "robots.invalid"], capture_output=True,
                              timeout=60, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("robots.invalid:50051 is not known", done.stderr.decode())


if __name__ == "__main__":
    unittest.main()
