#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what TLS costs: `segctl bench` takes turns between a server with mutual TLS and one in plain text, both on this machine.

    test/bench/tls_cost.py FRAME.pcd.. [--build build/release] [--rounds 8] [--duration 3] [--codec planar]

Frames go one after the other on one stream. The figures are the time on the way, which is what a frame's latency has beyond its
stages at client and server, and the CPU time of both for a frame. The least over the rounds counts, because the others only add other
load of the machine.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/e2e"))
from certificates import Authority  # noqa: E402


class Server:
    def __init__(self, program, folder, name, *flags):
        port = folder / f"{name}.port"
        self.process = subprocess.Popen([program, "--listen", "127.0.0.1:0", "--workers", "1", "--log-level", "error", "--port-file",
                                         port, *flags])
        while not port.exists():
            time.sleep(0.05)
        self.address = f"localhost:{port.read_text().strip()}"

    def cpu_ms(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) * 1000 / os.sysconf("SC_CLK_TCK")


def measure(program, server, flags, arguments):
    before = server.cpu_ms()
    inputs = [part for frame in arguments.frames for part in ("--input", frame)]
    done = subprocess.run([program, "bench", "--server", server.address, *inputs, "--codec", arguments.codec, "--duration",
                           str(arguments.duration), "--warm-up", "1", "--encoded-beforehand", "--json", "-", *flags],
                          stdout=subprocess.PIPE, check=True)
    told = json.loads(done.stdout)
    # The warm-up's frames are not counted, but take the same time each.
    counted = told["frames"]["results"] * (arguments.duration + 1) / arguments.duration
    return {"time on the way, ms": told["stages_ms"]["rest"], "CPU of the server, ms a frame": (server.cpu_ms() - before) / counted,
            "CPU of the client, ms a frame": told["client_cpu_ms_per_frame"],
            "MB a frame, both ways": (told["bytes_up"] + told["bytes_down"]) / told["frames"]["results"] / 1e6}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", nargs="+")
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--duration", type=float, default=3)
    parser.add_argument("--codec", default="planar")
    arguments = parser.parse_args()
    segserve, segctl = arguments.build / "server/segserve", arguments.build / "client/segctl"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        authority = Authority(folder, "authority")
        (server_crt, server_key), (robot_crt, robot_key) = authority.sign("server"), authority.sign("robot")
        setups = {
            "plain": (Server(segserve, folder, "plain"), []),
            "TLS": (Server(segserve, folder, "tls", "--tls-cert", server_crt, "--tls-key", server_key, "--tls-client-ca",
                           authority.certificate),
                    ["--tls-ca", authority.certificate, "--tls-cert", robot_crt, "--tls-key", robot_key])}
        rounds = {name: [] for name in setups}
        try:
            for _ in range(arguments.rounds):
                for setup, (server, flags) in setups.items():
                    rounds[setup].append(measure(segctl, server, flags, arguments))
        finally:
            for server, _ in setups.values():
                server.process.kill()
                server.process.wait()
    print(f"| {arguments.codec}, {arguments.rounds} rounds | plain text | TLS | ratio |\n| --- | --- | --- | --- |")
    for figure in rounds["plain"][0]:
        plain, tls = (min(one[figure] for one in rounds[setup]) for setup in ("plain", "TLS"))
        print(f"| {figure} | {plain:.2f} | {tls:.2f} | {tls / plain:.3f} |")


if __name__ == "__main__":
    main()
