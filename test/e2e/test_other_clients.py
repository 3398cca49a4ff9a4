# SPDX-License-Identifier: Apache-2.0
"""Clients in other languages, made from the .proto files alone, get the same labels as segctl and cut the merge tree as
segctl does."""
import os
import pathlib
import shutil
import struct
import subprocess
import unittest

from harness import EndToEnd
import pcd

HERE = pathlib.Path(__file__).resolve().parent
PROTO = HERE.parent.parent / "proto"
CUTS = ("regions-7", "regions-1", "threshold-0.2", "threshold-1")
GRPC_JS = {"@grpc/grpc-js": "1.14.0", "@grpc/proto-loader": "0.8.0"}


def run(*command, **options):
    done = subprocess.run(list(map(str, command)), capture_output=True, timeout=280, **options)
    if done.returncode != 0:
        raise AssertionError(f"{command}: {done.stdout.decode()} {done.stderr.decode()}")


def grpc_js():
    """The folder with grpc-js, which npm installs once in the cache folder (test/lint keeps buf there, too)."""
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "segserve"
    folder = cache / "-".join(["grpc-js", *GRPC_JS.values()])
    if not (folder / "node_modules" / "@grpc" / "proto-loader").exists():
        folder.mkdir(parents=True, exist_ok=True)
        run("npm", "install", "--prefix", folder, "--no-audit", "--no-fund", "--no-package-lock", "--loglevel=error",
            *(f"{name}@{version}" for name, version in GRPC_JS.items()))
    return folder / "node_modules"


class OtherClients(EndToEnd):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.expected = {}
        for seed, shape in enumerate([(160, 120), (200, 90), (64, 48)], start=1):
            scene = cls.folder / f"scene-{seed}.pcd"
            cls().run_well("synth", "-o", scene, "--quiet", "--seed", seed, "--width", shape[0], "--height", shape[1])
            labels = cls.folder / f"labeled-{seed}.pcd"
            result = cls.folder / f"result-{seed}.segres"
            cls().run_well("segment", scene, "--local", "-q", "-o", labels, "--result", result)
            expected = {"labels": pcd.read_labels(labels)}
            for cut in CUTS:
                kind, value = cut.split("-")
                cls().run_well("cut", result, f"--{kind}", value, "--cloud", scene, "-q", "-o", labels)
                expected[cut] = pcd.read_labels(labels)
            cls.expected[cls.write_planes(scene, seed, shape)] = expected

    @classmethod
    def write_planes(cls, scene, seed, shape):
        """Writes the scene in the form that the clients read."""
        folder = cls.folder / f"planes-{seed}"
        folder.mkdir()
        x, y, z, color = pcd.read_points(scene)
        for name, values in (("x.f32", x), ("y.f32", y), ("z.f32", z)):
            (folder / name).write_bytes(struct.pack(f"<{len(values)}f", *values))
        (folder / "rgb.u8").write_bytes(b"".join(value.to_bytes(4, "big")[1:] for value in color))
        (folder / "shape").write_text("{} {}".format(*shape))
        return folder

    def runTest(self):
        """Only so that setUpClass can use our methods."""

    def check(self, *names):
        for folder, expected in self.expected.items():
            for name in names:
                file = folder / f"{name}.u32"
                content = file.read_bytes()
                self.assertEqual(list(struct.unpack(f"<{len(content) // 4}I", content)), expected[name], file)
                file.unlink()

    def folders(self):
        """Every cloud several times, so that the credit is used up."""
        return [str(folder) for folder in self.expected] * 5

    def test_python(self):
        generated = self.folder / "generated"
        generated.mkdir()
        run("protoc", f"--proto_path={PROTO}", f"--python_out={generated}",
            *sorted(path.relative_to(PROTO) for path in PROTO.glob("*/*/*.proto") if path.parts[-3] != "google"),
            *sorted(path.relative_to(PROTO) for path in PROTO.glob("google/rpc/*.proto")))
        # Debian's Python has the package grpc. The Python that runs this test may be another one.
        run("/usr/bin/python3", HERE / "clients" / "stream_client.py", generated, self.server.address, *self.folders())
        self.check("labels", *CUTS)

    @unittest.skipUnless(shutil.which("npm"), "there is no npm")
    def test_javascript(self):
        run("node", HERE / "clients" / "stream_client.js", PROTO, self.server.address, *self.folders(),
            env=os.environ | {"NODE_PATH": str(grpc_js())})
        self.check("labels")
