# SPDX-License-Identifier: Apache-2.0
"""The figures of docs/sizing.md follow from those that were measured, and docs/operations.md knows every alert."""
import math
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
CODECS = ("planar", "planar-zstd", "quantised", "rgbd")
RATE = 10  # frames a second of a robot
BUSY = 0.7  # how busy cores shall be
WORKER_MB = 100  # that a frame on a worker leases, rounded up


def table(document, first_header):
    """The rows of the table that begins with this header."""
    text = (ROOT / document).read_text()
    found = re.search(rf"^\| {re.escape(first_header)} \|.*\n\| ---.*\n((?:\|.*\n)+)", text, re.M)
    assert found, f"{document} has no table that begins with '{first_header}'"
    return [[cell.strip() for cell in row.strip("| ").split(" | ")] for row in found[1].splitlines()]


def measured():
    """Of each codec: CPU seconds of the server a frame, and megabytes up and down."""
    rows = {row[0]: row for row in table("test/bench/BENCHMARK.md", "codec")}
    return {codec: (float(rows[codec][7].split(" + ")[0]) / 1000, float(rows[codec][5]) / 1000, float(rows[codec][6]) / 1000)
            for codec in CODECS}


def grouped(number):
    return f"{number:,.0f}"


class Sizing(unittest.TestCase):
    def test_cores_and_memory_for_robots(self):
        expected = []
        for codec, (cpu, up, _) in measured().items():
            for robots in (1, 10, 1000):
                busy = robots * RATE * cpu
                cores = max(math.ceil(busy / BUSY), 1)
                memory = cores * WORKER_MB + robots * up  # one frame of each robot waits
                expected.append([codec, grouped(robots), f"{busy:.2f}" if busy < 10 else grouped(busy), grouped(cores),
                                 f"{max(memory / 1000, 0.1):.1f}" if memory < 10_000 else grouped(memory / 1000)])
        self.assertEqual(table("docs/sizing.md", "codec, 10 Hz"), expected)

    def test_traffic_of_a_robot(self):
        expected = [[codec, f"{up + down:.3f}", f"{(up + down) * 8 * RATE:.1f}", f"{(up + down) * RATE * 3600 / 1000:.1f}"]
                    for codec, (_, up, down) in measured().items()]
        self.assertEqual(table("docs/sizing.md", "codec, one robot"), expected)

    def test_the_plan(self):
        cpu, up, down = measured()["rgbd"]
        robots, cell, machine, regions = 100_000, 1_000, 16, 5
        frames = robots * RATE
        cells = robots // cell
        machines = math.ceil(cell * RATE * cpu / BUSY / machine)
        others = cells // regions - 1
        expected = {
            "frames a second": grouped(frames),
            "busy cores": grouped(frames * cpu),
            "cells": grouped(cells),
            "busy cores of a cell": grouped(cell * RATE * cpu),
            "machines of a cell": grouped(machines),
            "machines in all": grouped(cells * machines),
            "cores in all": grouped(cells * machines * machine),
            "how busy they are": f"{cell * RATE * cpu / (machines * machine):.0%}",
            "with one machine of a cell lost": f"{cell * RATE * cpu / ((machines - 1) * machine):.0%}",
            "with one cell of a region lost": f"{cell * RATE * cpu / (machines * machine) * (1 + 1 / others):.0%}",
            "with one region lost": f"{cell * RATE * cpu / (machines * machine) * regions / (regions - 1):.0%}",
            "into a cell": f"{cell * RATE * up * 8 / 1000:.1f} Gbit/s",
            "into a machine": f"{cell * RATE * up * 8 / machines:.0f} Mbit/s",
            "out of a cell": f"{cell * RATE * down * 8 / 1000:.2f} Gbit/s",
            "in all": f"{frames * (up + down) * 8 / 1e6:.2f} Tbit/s",
            "connections of a machine": grouped(cell * 16 / machines),
            "series of Prometheus in a cell": grouped(409 * machines),
            "core-hours a month": grouped(cells * machines * machine * 730),
            "core-hours a robot and month": f"{cells * machines * machine * 730 / robots:.0f}",
            "GB out of the cells a robot and month": f"{RATE * 3600 * 730 * down / 1000:.0f}",
        }
        shown = {row[0]: row[2] for row in table("docs/sizing.md", "100,000 robots")}
        self.assertEqual(shown, expected)


class Alerts(unittest.TestCase):
    def test_each_has_its_line_in_operations(self):
        alerts = re.findall(r"- alert: (\w+)", (ROOT / "deploy/prometheus/alerts.yml").read_text())
        self.assertEqual([row[0].strip("`") for row in table("docs/operations.md", "alert")], alerts)


if __name__ == "__main__":
    unittest.main()
