# SPDX-License-Identifier: Apache-2.0
"""The package of client/js can be packed, installed and used, and has the types that it says.

JS_PACKAGE is the folder of the package that was built of client/js, JS_CLIENT_DIR is client/js.
"""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from harness import Server

PACKAGE = pathlib.Path(os.environ["JS_PACKAGE"])
SOURCE = pathlib.Path(os.environ["JS_CLIENT_DIR"])


class Packages(unittest.TestCase):
    """What `npm pack` makes works where it is installed, and its types are those that it has."""

    MODULES = PACKAGE / "node_modules"

    def run_well(self, *command, folder):
        done = subprocess.run(list(map(str, command)), cwd=folder, capture_output=True, text=True, timeout=250)
        self.assertEqual(done.returncode, 0, f"{command}: {done.stdout} {done.stderr}")
        return done.stdout

    def packed(self, folder):
        """The package, built as README.md says."""
        repository = SOURCE.parent.parent
        ignored = shutil.ignore_patterns("node_modules", "build", "dist", "*.tgz")
        for part in ("client/js", "client/python/proto", "proto"):
            shutil.copytree(repository / part, folder / part, ignore=ignored)
        shutil.copy(repository / "LICENSE", folder)
        (folder / "client/js/node_modules").symlink_to(self.MODULES.resolve())
        self.run_well("npm", "pack", folder=folder / "client/js")
        file, = (folder / "client/js").glob("segserve-*.tgz")
        return file

    def installed(self, folder, file):
        """A project with nothing but the package and what it depends on."""
        modules = folder / "project/node_modules"
        (modules / "segserve").mkdir(parents=True)
        self.run_well("tar", "-xzf", file, "--strip-components=1", "-C", modules / "segserve", folder=folder)
        packages = json.loads((SOURCE / "package-lock.json").read_text())["packages"]
        for path, package in packages.items():
            name = path.removeprefix("node_modules/")
            if name and "node_modules/" not in name and not package.get("dev"):
                (modules / name).parent.mkdir(exist_ok=True)
                (modules / name).symlink_to((self.MODULES / name).resolve())
        return folder / "project"

    def test_the_example_is_checked_and_runs(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        file = self.packed(folder)
        names = self.run_well("tar", "-tzf", file, folder=folder).split()
        self.assertLessEqual({"package/package.json", "package/README.md", "package/dist/LICENSE", "package/dist/index.d.ts",
                              "package/dist/web.js", "package/dist/gen/segserve/v1/stream_pb.js"}, set(names))
        self.assertFalse([name for name in names if name.endswith(".ts") and not name.endswith(".d.ts")])
        project = self.installed(folder, file)
        shutil.copy(SOURCE / "example_stream.ts", project)
        (project / "package.json").write_text('{"type": "module"}')
        (project / "page.ts").write_text('import {Client, type Result} from "segserve/web";\n'
                                         'export const ask = (xyz: Float32Array): Promise<Result> =>\n'
                                         '    new Client("https://a").segment({xyz, view: "world:0,0,1", outputs: ["labels"]});\n')
        compiler = [self.MODULES / ".bin/tsc", "--strict", "--target", "ES2022", "--module", "NodeNext", "--types", "node"]
        self.run_well(*compiler, "--noEmit", "page.ts", "example_stream.ts", folder=project)
        (project / "wrong.ts").write_text('import {Client} from "segserve";\n'
                                          'await new Client("a").segment({xyz: [1, 2, 3]});\n'
                                          'new Client("a").stream({whenBehind: "panic"});\n')
        done = subprocess.run([*compiler, "--noEmit", "wrong.ts"], cwd=project, capture_output=True, text=True, timeout=100)
        self.assertRegex(done.stdout, r"(?s)wrong\.ts\(2,.*wrong\.ts\(3,")

        self.run_well(*compiler, "example_stream.ts", folder=project)
        server = Server(folder)
        self.addCleanup(server.close)
        lines = self.run_well("node", "example_stream.js", server.address, 10, folder=project).splitlines()
        self.assertEqual(len(lines), 10)
        self.assertRegex("\n".join(lines), r"frame \d+: 2 segments after \d+ ms")


if __name__ == "__main__":
    unittest.main()
