# SPDX-License-Identifier: Apache-2.0
"""TLS and mutual TLS: who is let in, what is said to those who are not, and how certificates are renewed."""
import json
import os
import pathlib
import re
import shutil
import socket
import ssl
import subprocess
import tempfile
import time
import unittest
import urllib.request
import warnings

import grpc

from certificates import Authority, openssl
from harness import BAD_INPUT, FAILED, SEGCTL, SEGSERVE, SUCCESS, EndToEnd, Server

RELOAD_SECONDS = 5


class Tls(EndToEnd):
    """A server with TLS, and the authority that has signed its certificate."""

    @classmethod
    def setUpClass(cls):
        certificates = pathlib.Path(tempfile.mkdtemp(prefix="segserve-e2e-tls-"))
        cls.addClassCleanup(shutil.rmtree, certificates)
        cls.authority, cls.stranger = Authority(certificates, "authority"), Authority(certificates, "stranger")
        cls.certificate, cls.key = cls.authority.sign("server")
        cls.ca = cls.authority.certificate
        cls.server_flags = ("--tls-cert", str(cls.certificate), "--tls-key", str(cls.key), *cls.more_server_flags())
        super().setUpClass()

    @classmethod
    def more_server_flags(cls):
        return ()

    def start(self, *flags, **options):
        server = Server(self.folder, *map(str, flags), **options)
        self.addCleanup(server.close)
        return server

    def refused(self, *flags, server=None, command="health"):
        """What segctl says when the connection is refused. It must not wait for its deadline."""
        begin = time.monotonic()
        line = self.run_badly(FAILED, command, "--timeout", "60", "--server", (server or self.server).address, *flags)
        self.assertLess(time.monotonic() - begin, 20, "a problem of certificates does not go away by waiting")
        return line


class ServerTls(Tls):
    def test_every_command_goes_through_tls(self):
        flags = ("--server", self.server.address, "--tls-ca", self.ca)
        self.assertIn(b"SERVING", self.run_well("health", "--wait", "20", *flags).stdout)
        self.assertIn("limits", json.loads(self.run_well("info", *flags, "--json", "-").stdout))
        scene = self.synth("--width", "160", "--height", "120")
        self.assertEqual(self.segment(scene, "--tls-ca", self.ca)[0], self.segment_locally(scene)[0])
        folder = self.path("labeled")
        folder.mkdir()
        self.run_well("segment", scene, *flags, "--out-dir", folder, "--quiet")
        self.run_well("bench", *flags, "--duration", "1", "--warm-up", "0", "--size", "160x120", "--verify")

    def test_the_authorities_of_the_system_are_asked_without_a_file(self):
        flags = ("health", "--server", self.server.address, "--tls")
        self.run_well(*flags, environment={"SSL_CERT_FILE": str(self.ca)})
        self.assertIn("none of the authorities in", self.refused("--tls"))

    def test_a_client_in_plain_text_is_told_of_tls(self):
        self.assertIn(f"{self.server.address} speaks TLS, and this client plain text", self.refused())
        self.assertIn("speaks TLS", self.refused(command="info"))

    def test_a_server_in_plain_text_is_named(self):
        plain = self.start()
        self.assertIn(f"{plain.address} speaks no TLS", self.refused("--tls-ca", self.ca, server=plain))

    def test_an_unknown_authority_is_named(self):
        line = self.refused("--tls-ca", self.stranger.certificate)
        self.assertIn(f"(CN=server) was signed by CN=authority, which none of the authorities in {self.stranger.certificate}",
                      line)

    def test_another_name_is_refused_unless_it_is_expected(self):
        certificate, key = self.authority.sign("elsewhere", names="DNS:robot.example,DNS:*.robot.example")
        server = self.start("--tls-cert", certificate, "--tls-key", key)
        self.assertIn("is for robot.example, *.robot.example, and not for 127.0.0.1", self.refused("--tls-ca", self.ca, server=server))
        for name in ("robot.example", "a.robot.example"):
            self.run_well("health", "--server", server.address, "--tls-ca", self.ca, "--tls-server-name", name)
        line = self.refused("--tls-ca", self.ca, "--tls-server-name", "robot.test", server=server)
        self.assertIn("and not for robot.test", line)

    def test_an_expired_certificate_is_told_by_the_client_and_in_the_log(self):
        certificate, key = self.authority.sign("late", days=-1)
        log = self.path("log")
        server = self.start("--tls-cert", certificate, "--tls-key", key, log=log)
        self.assertRegex(self.refused("--tls-ca", self.ca, server=server), r"\(CN=late\) ended on 20\d\d-")
        self.wait_for(lambda: "late.crt has ended on" in log.read_text())
        self.assertRegex(log.read_text(), r"tls=on certificate_end=.20\d\d-\d\d-\d\d ")

    def test_a_stream_ends_at_once_and_says_why(self):
        scene = self.synth("--width", "64", "--height", "48")
        folder = self.path("out")
        folder.mkdir()
        begin = time.monotonic()
        done = subprocess.run([SEGCTL, "segment", scene, "--out-dir", folder, "--server", self.server.address, "--timeout", "60",
                               "--tls-ca", self.stranger.certificate], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, FAILED, done)
        self.assertIn("was signed by CN=authority", done.stdout + done.stderr)
        self.assertLess(time.monotonic() - begin, 20)

    def test_the_next_address_is_tried(self):
        other = self.start("--tls-cert", *self.stranger.sign("other")[:1], "--tls-key", self.stranger.folder / "other.key")
        both = f"{other.address},{self.server.address}"
        for _ in range(3):
            self.run_well("health", "--server", both, "--tls-ca", self.ca)
            self.run_well("bench", "--server", both, "--tls-ca", self.ca, "--duration", "0.5", "--warm-up", "0", "--size",
                          "64x48")

    def test_files_that_are_wrong_are_named(self):
        for flags, expected in ((("--tls-ca", "/no/such"), "cannot read /no/such: No such file or directory"),
                                (("--tls-ca", self.key), f"{self.key}: there is no certificate in PEM"),
                                (("--tls-cert", self.certificate), "has no key file"),
                                (("--tls-cert", self.ca, "--tls-key", self.key, "--tls-ca", self.ca), "does not belong")):
            self.assertIn(expected, self.run_badly(BAD_INPUT, "health", "--server", self.server.address, *flags))
        line = self.run_badly(BAD_INPUT, "health", "--server", "unix:/tmp/x.sock", "--tls-ca", self.ca)
        self.assertIn("unix:/tmp/x.sock is a unix socket, which has no TLS", line)

    def test_the_server_hears_itself_and_goes_on(self):
        """It would end with exit code 4 after three connections of its own without an answer."""
        server = self.start(*self.server_flags, "--listener-check", "0.5")
        time.sleep(3)
        self.assertIsNone(server.process.poll())
        self.assertEqual(server.terminate(), 0)

    def test_old_protocols_are_refused(self):
        context = ssl.create_default_context(cafile=self.ca)
        context.set_ciphers("DEFAULT:@SECLEVEL=0")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python calls them old, too.
            context.minimum_version, context.maximum_version = ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1
        host, port = self.server.address.split(":")
        with socket.create_connection((host, int(port)), timeout=20) as connection:
            with self.assertRaises((ssl.SSLError, ConnectionResetError)):
                context.wrap_socket(connection, server_hostname="localhost")


class MutualTls(Tls):
    @classmethod
    def more_server_flags(cls):
        return ("--tls-client-ca", str(cls.ca))

    def flags(self, certificate, key):
        return ("--tls-ca", self.ca, "--tls-cert", certificate, "--tls-key", key)

    def test_a_client_with_a_certificate_of_the_authority_is_served(self):
        robot = self.flags(*self.authority.sign("robot"))
        self.run_well("health", "--server", self.server.address, *robot)
        self.run_well("bench", "--server", self.server.address, *robot, "--duration", "0.5", "--warm-up", "0", "--size",
                      "64x48")

    def test_a_client_without_a_certificate_is_told(self):
        self.assertIn("asks for a client certificate, and this client has none", self.refused("--tls-ca", self.ca))
        self.assertIn("speaks TLS", self.refused())

    def test_a_foreign_certificate_is_told(self):
        flags = self.flags(*self.stranger.sign("foreign"))
        self.assertIn("foreign.crt: it was signed by CN=stranger, and the server trusts CN=authority", self.refused(*flags))

    def test_an_expired_certificate_is_told(self):
        self.assertRegex(self.refused(*self.flags(*self.authority.sign("old", days=-1))), r"old\.crt: it ended on 20\d\d-")

    def test_a_client_in_python_is_let_in_or_not(self):
        def health(identity):
            pair = [path.read_bytes() for path in reversed(identity)] if identity else [None, None]
            credentials = grpc.ssl_channel_credentials(self.ca.read_bytes(), *pair)
            with grpc.secure_channel(self.server.address, credentials) as channel:
                return channel.unary_unary("/grpc.health.v1.Health/Check")(b"", timeout=20)

        self.assertEqual(health(self.authority.sign("python")), b"\x08\x01")
        for identity in (None, self.stranger.sign("stranger-python"), self.authority.sign("old-python", days=-1)):
            with self.assertRaises(grpc.RpcError) as refusal:
                health(identity)
            self.assertEqual(refusal.exception.code(), grpc.StatusCode.UNAVAILABLE)


class Renewal(Tls):
    """The files are those of a Kubernetes secret: symbolic links that lead through one that is replaced."""

    def setUp(self):
        self.secret = self.path("secret")
        self.secret.mkdir()
        self.version = 0
        self.replace(self.certificate, self.key, self.ca)
        for name in ("tls.crt", "tls.key", "ca.crt"):
            (self.secret / name).symlink_to(f"..data/{name}")
        self.log = self.path("log")
        self.renewed = self.start("--tls-cert", self.secret / "tls.crt", "--tls-key", self.secret / "tls.key", "--tls-client-ca",
                                  self.secret / "ca.crt", "--metrics-listen", "127.0.0.1:0", "--metrics-port-file",
                                  self.secret / "metrics-port", log=self.log)
        self.robot = self.authority.sign("robot")

    def replace(self, certificate, key, ca):
        self.version += 1
        folder = self.secret / f"..{self.version}"
        folder.mkdir()
        for source, name in ((certificate, "tls.crt"), (key, "tls.key"), (ca, "ca.crt")):
            shutil.copy(source, folder / name)
        (self.secret / "..new").symlink_to(folder.name)
        (self.secret / "..new").rename(self.secret / "..data")

    def served_certificate(self):
        host, port = self.renewed.address.split(":")
        context = ssl.create_default_context(cafile=self.ca)
        context.load_cert_chain(*self.robot)
        with socket.create_connection((host, int(port)), timeout=20) as connection:
            with context.wrap_socket(connection, server_hostname="localhost") as tls:
                return ssl.DER_cert_to_PEM_cert(tls.getpeercert(binary_form=True))

    def reloads(self, outcome):
        """How many sets of files the server has taken or refused, as Prometheus sees it."""
        port = (self.secret / "metrics-port").read_text().strip()
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=20) as page:
            return float(re.search(rf'segserve_tls_reloads_total{{outcome="{outcome}"}} (\S+)', page.read().decode())[1])

    def errors(self):
        return [line for line in self.log.read_text().splitlines() if re.match(r"\S+ error ", line)]

    def test_a_new_certificate_is_used_in_time_and_an_open_stream_goes_on(self):
        flags = ("--server", self.renewed.address, "--tls-ca", self.ca, "--tls-cert", self.robot[0], "--tls-key", self.robot[1])
        stream = subprocess.Popen([SEGCTL, "bench", *map(str, flags), "--clients", "2", "--duration", "6", "--warm-up", "0",
                                   "--size", "64x48", "--verify", "--json", "-"], stdout=subprocess.PIPE, text=True)
        time.sleep(1)
        certificate, key = self.authority.sign("renewed")
        begin = time.monotonic()
        self.replace(certificate, key, self.ca)
        self.wait_for(lambda: self.served_certificate().split() == certificate.read_text().split())
        self.assertLess(time.monotonic() - begin, RELOAD_SECONDS)
        self.assertIsNone(stream.poll(), "the stream was to be open at the time of the renewal")
        summary = json.loads(stream.communicate(timeout=60)[0])
        self.assertEqual(stream.returncode, SUCCESS)
        self.assertEqual((summary["errors"], summary["frames"]["repeated"], summary["mismatches"]), ({}, 0, 0), summary)
        self.assertEqual(summary["frames"]["results"], summary["frames"]["sent"])
        self.assertIn("new TLS certificates are in use", self.log.read_text())
        self.assertEqual((self.reloads("refused"), self.reloads("taken")), (0, 1))

    def test_new_authorities_for_clients_are_used_in_time(self):
        stranger = self.stranger.sign("newcomer")
        flags = ("health", "--server", self.renewed.address, "--tls-ca", self.ca)
        newcomer = (*flags, "--tls-cert", stranger[0], "--tls-key", stranger[1])
        robot = (*flags, "--tls-cert", self.robot[0], "--tls-key", self.robot[1])
        self.run_well(*robot)
        self.run_badly(FAILED, *newcomer)
        self.replace(self.certificate, self.key, self.stranger.certificate)
        self.wait_for(lambda: "new TLS certificates are in use" in self.log.read_text())
        self.run_well(*newcomer)
        self.run_badly(FAILED, *robot)

    def test_a_wrong_pair_is_refused_and_the_old_one_stays(self):
        before = self.served_certificate()
        self.replace(self.authority.sign("alone")[0], self.key, self.ca)
        self.wait_for(self.errors)
        time.sleep(3)
        errors = self.errors()
        self.assertEqual(len(errors), 1, "it is told once")
        self.assertRegex(errors[0], r"the old ones stay in use: \S+tls\.crt and \S+tls\.key: the private key does not belong")
        self.assertEqual((self.reloads("refused"), self.reloads("taken")), (1, 0))
        self.assertEqual(self.served_certificate(), before)


class Start(Tls):
    def refusal(self, *flags, code=1, address="127.0.0.1:0"):
        done = subprocess.run([SEGSERVE, "--listen", address, *map(str, flags)], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def test_files_that_are_wrong_are_named(self):
        self.authority.sign("another")
        another = self.authority.folder / "another.key"
        openssl("ec", "-in", self.key, "-aes128", "-passout", "pass:word", "-out", self.path("encrypted"))
        for flags, expected in (
                (("--tls-cert", self.certificate, "--tls-key", another), f"{another}: the private key does not belong"),
                (("--tls-cert", self.certificate, "--tls-key", self.path("encrypted")), "the private key is encrypted"),
                (("--tls-cert", "/no/such", "--tls-key", self.key), "cannot read /no/such: No such file or directory"),
                ((*self.server_flags, "--tls-client-ca", self.key), f"{self.key}: there is no certificate in PEM")):
            self.assertIn(expected, self.refusal(*flags))

    def test_flags_that_do_not_go_together_are_named(self):
        self.assertIn("--tls-cert: it needs --tls-key, too", self.refusal("--tls-cert", self.certificate, code=2))
        self.assertIn("--tls-client-ca: it needs --tls-cert", self.refusal("--tls-client-ca", self.ca, code=2))
        self.assertIn("a unix socket, which has no TLS", self.refusal(*self.server_flags, address="unix:/tmp/x.sock", code=2))

    def test_beyond_loopback_it_serves_with_tls_and_not_without(self):
        self.assertIn("the connection is not encrypted", self.refusal(address="0.0.0.0:0", code=2))
        server = self.start(*self.server_flags, listen="0.0.0.0:0")
        self.run_well("health", "--server", server.address, "--tls-ca", self.ca)


class Documentation(unittest.TestCase):
    """The trial in docs/operations.md works as it stands."""

    def test_trial(self):
        page = (pathlib.Path(__file__).resolve().parents[2] / "docs/operations.md").read_text()
        block = page.split("### A trial in five commands")[1].split("```sh\n")[1].split("```")[0]
        commands = block.replace("\\\n", " ").splitlines()
        self.assertEqual(len(commands), 5)
        folder = pathlib.Path(tempfile.mkdtemp(prefix="segserve-e2e-trial-"))
        self.addCleanup(shutil.rmtree, folder)
        for name, program in (("segctl", SEGCTL), ("segserve", SEGSERVE)):
            (folder / name).symlink_to(program)
        environment = {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"}
        for command in commands[:3]:
            subprocess.run(command, shell=True, check=True, cwd=folder, capture_output=True, timeout=60)
        log = folder / "log"
        with open(log, "wb") as lines:
            server = subprocess.Popen("exec " + commands[3].rstrip("& "), shell=True, cwd=folder, env=environment, stderr=lines)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        deadline = time.monotonic() + 60
        while "segserve serves" not in log.read_text():
            if "already in use" in log.read_text():
                self.skipTest("the port of the trial is taken")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.05)
        done = subprocess.run(commands[4], shell=True, cwd=folder, env=environment, capture_output=True, text=True, timeout=60)
        self.assertEqual((done.returncode, done.stderr), (SUCCESS, ""))
        self.assertEqual(done.stdout, "localhost:50443 is SERVING\n")


if __name__ == "__main__":
    unittest.main()
