#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what a server on this machine carries: each codec by 1 to 32 clients. It writes docs/capacity.md, and a page with charts.

    test/bench/capacity.py [--build build/release] [--seconds 5] [--codecs planar,rgbd] [--clients 1,2,4] [--html capacity.html]
                           [--output docs/capacity.md] [FILES ...]

segctl bench measures a server that this script starts, which shares the cores with it. FILES are clouds; the default is synthetic
frames of 640 x 480. The loop is closed, with one frame in flight for each client, and frames are encoded anew each time. What other
processes take of the machine is measured and told: figures of a busy machine are no capacity.
"""
import argparse
import datetime
import json
import pathlib
import subprocess
import sys

from server_process import Server, cpu_times, machine, stolen_share

ROOT = pathlib.Path(__file__).resolve().parents[2]
CODECS = "planar,planar-zstd,strided,strided-zstd,quantised,pcd,rgbd"
CLIENTS = "1,2,4,8,16,32"
BUSY_PERCENT = 10  # From here on other load of the machine decides what is measured.


def load_test(arguments, server, codec, clients):
    """The JSON of a load test, the CPU seconds that it took the server, and the share of the machine that others took. Where a busy machine gives
    no result within its time, it is repeated, and takes longer."""
    frames = ["--input", *arguments.files] if arguments.files else []
    for longer in (1, 4, 16):
        before, cpu = cpu_times(server.process.pid), server.cpu_seconds()
        done = subprocess.run(
            [arguments.build / "client/segctl", "bench", "--server", server.address, "--clients", str(clients), "--codec", codec,
             "--duration", str(longer * arguments.seconds), "--warm-up", "1", "--json", "-", *frames],
            capture_output=True, text=True, check=False)
        told = json.loads(done.stdout) if done.stdout else None
        if told and told["frames"]["results"] > 0 and told["achieved_frames_per_s"] > 0:
            return told, server.cpu_seconds() - cpu, stolen_share(before, cpu_times(server.process.pid))
        print(f"{codec}, {clients} clients: {done.stderr.strip()}", file=sys.stderr, flush=True)
    sys.exit("the server is too slow to be measured")


def measure(arguments, server, codec, clients):
    """The JSON of a load test, and a point of a report (the list "points" of that JSON) with the codec and costs added."""
    told, cpu, stolen = load_test(arguments, server, codec, clients)
    results = told["frames"]["results"]
    # With the warm-up and with what came after the window.
    everything = sum(entry["results"] for entry in told["timeline"])
    return told, {
        "label": f"{codec}, {clients} client{'s' if clients > 1 else ''}", "codec": codec, "clients": clients, "offered_frames_per_s": None,
        "achieved_frames_per_s": told["achieved_frames_per_s"], "mpoints_per_s": told["mpoints_per_s"],
        "bytes_up_per_s": told["achieved_frames_per_s"] * told["bytes_up"] / results,
        "bytes_up_per_frame": told["bytes_up"] / results, "latency_ms": told["latency_ms"], "results": results,
        "failed": told["frames"]["failed"], "least_share_percent": told["least_share_percent"],
        "server_cpu_ms_per_frame": 1000 * cpu / everything,
        "client_cpu_ms_per_frame": told["client_cpu_ms_per_frame"], "stolen_percent": stolen, "verdict": None}


def report(last, points):
    """All points in the format of segctl bench, for its page. Machine and programs are those of the last load test."""
    results, failed = (sum(point[key] for point in points) for key in ("results", "failed"))
    stolen = sum(point["stolen_percent"] for point in points) / len(points)
    best = max(points, key=lambda point: point["achieved_frames_per_s"])
    findings = [{"code": "BEST", "text": f"The figures at the top are those of {best['label']}, which reached the most."}]
    if stolen >= BUSY_PERCENT:
        findings.append({"code": "BUSY_MACHINE", "text": f"Other processes took {stolen:.0f} % of the machine's CPU time meanwhile."})
    return {key: last[key] for key in ("format", "started", "host", "client_build", "server_info", "server") if key in last} | {
        "command": ["test/bench/capacity.py", *sys.argv[1:]], "clients": max(point["clients"] for point in points), "loop": "closed",
        "frames": {"sent": results + failed, "results": results}, "latency_ms": best["latency_ms"],
        "achieved_frames_per_s": best["achieved_frames_per_s"], "mpoints_per_s": best["mpoints_per_s"], "points": points,
        "errors": {}, "codec": best["codec"], "findings": findings}


def ms(value):
    """Milliseconds as text. A percentile that falls among failed frames has no value."""
    return "∞" if value is None else f"{value:.0f}"


def table(points, clients, title, cell):
    """A row for each codec, a column for each number of clients."""
    rows = [f"| {title} | " + " | ".join(f"{count}" for count in clients) + " |", "| --- " * (len(clients) + 1) + "|"]
    for codec in dict.fromkeys(point["codec"] for point in points):
        own = {point["clients"]: point for point in points if point["codec"] == codec}
        rows.append(f"| {codec} | " + " | ".join(cell(own[count]) for count in clients) + " |")
    return "\n".join(rows)


def markdown(points, clients, seconds, last, files):
    stolen = [point["stolen_percent"] for point in points]
    mean = sum(stolen) / len(stolen)
    others = (f"Other processes took {mean:.0f} % of the machine's CPU time meanwhile, {min(stolen):.0f} to {max(stolen):.0f} % in a load "
              "test. ")
    if mean >= BUSY_PERCENT:
        others += ("**So these figures are no capacity: the machine was busy with other work.** A quiet one carries several times as much, "
                   "and a frame costs it less than half the CPU time, because nothing else uses its caches. "
                   "[BENCHMARK.md](../test/bench/BENCHMARK.md#under-load) has figures of a quiet machine.")
    frames = "the clouds that were given to it" if files else "synthetic frames of 640 x 480 (307,200 points)"
    best = max(points, key=lambda point: point["achieved_frames_per_s"])
    bests = [max((point for point in points if point["codec"] == codec), key=lambda point: point["achieved_frames_per_s"])
             for codec in dict.fromkeys(point["codec"] for point in points)]
    each = "\n".join(
        f"| {p['codec']} | {p['clients']} | {p['achieved_frames_per_s']:.1f} | {p['mpoints_per_s']:.2f} | {p['bytes_up_per_s'] / 1e6:.1f} | "
        f"{p['bytes_up_per_frame'] / 1000:.0f} | {ms(p['latency_ms']['p50'])} | {ms(p['latency_ms']['p99'])} | "
        f"{p['server_cpu_ms_per_frame']:.1f} + {p['client_cpu_ms_per_frame']:.1f} |" for p in bests)
    failed = sum(point["failed"] for point in points)
    return f"""# Capacity

```sh not run: takes five minutes on a quiet machine
test/bench/capacity.py --html capacity.html # writes this page, and one with charts
```

This page was made by that command on {datetime.date.today().isoformat()}, on {machine()}. Server and clients share the cores. Each load test is a closed loop of
{seconds:g} s after a second of warm-up, with {frames} and one frame in flight for each client;
frames are encoded anew each time, as on robots. {failed} frames failed. The server is version {last.get('server_info', {}).get('version', 'unknown')}.

{others}

The most was {best['achieved_frames_per_s']:.1f} frames/s, or {best['mpoints_per_s']:.1f} million points a second, by {best['codec']} and {best['clients']} client{'s' if best['clients'] > 1 else ''}.

## Each codec at its best

CPU is that of the server, and that of the client with encoding and decoding.

| codec | clients | frames/s | Mpoints/s | MB/s up | kB up a frame | p50 ms | p99 ms | CPU ms a frame: server + client |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
{each}

## By the number of clients

{table(points, clients, "frames/s by clients", lambda p: f"{p['achieved_frames_per_s']:.1f}")}

{table(points, clients, "Mpoints/s by clients", lambda p: f"{p['mpoints_per_s']:.1f}")}

{table(points, clients, "MB/s up by clients", lambda p: f"{p['bytes_up_per_s'] / 1e6:.1f}")}

{table(points, clients, "CPU ms a frame, server + client", lambda p: f"{p['server_cpu_ms_per_frame']:.0f} + {p['client_cpu_ms_per_frame']:.0f}")}

{table(points, clients, "p99 ms by clients", lambda p: ms(p['latency_ms']['p99']))}
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--codecs", type=lambda text: text.split(","), default=CODECS.split(","))
    parser.add_argument("--clients", type=lambda text: [int(n) for n in text.split(",")], default=[int(n) for n in CLIENTS.split(",")])
    parser.add_argument("--html", type=pathlib.Path)
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/capacity.md")
    parser.add_argument("files", nargs="*")
    arguments = parser.parse_args()
    points = []
    with Server(arguments.build / "server/segserve") as server:
        for codec in arguments.codecs:
            for clients in arguments.clients:
                last, point = measure(arguments, server, codec, clients)
                points.append(point)
                print(f"{point['label']}: {point['achieved_frames_per_s']:.1f} frames/s, others took {point['stolen_percent']:.0f} %",
                      file=sys.stderr, flush=True)
    arguments.output.write_text(markdown(points, arguments.clients, arguments.seconds, last, arguments.files))
    if arguments.html:
        subprocess.run([arguments.build / "client/segctl", "bench", "show", "-", "--html", arguments.html], check=True, text=True,
                       input=json.dumps(report(last, points)), stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
