# SPDX-License-Identifier: Apache-2.0
"""The package is typed, and documents what it makes public."""
import inspect
import pathlib
import os
import re
import shutil
import subprocess
import unittest

import segserve

SOURCE = pathlib.Path(os.environ["PYTHON_CLIENT_DIR"])


class Typing(unittest.TestCase):
    @unittest.skipUnless(shutil.which("mypy"), "there is no mypy")
    def test_mypy_finds_nothing(self):
        package = pathlib.Path(segserve.__file__).parent
        done = subprocess.run([
            "mypy", "--config-file", SOURCE / "pyproject.toml", "--cache-dir", package.parent.parent / "mypy", "-p",
            "segserve"
        ],
                              cwd=package.parent,
                              capture_output=True,
                              text=True,
                              timeout=250)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_what_is_public_is_documented(self):
        undocumented = []
        for name in segserve.__all__:
            thing = getattr(segserve, name)
            if inspect.isclass(thing) and thing.__module__.startswith("segserve"):
                members = [(f"{name}.{member}", value) for member, value in vars(thing).items()
                           if inspect.isfunction(value) and not member.startswith("_")]
                undocumented += [member for member, value in members if not inspect.getdoc(value)]
            if (inspect.isclass(thing) or inspect.isfunction(thing)) and not inspect.getdoc(thing):
                undocumented.append(name)
        self.assertEqual(undocumented, [])

    def test_the_version_is_that_of_the_project(self):
        project = (SOURCE.parent.parent / "CMakeLists.txt").read_text()
        self.assertEqual(re.search(r"project\(segserve VERSION ([\d.]+)", project)[1], segserve.__version__)


if __name__ == "__main__":
    unittest.main()
