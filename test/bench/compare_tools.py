#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Loads a server with the same small frame by h2load, by a loop of grpc-js and by segctl bench, and prints a table for
BENCHMARK.md.

    test/bench/compare_tools.py [--build build/release] [--rounds 3] [--seconds 5]

h2load (Debian's nghttp2-client, `deploy/install-packages bench`) and grpc-js make unary calls with the same bytes. segctl bench
sends the frame on a stream, as the C++ client does; it has no unary mode. The tools take turns, each alone with the server, and
each with as many frames under way; of the rounds the one with the median throughput counts.
"""
import argparse
import json
import math
import os
import pathlib
import re
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile

from server_process import Server, cpu_times, machine, stolen_share

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/e2e"))
import node_packages  # noqa: E402
import pcd  # noqa: E402

GRPC_JS = {"@grpc/grpc-js": "1.14.0", "@grpc/proto-loader": "0.8.0"}
SIZE = (64, 48)
CONCURRENCY = (1, 8)
METHOD = "segserve.v1.SegmentationService/Segment"


def nearest_rank(values, percent):
    return sorted(values)[max(1, math.ceil(percent / 100 * len(values) - 1e-9)) - 1]


def run(*command, **options):
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        sys.exit(f"{command[0]}: {done.stdout} {done.stderr}")
    return done.stdout


class Frame:
    """A small synthetic frame in the forms that the tools read."""

    def __init__(self, build, folder):
        self.file, self.planes, self.request = folder / "small.pcd", folder, folder / "request"
        run(build / "client/segctl", "synth", "--output", self.file, "--quiet", "--width", SIZE[0], "--height", SIZE[1])
        x, y, z, color = pcd.read_points(self.file)
        for name, values in (("x.f32", x), ("y.f32", y), ("z.f32", z)):
            (folder / name).write_bytes(struct.pack(f"<{len(values)}f", *values))
        (folder / "rgb.u8").write_bytes(b"".join(value.to_bytes(4, "big")[1:] for value in color))
        (folder / "shape").write_text("{} {}".format(*SIZE))
        self.answer_bytes = None


def by_grpc_js(arguments, server, frame, concurrency):
    environment = os.environ | {"NODE_PATH": str(node_packages.installed("grpc-js", GRPC_JS))}
    told = json.loads(run("node", ROOT / "test/bench/unary_loop.js", ROOT / "proto", server.address, frame.planes, arguments.seconds,
                          concurrency, frame.request, env=environment))
    frame.answer_bytes = told["answer_bytes"]
    return {"calls": told["calls"], "failed": told["failed"], "seconds": told["seconds"], "client_cpu": told["cpu_seconds"],
            "p50": statistics.median(told["microseconds"]) / 1000, "p99": nearest_rank(told["microseconds"], 99) / 1000}


def by_h2load(arguments, server, frame, concurrency):
    log = frame.planes / "h2load.log"
    log.unlink(missing_ok=True)
    before = os.times()
    text = run("h2load", "-D", int(arguments.seconds), "-c", concurrency, "-m", 1, "-d", frame.request, "-H",
               "content-type: application/grpc", "-H", "te: trailers", f"--log-file={log}", f"http://{server.address}/{METHOD}")
    after = os.times()
    rows = [line.split("\t") for line in log.read_text().splitlines()]
    milliseconds = [int(row[2]) / 1000 for row in rows if row[1] == "200"]
    # An error of gRPC has the status 200 of HTTP, too, but no message: the bytes tell.
    data_bytes = int(re.search(r"traffic: .*\((\d+)\) data", text)[1])
    if abs(data_bytes / len(milliseconds) / frame.answer_bytes - 1) > 0.05:
        sys.exit(f"h2load got {data_bytes / len(milliseconds):.0f} bytes a call, but an answer has {frame.answer_bytes}: {text}")
    return {"calls": len(milliseconds), "failed": len(rows) - len(milliseconds), "seconds": int(arguments.seconds),
            "p50": statistics.median(milliseconds), "p99": nearest_rank(milliseconds, 99),
            "client_cpu": after.children_user + after.children_system - before.children_user - before.children_system}


def by_segctl(arguments, server, frame, concurrency):
    told = json.loads(run(arguments.build / "client/segctl", "bench", "--server", server.address, "--input", frame.file, "--codec", "planar",
                          "--clients", concurrency, "--duration", arguments.seconds, "--warm-up", 0, "--encoded-beforehand", "--json", "-"))
    frames = told["frames"]
    return {"calls": frames["results"], "failed": frames["sent"] - frames["results"], "seconds": arguments.seconds,
            "p50": told["latency_ms"]["p50"], "p99": told["latency_ms"]["p99"],
            "client_cpu": told["client_cpu_ms_per_frame"] * frames["results"] / 1000}


# grpc-js comes first, because it makes the request of h2load.
TOOLS = {"grpc-js loop, unary": by_grpc_js, "h2load, unary": by_h2load, "segctl bench, stream": by_segctl}


def measure(arguments, server, frame, tool, concurrency):
    times, cpu = cpu_times(server.process.pid), server.cpu_seconds()
    told = TOOLS[tool](arguments, server, frame, concurrency)
    if told["failed"] > 0:
        sys.exit(f"{tool}: {told['failed']} frames failed")
    return told | {"rate": told["calls"] / told["seconds"], "server_cpu": server.cpu_seconds() - cpu,
                   "stolen": stolen_share(times, cpu_times(server.process.pid))}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=int, default=5)
    arguments = parser.parse_args()
    if shutil.which("h2load") is None:
        sys.exit("h2load is not installed: deploy/install-packages bench")
    rounds = {}
    with tempfile.TemporaryDirectory() as name, Server(arguments.build / "server/segserve") as server:
        frame = Frame(arguments.build, pathlib.Path(name))
        by_grpc_js(argparse.Namespace(seconds=1), server, frame, 1)  # warms the server up
        for _ in range(arguments.rounds):
            for concurrency in CONCURRENCY:
                for tool in TOOLS:
                    rounds.setdefault((concurrency, tool), []).append(measure(arguments, server, frame, tool, concurrency))
    stolen = statistics.mean(told["stolen"] for all_rounds in rounds.values() for told in all_rounds)
    print(f"{SIZE[0]} x {SIZE[1]} points a frame, {machine()}; other processes took {stolen:.0f} % of the machine's CPU time.\n")
    print("| under way | tool | frames/s (all rounds) | p50 ms | p99 ms | CPU ms a frame: server | client |")
    print("| --- " * 7 + "|")
    for (concurrency, tool), told in rounds.items():
        rates = sorted(each["rate"] for each in told)
        median = min(told, key=lambda each: abs(each["rate"] - statistics.median(rates)))
        print(f"| {concurrency} | {tool} | {median['rate']:.0f} ({rates[0]:.0f} to {rates[-1]:.0f}) | {median['p50']:.2f} | {median['p99']:.2f} | "
              f"{1000 * median['server_cpu'] / median['calls']:.2f} | {1000 * median['client_cpu'] / median['calls']:.2f} |")


if __name__ == "__main__":
    main()
