# SPDX-License-Identifier: Apache-2.0
"""A real scene gives the same labels byte for byte with and without the server."""
import unittest

from harness import DATA, EndToEnd

SCENES = sorted((DATA / "osd" / "learn").glob("learn*.pcd"))


@unittest.skipUnless(SCENES, f"there is no real scene in {DATA}/osd/learn")
class RealScene(EndToEnd):
    def test_local_and_remote_agree_byte_for_byte(self):
        for scene in (SCENES[0], SCENES[-1]):
            files = []
            for where in (("--local",), ("--server", self.server.address),
                          ("--server", self.server.address, "--codec", "pcd")):
                output = self.path("labeled.pcd")
                self.run_well("segment", scene, "-q", "-o", output, *where)
                files.append(output.read_bytes())
            self.assertEqual(files[0], files[1])
            self.assertEqual(files[0], files[2])

    def test_every_finite_point_has_one_segment(self):
        labels, told = self.segment(SCENES[0])
        self.assertEqual(len(labels), told["points"])
        self.assertEqual(sum(label > 0 for label in labels), told["finite"])
        self.assertGreater(told["segments"], 1)


if __name__ == "__main__":
    unittest.main()
