#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks who includes whom.

Folders may include those that LAYERS says and no others, so that arrows never run back. Public headers (in an include/
folder) include no private ones, the core includes neither gRPC nor protobuf nor PCL, Eigen stays out of units that are
compiled for AVX2, and no two headers have the same name. test/include_graph_test.py shows each rule fail.

    test/include_graph.py             checks the sources under git; prints a line for each fault
    test/include_graph.py --print     prints the arrows between folders that there are
"""

import collections
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# The steps of the method in the order in which data flows: each may include itself and those before it.
STEPS = ["core/base", "core/simd", "core/math", "core/cloud", "core/options", "core/voxels", "core/scale", "core/normals", "core/support_plane",
         "core/supervoxels", "core/region_graph", "core/weights", "core/border_points", "core/merging", "core/selection", "core/labels", "core/statistics", "core/pipeline", "core/tracking"]
PUBLIC_CORE = ["core/include"]
CODEC = [*PUBLIC_CORE, "core/base", "core/codec"]
LAB = [*PUBLIC_CORE, "core/base", "core/math", "core/codec", "core/lab"]
WIRE = [*PUBLIC_CORE, "core/base", "core/codec", "proto"]
RECORDING = [*PUBLIC_CORE, "core/base", "core/codec", "client/include", "client/recording"]
CLIENT = [*PUBLIC_CORE, "core/base", "proto", "client/include", "client/fleet", "client/tls", "client/calls", "client/stream"]

# Folder: what it may include besides itself. The longest folder that a file lies in counts.
LAYERS = {
    **{step: [*PUBLIC_CORE, *STEPS[:STEPS.index(step)]] for step in STEPS},
    "core/include": [],
    "core/codec": CODEC,
    "core/lab": LAB,
    "core/pcl_adapter": PUBLIC_CORE,
    "core/pcl_adapter/peer": [*PUBLIC_CORE, "core/base", "core/lab"],
    "proto/include": PUBLIC_CORE,
    "proto": [*WIRE, "proto/include"],
    "command_line": [],
    "tls": [*PUBLIC_CORE, "core/base"],
    "credentials": [*PUBLIC_CORE, "core/base"],
    "server": [*PUBLIC_CORE, "core/base", "proto", "proto/include", "command_line", "credentials", "tls", "server/http"],
    "server/http": [*PUBLIC_CORE, "core/base", "core/lab", "proto", "proto/include", "client/page", "command_line", "credentials", "tls", "server"],
    "client/page": [],
    "client/include": [*PUBLIC_CORE, "proto/include", "proto/generated"],
    "client/fleet": [*PUBLIC_CORE, "core/base", "proto", "proto/include", "client/include"],
    "client/tls": [*PUBLIC_CORE, "core/base", "client/include", "tls"],
    "client/calls": [*CLIENT, "proto/include"],
    "client/stream": [*CLIENT, "proto/include"],
    "client/recording": RECORDING,
    "client/load_test": [*CLIENT, "proto/include"],
    "client/bench_report": [*PUBLIC_CORE, "core/base"],
    "client/ros": [*PUBLIC_CORE, "core/base", "proto", "proto/include", "client/include", "client/recording"],
    "client/pcl": [*PUBLIC_CORE, "proto/include", "client/include", "core/pcl_adapter"],
    "client/segctl": [*CLIENT, "proto/include", "client/bench_report", "client/load_test", "client/page", "client/recording", "core/lab", "core/pcl_adapter/peer", "command_line", "credentials"],
    "client": [*CLIENT, "proto/include", "core/lab"],  # examples
}
GENERATED = re.compile(r"^(segserve/v\d|google/rpc|grpc/health|grpc/reflection)/.*\.pb\.h$|^server/(version|build_info)\.hpp$")
NETWORK = re.compile(r"^(grpc|google/|segserve/v\d/)")
PUBLIC_ROOTS = ["core/include", "client/include", "proto/include", "core/pcl_adapter/include", "client/pcl/include"]
INCLUDE = re.compile(r'^\s*#\s*include\s+["<]([^">]+)[">]', re.MULTILINE)


def layer_of(path):
    """The entry of LAYERS that a file belongs to, or None: tests may include everything."""
    parts = path.split("/")[:-1]
    for length in range(len(parts), 0, -1):
        folder = "/".join(parts[:length])
        if folder in LAYERS:
            return folder
    return None


def resolve(include, headers):
    """The path of a header of ours, or None."""
    for candidate in [include, *(f"{root}/{include}" for root in PUBLIC_ROOTS)]:
        if candidate in headers:
            return candidate
    return None


def faults(sources):
    """Yields a line for each fault. `sources`: path from the root -> text."""
    headers = {path for path in sources if path.endswith((".hpp", ".h"))}
    names = collections.defaultdict(list)
    for header in sorted(headers):
        names[header.rsplit("/", 1)[-1]].append(header)
    for name, paths in names.items():
        if len(paths) > 1:
            yield f"{' and '.join(paths)} have the same name"

    for path, text in sorted(sources.items()):
        layer = layer_of(path)
        if layer is None:
            continue
        allowed = [layer, *LAYERS[layer]]
        for include in INCLUDE.findall(text):
            target = resolve(include, headers)
            if target is None:
                core = path.startswith("core/")
                if core and NETWORK.match(include):
                    yield f"{path} includes {include}: the core knows neither gRPC nor protobuf"
                elif core and include.startswith("pcl/") and not layer.startswith("core/pcl_adapter"):
                    yield f"{path} includes {include}: PCL belongs into core/pcl_adapter alone"
                elif re.match(r"^(core|server|client|credentials|proto|segserve|test)/", include) and not GENERATED.match(include):
                    yield f"{path} includes {include}, which is no header of ours"
                elif "/simd/" in path and include.startswith("Eigen/"):
                    yield f"{path} includes {include}: units compiled for AVX2 must not share Eigen's inline functions"
                continue
            target_layer = layer_of(target)
            if "/include/" in path and "/include/" not in target:
                yield f"{path} is public and includes {target}, which is private"
            elif target_layer not in allowed:
                yield f"{path} includes {target}: {layer} must not know {target_layer or target}"


def own_sources():
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "*.hpp", "*.h", "*.cpp"], cwd=ROOT, check=True,
                            capture_output=True, text=True).stdout.split()
    return {path: (ROOT / path).read_text() for path in listed if (ROOT / path).is_file()}


def graph_of(sources):
    """Path -> the files of ours that it includes."""
    headers = {path for path in sources if path.endswith((".hpp", ".h"))}
    return {path: {resolve(include, headers) for include in INCLUDE.findall(text)} - {None} for path, text in sources.items()}


def reachable(path, graph):
    """A file and all that it includes, by way of others too."""
    found, waiting = {path}, [path]
    while waiting:
        new = graph.get(waiting.pop(), set()) - found
        found |= new
        waiting.extend(new)
    return found


def print_arrows(sources):
    headers = {path for path in sources if path.endswith((".hpp", ".h"))}
    arrows = collections.Counter()
    for path, text in sources.items():
        for include in INCLUDE.findall(text):
            target = resolve(include, headers)
            if target and layer_of(path) and layer_of(path) != layer_of(target):
                arrows[layer_of(path), layer_of(target)] += 1
    for (source, target), count in sorted(arrows.items()):
        print(f"{source} -> {target} ({count})")


def main():
    sources = own_sources()
    if sys.argv[1:] == ["--print"]:
        print_arrows(sources)
        return 0
    found = list(faults(sources))
    print(*found, sep="\n", end="\n" if found else "")
    print(f"include graph: {len(sources)} files, {len(found)} faults")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
