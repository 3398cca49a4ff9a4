#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores the method on synthetic scenes of every kind of sensor, and prints one table. Compares two settings, or two programs.

    test/bench/kinds.py [--kinds REGEX] [--scenes N] [--first-seed 1] [--segctl build/release/client/segctl]
                        [--other SEGCTL] [--a "FLAGS"] [--b "FLAGS"] [--keep FOLDER] [--json FILE] [--list]

Each kind has N scenes with the seeds FIRST, FIRST + 1 and so on. A is `--segctl eval` with the flags of --a, B is
`--other eval` with those of --b; B is left out unless one of the two is given. Without --other, B is the program of A;
without --b, B has the flags of A. All scenes are made by --segctl. --keep leaves them in a folder, where the next run
finds them; remove them after a change of `segctl synth`.

    test/bench/kinds.py --scenes 3 --a="--voxel-resolution 0.008" --b="--voxel-resolution 0.006 --seed-resolution 0.024"
    test/bench/kinds.py --kinds "view|street" --other ../other/build/release/client/segctl

Columns: `regions`, the labeled regions of the ground truth a scene; `one_to_one` and `objects`, the WOv of
core/lab/eval/README.md for all regions and for the objects; `segments` a scene; `ms` of the segmentation alone.
"""
import argparse
import json
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SENSORS = ("kinect1", "stereo", "passive-stereo", "tof", "ideal")
RINGS = ("16", "32", "64", "128")
KINDS = {
    **{f"table-{sensor}": ("--sensor", sensor) for sensor in SENSORS},
    "table-crowded": ("--objects", "20", "--clutter", "1", "--stacked", "0.5"),
    "table-hollow": ("--hollow", "--objects", "10"),
    "table-hollow-stereo": ("--hollow", "--objects", "10", "--sensor", "stereo"),
    "table-near": ("--distance", "0.5"),
    "table-far": ("--distance", "3"),
    "table-small": ("--width", "160", "--height", "120"),
    **{f"view-{sensor}": ("--room-view", "--sensor", sensor) for sensor in SENSORS},
    "view-small": ("--room-view", "--sensor", "tof", "--width", "160", "--height", "120"),
    "view-large": ("--room-view", "--sensor", "stereo", "--width", "1280", "--height", "720"),
    **{f"room-{rings}": ("--lidar", rings) for rings in RINGS},
    **{f"street-{rings}": ("--lidar", rings, "--street") for rings in RINGS},
    "fused": ("--fused", "--points", "300000"),
    "fused-furnished": ("--fused", "--points", "500000", "--size", "1.6", "--furnished"),
}
SCORES = ("one_to_one", "objects", "segments", "ms")


def run(segctl, *arguments):
    """What segctl writes to standard output. A failure ends this program."""
    done = subprocess.run([segctl, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{segctl} {' '.join(map(str, arguments))}:\n{done.stderr}")
    return done.stdout


def make_scenes(segctl, kind, seeds, folder):
    """Makes the scenes that the folder lacks. Returns the mean number of labeled regions."""
    folder.mkdir(parents=True, exist_ok=True)
    regions = []
    for seed in seeds:
        scene, told = folder / f"{seed}.pcd", folder / f"{seed}.json"
        if not (scene.exists() and told.exists()):
            run(segctl, "synth", *KINDS[kind], "--seed", seed, "-q", "-o", scene, "--json", told)
        regions.append(json.loads(told.read_text())["regions"])
    return sum(regions) / len(regions)


def score(segctl, flags, folder):
    """The means over the scenes of a folder, and one_to_one scene by scene."""
    told = json.loads(run(segctl, "eval", "--data", folder, *flags, "--json", "-"))
    return {"one_to_one": told["one_to_one"]["wov"], "objects": told["paper_objects"]["wov"],
            "segments": told["segments"], "ms": told["ms"],
            "per_scene": [row["one_to_one"]["wov"] for row in told["per_scene"]]}


def print_row(*cells):
    print("| " + " | ".join(cells) + " |", flush=True)


def print_head(compares):
    head = ["kind", "scenes", "regions"]
    if compares:
        head += ["one_to_one A", "B", "B - A", "better : worse", "objects A", "B", "B - A", "segments A", "B", "ms A", "B"]
    else:
        head += ["one_to_one", "objects", "segments", "ms"]
    print_row(*head)
    print_row(*["---"] * len(head))


def numbers(row, what):
    """The cells of a score: of A alone, or of A, B, and for WOv their difference."""
    form = "{:.4f}" if what in ("one_to_one", "objects") else "{:.0f}" if what == "segments" else "{:.1f}"
    cells = [form.format(row[side][what]) for side in ("a", "b") if side in row]
    if what in ("one_to_one", "objects") and "b" in row:
        cells.append(f"{row['b'][what] - row['a'][what]:+.4f}")
    return cells


def print_scores(name, row):
    cells = numbers(row, "one_to_one")
    if "b" in row:
        pairs = list(zip(row["a"]["per_scene"], row["b"]["per_scene"]))
        cells.append(f"{sum(b > a for a, b in pairs)} : {sum(b < a for a, b in pairs)}")
    for what in SCORES[1:]:
        cells += numbers(row, what)
    print_row(name, str(len(row["a"]["per_scene"])), f"{row['regions']:.0f}", *cells)


def mean_of(rows):
    """The mean over the kinds, each of which counts the same."""
    total = {"regions": sum(row["regions"] for row in rows) / len(rows)}
    for side in ("a", "b"):
        if side in rows[0]:
            total[side] = {what: sum(row[side][what] for row in rows) / len(rows) for what in SCORES}
            total[side]["per_scene"] = [value for row in rows for value in row[side]["per_scene"]]
    return total


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kinds", default=".", help="only the kinds in whose name this regular expression is found")
    parser.add_argument("--scenes", type=int, default=3, help="scenes of each kind")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--segctl", type=pathlib.Path, default=ROOT / "build/release/client/segctl")
    parser.add_argument("--other", type=pathlib.Path, help="the segctl of B")
    parser.add_argument("--a", default="", help="flags of segctl eval for A")
    parser.add_argument("--b", help="flags of segctl eval for B")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the scenes")
    parser.add_argument("--json", type=pathlib.Path, help="write the numbers of the table to this file")
    parser.add_argument("--list", action="store_true", help="list the kinds with their flags of segctl synth, and end")
    arguments = parser.parse_args()
    arguments.chosen = [kind for kind in KINDS if re.search(arguments.kinds, kind)]
    if not arguments.chosen:
        parser.error(f"no kind has {arguments.kinds} in its name; --list lists them")
    if arguments.scenes < 1:
        parser.error("--scenes must be at least 1")
    for segctl in (arguments.segctl, arguments.other):
        if segctl is not None and not segctl.is_file():
            parser.error(f"there is no {segctl}; build it, or name another one")
    return arguments


def table(arguments, folder):
    """Prints the table row by row, and returns its numbers."""
    sides = {"a": (arguments.segctl, shlex.split(arguments.a))}
    if arguments.other is not None or arguments.b is not None:
        flags = arguments.a if arguments.b is None else arguments.b
        sides["b"] = (arguments.other or arguments.segctl, shlex.split(flags))
    for side, (segctl, flags) in sides.items():
        print(f"{side.upper()}: {' '.join([str(segctl), 'eval', *flags])}\n")
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.scenes)
    print_head("b" in sides)
    rows = {}
    for kind in arguments.chosen:
        scenes = folder / f"{kind}-{seeds[0]}-{seeds[-1]}"  # eval scores all scenes of a folder
        row = rows[kind] = {"regions": make_scenes(arguments.segctl, kind, seeds, scenes)}
        for side, (segctl, flags) in sides.items():
            row[side] = score(segctl, flags, scenes)
        print_scores(kind, row)
    if len(rows) > 1:
        print_scores("**mean of kinds**", mean_of(list(rows.values())))
    return rows


def main():
    arguments = parse()
    if arguments.list:
        for kind in arguments.chosen:
            print(f"{kind:20} segctl synth {' '.join(KINDS[kind])}")
        return
    with tempfile.TemporaryDirectory(prefix="segserve-kinds-") as temporary:
        rows = table(arguments, arguments.keep or pathlib.Path(temporary))
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
