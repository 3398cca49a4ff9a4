#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what the Python client adds to the server's time, and prints tables for client/python/README.md.

    test/bench/python_client.py [--build build/release] [--seconds 5] [--rounds 3] [FILE]

FILE is an organized cloud in the frame of a camera; the default is a synthetic frame of 640 x 480. The first table is
of single calls: medians of the time to encode the cloud, of the whole call, of the server's own time within it, of the
difference, and the mean CPU time of the client, which depends less on what else the machine does. The second one is of
streams, beside `segctl bench`, the C++ client, which takes turns with them. Server and clients share the machine's
cores.
"""
import argparse
import asyncio
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test" / "bench"))
from load_table import Server  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build" / "release")
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("file", nargs="?")
    return parser.parse_args()


def median_ms(times):
    return 1000 * statistics.median(times)


def measure_calls(segserve, client, xyz, rgb, codec, seconds):
    encode, whole, server, cpu = [], [], [], []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        began = time.perf_counter()
        segserve.encode(xyz, rgb, view="camera", codec=codec)
        encode.append(time.perf_counter() - began)
        cpu_began, began = time.process_time(), time.perf_counter()
        result = client.segment(xyz, rgb, view="camera", codec=codec)
        whole.append(time.perf_counter() - began)
        cpu.append(time.process_time() - cpu_began)
        server.append(result.timings["total"] / 1000)
    beyond = [call - own for call, own in zip(whole, server)]
    return [*(median_ms(times) for times in (encode, whole, server, beyond)), 1000 * statistics.mean(cpu)]


def frames(xyz, rgb, seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        yield xyz, rgb


def threads(segserve, address, xyz, rgb, in_flight, seconds):
    with segserve.Client(address) as client:
        with client.stream(view="camera", max_in_flight=in_flight, outputs="labels") as stream:
            began = time.monotonic()
            count = sum(outcome.get().points > 0 for outcome in stream.map(frames(xyz, rgb, seconds)))
            return count / (time.monotonic() - began)


def asynchronous(segserve, address, xyz, rgb, in_flight, seconds):
    async def run():
        async with segserve.aio.Client(address) as client:
            async with client.stream(view="camera", max_in_flight=in_flight, outputs="labels") as stream:
                began, count = time.monotonic(), 0
                async for outcome in stream.map(frames(xyz, rgb, seconds)):
                    count += outcome.get().points > 0
                return count / (time.monotonic() - began)

    return asyncio.run(run())


def segctl_bench(segctl, address, scene, in_flight, seconds):
    done = subprocess.run([
        segctl, "bench", "--server", address, "--input", scene, "--in-flight",
        str(in_flight), "--duration",
        str(seconds), "--json", "-"
    ],
                          check=True,
                          capture_output=True)
    return json.loads(done.stdout)["frames_per_s"]


def main():
    options = arguments()
    sys.path.insert(0, str(options.build / "client" / "python" / "package"))
    import numpy as np
    import segserve

    segctl = options.build / "client" / "segctl"
    with tempfile.TemporaryDirectory() as folder, Server(options.build / "server" / "segserve") as server:
        scene = pathlib.Path(options.file or f"{folder}/scene.pcd")
        if options.file is None:
            subprocess.run([segctl, "synth", "-q", "-o", scene], check=True)
        subprocess.run([segctl, "segment", scene, "--local", "-q", "-o", f"{folder}/scene.npy"], check=True)
        cloud = segserve.as_cloud(np.load(f"{folder}/scene.npy"))
        xyz, rgb = cloud.xyz.reshape(*cloud.shape, 3), cloud.rgb.reshape(*cloud.shape, 3)
        print(f"{scene.name}: {cloud.width} x {cloud.height} points\n")
        print(
            "| codec | encode | call | server's own | beyond the server | CPU of the client |\n"
            "| --- | --- | --- | --- | --- | --- |"
        )
        with segserve.Client(server.address) as client:
            for codec in segserve.CODECS:
                row = measure_calls(segserve, client, xyz, rgb, codec, options.seconds)
                print(f"| {codec} | " + " | ".join(f"{time:.1f}" for time in row) + " |", flush=True)
        print(
            "\n| frames in flight | Python, threads | Python, asyncio | C++ (segctl bench) |\n| --- | --- | --- | --- |"
        )
        for in_flight in (1, 2, 4):
            rates = [(threads(segserve, server.address, xyz, rgb, in_flight, options.seconds),
                      asynchronous(segserve, server.address, xyz, rgb, in_flight, options.seconds),
                      segctl_bench(segctl, server.address, scene, in_flight, options.seconds))
                     for _ in range(options.rounds)]
            print(f"| {in_flight} | " + " | ".join(f"{statistics.median(rate):.1f}" for rate in zip(*rates)) + " |",
                  flush=True)


main()
