#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures how much load a server on this machine carries, and prints tables for BENCHMARK.md.

    test/bench/load_table.py [--build build/release] [--seconds 10] [FILES ...]

segctl bench measures a server that this script starts. FILES are PCD or PLY clouds; the default is synthetic frames of
640 x 480. The loop is closed with one frame in flight for each client; frames are encoded anew each time, and every label
array is verified. Server and clients share the machine's cores.
"""
import argparse
import json
import pathlib
import subprocess
import sys

from server_process import Server

CLIENTS = (1, 2, 4, 8)
CODECS = ("planar", "planar-zstd", "strided", "strided-zstd", "quantised", "pcd", "rgbd")


def measure(arguments, server, clients, codec):
    """The JSON of one run of segctl bench, with the server's CPU time per frame added (warm-up included)."""
    warm_up = 2
    frames = ["--input", *arguments.files] if arguments.files else []
    cpu = server.cpu_seconds()
    done = subprocess.run(
        [arguments.build / "client/segctl", "bench", "--server", server.address, "--clients", str(clients), "--codec",
         codec, "--duration", str(arguments.seconds), "--warm-up", str(warm_up), "--verify", "--json", "-", *frames],
        capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"segctl bench: {done.stderr}")
    told = json.loads(done.stdout)
    told["server_cpu_ms"] = 1000 * (server.cpu_seconds() - cpu) / (told["frames_per_s"] * (told["seconds"] + warm_up))
    return told


def row(told):
    """The columns that both tables share."""
    latency, results = told["latency_ms"], told["frames"]["results"]
    return (f"{told['frames_per_s']:.1f} | {told['mpoints_per_s']:.2f} | {latency['p50']:.0f} | {latency['p99']:.0f} | "
            f"{told['bytes_up'] / results / 1000:.0f} | {told['bytes_down'] / results / 1000:.0f} | "
            f"{told['server_cpu_ms']:.0f} + {told['client_cpu_ms_per_frame']:.0f} |")


HEAD = "frames/s | Mpoints/s | p50 ms | p99 ms | kB up | kB down | CPU ms a frame: server + client |"
RULE = "| --- " * 8 + "|"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("files", nargs="*")
    arguments = parser.parse_args()
    with Server(arguments.build / "server/segserve") as server:
        print(f"| clients | {HEAD}\n{RULE}", flush=True)
        for clients in CLIENTS:
            print(f"| {clients} | {row(measure(arguments, server, clients, 'planar'))}", flush=True)
        print(f"\n| codec | {HEAD}\n{RULE}", flush=True)
        for codec in CODECS:
            print(f"| {codec} | {row(measure(arguments, server, 2, codec))}", flush=True)


if __name__ == "__main__":
    main()
