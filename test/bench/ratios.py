#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures how much faster than PCL segserve is: runs segment_bench and prints tables for BENCHMARK.md.

    test/bench/ratios.py [--build build/release] [--json FILE] [--filter REGEX]

--json writes the contents of the tables, in milliseconds. The fastest of five repetitions counts, because the others
only add other load of the machine. Peers take turns with ours in the same run.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

STAGES = ("voxels", "normals", "supervoxels", "graph", "merging", "labels")
PEER_OF = {"border": "pcl-lccp", "lambda-convex": "pcl-vccs"}


def run(arguments):
    """The repetitions that segment_bench reports."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out.json"
        done = subprocess.run(
            [arguments.build / "test/bench/segment_bench", f"--benchmark_filter={arguments.filter}",
             "--benchmark_enable_random_interleaving=true", f"--benchmark_out={out}", "--benchmark_out_format=json"],
            stdout=subprocess.DEVNULL, check=False)
        if done.returncode != 0:
            sys.exit("segment_bench failed")
        return [entry for entry in json.loads(out.read_text())["benchmarks"] if entry["run_type"] == "iteration"]


def fastest(repetitions):
    """The fastest repetition of each benchmark, as a dictionary frame -> what -> repetition."""
    best = {}
    for entry in repetitions:
        if entry.get("error_occurred"):
            sys.exit(f"{entry['name']}: {entry['error_message']}")
        what, frame = entry["name"].split("/")[:2]
        known = best.setdefault(frame, {}).setdefault(what, entry)
        if entry["real_time"] < known["real_time"]:
            best[frame][what] = entry
    return best


def tables(best):
    """The rows of the tables as plain numbers in milliseconds."""
    rows = []
    for frame, runs in sorted(best.items()):
        for ours, peer in PEER_OF.items():
            if ours not in runs or peer not in runs:
                continue
            rows.append({"frame": frame, "method": ours, "finite_points": int(runs[ours]["finite_points"]),
                         "supervoxels": int(runs[ours]["supervoxel_count"]),
                         **{f"{stage}_ms": runs[ours][stage] for stage in STAGES},
                         "total_ms": runs[ours]["real_time"], "peer": peer, "peer_ms": runs[peer]["real_time"],
                         "ratio": runs[peer]["real_time"] / runs[ours]["real_time"]})
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--filter", default=".")
    arguments = parser.parse_args()
    rows = tables(fastest(run(arguments)))
    for method, peer in PEER_OF.items():
        print(f"| {method} on | " + " | ".join(STAGES) + f" | **total** | {peer} | **ratio** |\n" + "| --- " * 10 + "|")
        for row in (row for row in rows if row["method"] == method):
            stages = " | ".join(f"{row[f'{stage}_ms']:.1f}" for stage in STAGES)
            print(f"| {row['frame']}, {row['finite_points'] // 1000}k points | {stages} | **{row['total_ms']:.1f} ms** | "
                  f"{row['peer_ms']:.0f} ms | **{row['ratio']:.1f}** |")
        print()
    if arguments.json:
        arguments.json.write_text(json.dumps({"unit": "ms", "rows": rows}, indent=2) + "\n")


if __name__ == "__main__":
    main()
