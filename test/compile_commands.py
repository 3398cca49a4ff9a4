# SPDX-License-Identifier: Apache-2.0
"""The compiler commands of the preset `lint`: one for each source, which is compiled alone and without precompiled headers."""

import json
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / "lint"
GENERATED_HEADERS = ["proto/generated/segserve/v1/segmentation_service.grpc.pb.h", "proto/health/grpc/health/v1/health.grpc.pb.h",
                     "proto/reflection/grpc/reflection/v1/reflection.grpc.pb.h"]


def load():
    """The path of each source of ours, relative to the root -> its entry of compile_commands.json.

    Configures build/lint, which needs the packages of the library, and makes the generated headers. Nothing is compiled."""
    subprocess.run(["cmake", "--preset", "lint", "--log-level=WARNING"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", str(BUILD), "--quiet", *GENERATED_HEADERS], check=True)
    entries = {}
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        path = pathlib.Path(entry["file"]).resolve()
        if path.is_relative_to(ROOT) and not path.is_relative_to(BUILD):
            entries[str(path.relative_to(ROOT))] = entry
    return entries
