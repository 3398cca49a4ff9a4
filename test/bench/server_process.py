# SPDX-License-Identifier: Apache-2.0
"""A segserve for benchmarks, and what the machine is."""
import os
import pathlib
import platform
import subprocess
import sys
import tempfile
import time


class Server:
    """A segserve on a free loopback port, which runs until the end of the `with` block."""

    def __init__(self, binary, *flags):
        self.folder = tempfile.TemporaryDirectory()
        self.port_file = pathlib.Path(self.folder.name) / "port"
        self.process = subprocess.Popen(
            [binary, "--listen", "127.0.0.1:0", "--port-file", self.port_file, "--log-level", "error", *flags])

    def __enter__(self):
        while not (self.port_file.exists() and self.port_file.read_text().strip()):
            if self.process.poll() is not None:
                sys.exit("segserve did not start")
            time.sleep(0.05)
        self.address = f"127.0.0.1:{self.port_file.read_text().strip()}"
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(timeout=60)
        self.folder.cleanup()

    def cpu_seconds(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def machine():
    """For example "2 cores of an AMD EPYC 7B13, Linux 6.1.0"."""
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    model = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())
    return f"{os.cpu_count()} cores of {model}, {platform.system()} {platform.release()}"


def stolen_share(before, after):
    """The share of the machine's CPU time between two readings of cpu_times that neither was idle nor went to this process and
    those that it started and waited for. It is told in percent."""
    (busy_before, all_before, own_before), (busy, everything, own) = before, after
    total = everything - all_before
    return 100 * max(0, busy - busy_before - (own - own_before)) / total if total > 0 else 0


def cpu_times(*pids):
    """Seconds of CPU: busy, all, and of this process, its children and the processes `pids`."""
    ticks = os.sysconf("SC_CLK_TCK")
    fields = [int(field) / ticks for field in pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]]
    own = os.times()
    seconds = own.user + own.system + own.children_user + own.children_system
    for pid in pids:
        stat = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        seconds += (int(stat[11]) + int(stat[12])) / ticks
    return sum(fields) - fields[3] - fields[4], sum(fields), seconds
