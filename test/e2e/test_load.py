# SPDX-License-Identifier: Apache-2.0
"""Many robots send at once, with every codec: each label is right, and no robot starves."""
import json
import os
import unittest

from harness import EndToEnd

CODECS = "planar,planar-zstd,strided,strided-zstd,quantised,pcd,rgbd"
SECONDS = os.environ.get("LOAD_SECONDS", "60")
LEAST_SHARE = os.environ.get("LOAD_LEAST_SHARE", "50")  # percent of the mean over all clients


class ManyClients(EndToEnd):
    def test_32_clients_get_their_labels_and_their_share(self):
        done = self.run_well("bench", "--server", self.server.address, "--clients", "32", "--codec", CODECS,
                             "--size", "320x240", "--scenes", "2", "--duration", SECONDS, "--timeout", "60", "--verify",
                             "--objective", f"least-share>={LEAST_SHARE}%", "--objective", "errors<=0%", "--json", "-")
        told = json.loads(done.stdout)
        self.assertEqual([objective["met"] for objective in told["objectives"]], [True, True])
        self.assertEqual(len(told["results_of_client"]), 32)
        self.assertGreater(min(told["results_of_client"]), 1)
        self.assertEqual(told["verified"], told["frames"]["results"])
        self.assertEqual(told["mismatches"], 0)


if __name__ == "__main__":
    unittest.main()
