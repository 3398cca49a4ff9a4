#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the memory of a server, and prints the tables for docs/sizing.md.

    test/bench/memory.py [--build build/release] [--seconds 4] [--workers 2]

Robots send frames of 640 x 480 as fast as they may. The first table has, for each codec, the most that the ledger has leased at
once and the most resident memory, with one frame of a robot in flight. The second one has the resident memory beside robots that
are connected by a stream and hardly send, which is what a connection costs. Both are read from the server's metrics.
"""
import argparse
import contextlib
import pathlib
import re
import subprocess
import tempfile
import threading
import time
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
CODECS = ("planar", "planar-zstd", "quantised", "rgbd")
MEGABYTE = 1e6


class Server:
    """A server whose metrics are watched."""

    def __init__(self, binary, folder, workers):
        ports = [pathlib.Path(folder) / name for name in ("port", "metrics-port")]
        for port in ports:
            port.unlink(missing_ok=True)
        self.process = subprocess.Popen([
            binary, "--listen", "127.0.0.1:0", "--port-file", ports[0], "--metrics-listen", "127.0.0.1:0", "--metrics-port-file",
            ports[1], "--workers", str(workers), "--log-level", "error"
        ])
        while not all(port.exists() and port.read_text().strip() for port in ports):
            time.sleep(0.02)
        self.address, self.metrics = (f"127.0.0.1:{port.read_text().strip()}" for port in ports)

    def read(self):
        """Resident and leased bytes now."""
        page = urllib.request.urlopen(f"http://{self.metrics}/metrics", timeout=20).read().decode()
        resident = float(re.search(r"^process_resident_memory_bytes (\S+)", page, re.M)[1])
        return resident, sum(float(value) for value in re.findall(r"^segserve_memory_leased_bytes\{[^}]*\} (\S+)", page, re.M))

    @contextlib.contextmanager
    def watched(self):
        """Yields a list that holds the most of both in the end."""
        most, stop = [0.0, 0.0], threading.Event()

        def watch():
            while not stop.wait(0.1):
                most[:] = map(max, most, self.read())

        thread = threading.Thread(target=watch)
        thread.start()
        try:
            yield most
        finally:
            stop.set()
            thread.join()

    def close(self):
        self.process.terminate()
        self.process.wait()


def bench(segctl, server, *flags):
    subprocess.run([segctl, "bench", "--server", server.address, "--warm-up", "0", *map(str, flags)], check=True, capture_output=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--seconds", type=float, default=4)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    segctl, binary = options.build / "client" / "segctl", options.build / "server" / "segserve"

    with tempfile.TemporaryDirectory() as folder:
        print("| codec | robots | workers | leased, MB | resident, MB |\n| --- | --- | --- | --- | --- |")
        for codec in CODECS:
            for robots in (1, options.workers, 8 * options.workers):
                server = Server(binary, folder, options.workers)
                with server.watched() as most:
                    bench(segctl, server, "--clients", robots, "--duration", options.seconds, "--codec", codec)
                server.close()
                print(f"| {codec} | {robots} | {options.workers} | {most[1] / MEGABYTE:.0f} | {most[0] / MEGABYTE:.0f} |", flush=True)

        print("\n| connected robots | resident, MB |\n| --- | --- |")
        for robots in (0, 100, 400):
            server = Server(binary, folder, options.workers)
            with server.watched() as most:
                if robots > 0:
                    bench(segctl, server, "--clients", robots, "--rate", 20, "--duration", robots / 20, "--size", "16x16", "--scenes", 1)
                else:
                    time.sleep(1)
            server.close()
            print(f"| {robots} | {most[0] / MEGABYTE:.0f} |", flush=True)


main()
