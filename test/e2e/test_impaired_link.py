# SPDX-License-Identifier: Apache-2.0
"""Over a slow, distant and lossy link no frame is lost, and a robot that drops old frames gets young results."""
import json
import subprocess
import time
import unittest

from harness import SEGCTL, SUCCESS, EndToEnd
from impairing_proxy import ImpairingProxy


class ImpairedLink(EndToEnd):
    # A server that only this machine can reach would not look for distant clients.
    server_flags = ("--insecure-beyond-loopback",)
    server_listen = "0.0.0.0:0"

    def proxy(self, **link):
        proxy = ImpairingProxy(self.server.address, **link)
        self.addCleanup(proxy.close)
        return proxy

    def start_bench(self, proxy, *flags):
        load = subprocess.Popen([SEGCTL, "bench", "--server", proxy.address, "--json", "-", "--encoded-beforehand", *flags],
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(load.communicate)
        self.addCleanup(load.kill)
        return load

    def told(self, load):
        stdout, stderr = load.communicate(timeout=120)
        self.assertEqual(load.returncode, SUCCESS, stderr.decode())
        return json.loads(stdout)

    def test_results_of_rgbd_are_young_although_segments_are_lost(self):
        proxy = self.proxy()
        told = self.told(self.start_bench(proxy, "--rate", "30", "--drop-oldest", "--in-flight", "2", "--duration", "8",
                                          "--codec", "rgbd", "--objective", "errors<100%"))
        self.assertGreater(proxy.lost, 0)
        self.assertGreater(told["frames"]["results"], 20)
        self.assertLess(told["latency_ms"]["p90"], 500)
        self.assertEqual(set(told["errors"]) - {"DROPPED"}, set())

    def test_no_frame_is_lost_where_one_segment_in_fifty_is(self):
        proxy = self.proxy(loss=0.02, delay=0.05, jitter=0.02)
        told = self.told(self.start_bench(proxy, "--size", "160x120", "--rate", "5", "--duration", "5", "--verify"))
        self.assertGreater(proxy.lost, 10)
        self.assertEqual((told["frames"]["sent"], told["mismatches"], told["errors"]), (told["frames"]["results"], 0, {}))

    def test_no_frame_is_lost_while_the_link_is_gone_for_three_seconds(self):
        proxy = self.proxy()
        load = self.start_bench(proxy, "--size", "160x120", "--rate", "5", "--duration", "8", "--verify", "--timeout", "30")
        time.sleep(3)
        proxy.cut()
        time.sleep(3)
        proxy.mend()
        told = self.told(load)
        self.assertEqual((told["frames"]["sent"], told["mismatches"], told["errors"]), (told["frames"]["results"], 0, {}))
        self.assertGreater(told["latency_ms"]["max"], 1000, "the frames of that time waited")


if __name__ == "__main__":
    unittest.main()
