# SPDX-License-Identifier: Apache-2.0
"""segserve.local gives what a server gives, and the package of client/python can be installed.

PYTHON_CLIENT_DIR is the folder client/python; the package that was built of it is in PYTHONPATH.
"""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import tempfile
import threading
import unittest

import numpy as np
import segserve

from harness import Server
from python_client import CODECS, PythonClient

SOURCE = pathlib.Path(os.environ["PYTHON_CLIENT_DIR"])


@unittest.skipUnless(importlib.util.find_spec("segserve._local"), "segserve.local was not built")
class Local(PythonClient):
    """segserve.local gives what the server gives, without it."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.local = importlib.import_module("segserve.local")

    def assert_same(self, ours, theirs):
        self.assertEqual(ours.labels.shape, theirs.labels.shape)
        for name in ("labels", "supervoxels", "segments"):
            self.assertEqual(getattr(ours, name).tobytes(), getattr(theirs, name).tobytes(), name)
        for name in ("leaf_points", "left", "right", "weight", "merged_rows"):
            np.testing.assert_array_equal(getattr(ours.tree, name), getattr(theirs.tree, name))
        for summary in (ours.summary, theirs.summary):
            summary.ClearField("timings")
        self.assertEqual(ours.summary, theirs.summary)

    def test_the_same_as_a_server_for_every_codec(self):
        for codec in CODECS:
            arguments = {"codec": codec, "view": "camera", "outputs": segserve.OUTPUTS}
            with self.subTest(codec):
                self.assert_same(self.local.segment(self.xyz, self.rgb, **arguments),
                                 self.client.segment(self.xyz, self.rgb, **arguments))

    def test_with_options_units_files_and_images(self):
        everything = {"outputs": segserve.OUTPUTS}
        for arguments in ({
                "method": "lambda",
                "regions": 9
        }, {
                "view": "world:0,0,-1",
                "options": {
                    "support_plane_distance": 0.01
                }
        }, {
                "view": "camera",
                "options": {
                    "range_max": 1.2
                }
        }, {
                "view": "world",
                "unit": "cm"
        }, {
                "options": {
                    "crop_max_x": 0.1,
                    "min_segment_points": 50
                }
        }):
            with self.subTest(arguments):
                self.assert_same(self.local.segment(self.xyz, self.rgb, **arguments, **everything),
                                 self.client.segment(self.xyz, self.rgb, **arguments, **everything))
        far = self.xyz.astype(np.float64) + 500_000
        self.assert_same(self.local.segment(far, view="world", **everything),
                         self.client.segment(far, view="world", **everything))
        self.assert_same(self.local.segment_file(self.scene, **everything),
                         self.client.segment_file(self.scene, **everything))
        depth = np.rint(np.nan_to_num(self.xyz[..., 2]) * 1000).astype(np.uint16)
        images = depth, self.rgb, (131.25, 131.25, 79.5, 59.5)
        self.assert_same(self.local.segment_rgbd(*images, **everything),
                         self.client.segment_rgbd(*images, **everything))

    def test_only_what_was_asked_for(self):
        result = self.local.segment(self.xyz, view="camera", outputs="tree")
        self.assertEqual((result.labels, result.supervoxels, result.segments), (None, None, None))
        self.assertGreater(result.tree.leaf_count, 10)

    def test_errors_are_those_of_a_server(self):
        for arguments in ({"options": {"voxel_resolution": 100}}, {"view": "world", "options": {"range_max": 1}}):
            caught = []
            for segment in (self.local.segment, self.client.segment):
                with self.assertRaises(segserve.InvalidArgument) as error:
                    segment(self.xyz, **{"view": "camera"} | arguments)
                caught.append((str(error.exception), error.exception.reason, error.exception.field_violations))
            self.assertEqual(*caught)
        with self.assertRaises(segserve.InvalidArgument) as error:
            self.local.segment(self.xyz - np.float32(100), view="camera")
        self.assertEqual(error.exception.reason, "INVALID_CLOUD")
        with self.assertRaises(segserve.DeadlineExceeded):
            self.local.segment(self.xyz, view="camera", timeout=0.0001)
        with self.assertRaises(ValueError):
            importlib.import_module("segserve._local").segment_payload(b"", [b"x"], b"", b"", None, 1.0)

    def test_threads_run_at_the_same_time(self):
        expected = self.local.segment(self.xyz, self.rgb, view="camera").labels
        found = [None] * 8
        running = threading.Event()

        def run(i):
            running.wait()
            found[i] = self.local.segment(self.xyz, self.rgb, view="camera").labels

        threads = [threading.Thread(target=run, args=(i,)) for i in range(len(found))]
        for thread in threads:
            thread.start()
        running.set()
        for thread in threads:
            thread.join()
        for labels in found:
            np.testing.assert_array_equal(labels, expected)


class Packages(unittest.TestCase):
    """What Debian's python3-build makes works where it is installed."""

    def test_wheel_and_source_distribution(self):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        repository = SOURCE.parent.parent
        for part in ("client/python", "proto"):
            shutil.copytree(repository / part,
                            folder / part,
                            ignore=shutil.ignore_patterns("build", "dist", "*.egg-info"))
        clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}

        def run(*command):
            done = subprocess.run(list(map(str, command)),
                                  cwd=folder,
                                  capture_output=True,
                                  text=True,
                                  timeout=250,
                                  env=clean)
            self.assertEqual(done.returncode, 0, f"{command}: {done.stdout} {done.stderr}")
            return done.stdout

        run("/usr/bin/python3", "-m", "build", "--no-isolation", "--outdir", folder / "dist",
            folder / "client" / "python")
        version = segserve.__version__
        wheel = folder / "dist" / f"segserve-{version}-py3-none-any.whl"
        self.assertTrue((folder / "dist" / f"segserve-{version}.tar.gz").exists())
        run("/usr/bin/python3", "-m", "venv", "--system-site-packages", folder / "venv")
        python = folder / "venv" / "bin" / "python"
        run(python, "-m", "pip", "install", "--no-index", "--no-deps", "--quiet", wheel)
        server = Server(folder)
        self.addCleanup(server.close)
        printed = run(python, "-c", f"""
import importlib.metadata, pathlib, numpy, segserve
assert pathlib.Path(segserve.__file__).is_relative_to({str(folder / "venv")!r}), segserve.__file__
assert (pathlib.Path(segserve.__file__).parent / "py.typed").exists()
y, x = numpy.mgrid[-60:60, -80:80] / 100
result = segserve.Client({server.address!r}).segment(numpy.stack([x, y, numpy.ones_like(x)], axis=-1))
print(importlib.metadata.version("segserve"), result.segment_count, result.view)
""")
        self.assertEqual(printed.split(), [version, "1", "camera"])


if __name__ == "__main__":
    unittest.main()
