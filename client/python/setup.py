# SPDX-License-Identifier: Apache-2.0
"""Makes the protobuf modules of the package while it is built. pyproject.toml says everything else.

The modules of google/rpc are made under the name segserve.rpc. Protobuf refuses to hold two different files of one name
in a process, and googleapis-common-protos, which many programs have, brings its own google/rpc. The bytes on the wire
are the same.
"""
import os
import pathlib
import shutil
import subprocess
import tempfile

import setuptools
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = pathlib.Path(__file__).resolve().parent
API = ("google/rpc/error_details", "google/rpc/status", "segserve/v1/block", "segserve/v1/cloud",
       "segserve/v1/error_reason", "segserve/v1/options", "segserve/v1/prompts", "segserve/v1/result",
       "segserve/v1/segment", "segserve/v1/segmentation_service", "segserve/v1/server_info", "segserve/v1/stream",
       "segserve/v1/tracking")

#: The compiled module of segserve.local, if the package shall have it.
LOCAL_MODULE = os.environ.get("SEGSERVE_LOCAL_MODULE")


def proto_folder():
    """Where the API is: in a source distribution beside this file, else in the repository."""
    packed = HERE / "proto" / "segserve"
    return packed.parent if packed.exists() else HERE.parent.parent / "proto"


def renamed(text):
    return text.replace("google/rpc/", "segserve/rpc/").replace("google.rpc", "segserve.rpc")


def generate(folder):
    """Writes the modules, and stubs with their types, below `folder`."""
    protoc = shutil.which("protoc")
    if protoc is None:
        raise SystemExit("segserve: protoc is needed to build this package (Debian: protobuf-compiler)")
    with tempfile.TemporaryDirectory() as scratch:
        names = [renamed(f"{name}.proto") for name in API] + ["segserve/rpc/health.proto"]
        texts = [renamed((proto_folder() / f"{name}.proto").read_text()) for name in API]
        texts.append((HERE / "proto" / "health.proto").read_text())
        for name, text in zip(names, texts):
            path = pathlib.Path(scratch) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        subprocess.run([protoc, f"--proto_path={scratch}", f"--python_out={folder}", f"--pyi_out={folder}", *names],
                       check=True)


class BuildWithMessages(build_py):
    def run(self):
        super().run()
        generate(self.build_lib)
        if LOCAL_MODULE:
            shutil.copy(LOCAL_MODULE, pathlib.Path(self.build_lib) / "segserve")


class Package(setuptools.Distribution):
    def has_ext_modules(self):
        """With the compiled module, the wheel is for this platform only."""
        return bool(LOCAL_MODULE)


class SourceWithApi(sdist):
    def make_release_tree(self, base_dir, files):
        super().make_release_tree(base_dir, files)
        for name in API:
            target = pathlib.Path(base_dir) / "proto" / f"{name}.proto"
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(proto_folder() / f"{name}.proto", target)


setuptools.setup(distclass=Package, cmdclass={"build_py": BuildWithMessages, "sdist": SourceWithApi})
