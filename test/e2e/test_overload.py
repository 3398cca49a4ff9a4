# SPDX-License-Identifier: Apache-2.0
"""Many times the load that a server carries, and it goes on carrying what it can."""
import json
import os
import subprocess
import unittest

from harness import SEGCTL, EndToEnd


class Overload(EndToEnd):
    server_flags = ("--workers", "1")
    SECONDS = int(os.environ.get("OVERLOAD_SECONDS", "5"))
    LEAST_SHARE = 0.9 if SECONDS >= 30 else 0.7  # of the peak; a few seconds on a shared machine tell no more

    def measure(self, *flags):
        done = subprocess.run([SEGCTL, "bench", "--server", self.server.address, "--clients", "8", "--size", "160x120",
                               "--scenes", "2", "--encoded-beforehand", "--duration", str(self.SECONDS), "--timeout", "3",
                               "--json", "-", *flags], capture_output=True, timeout=300, check=False)
        self.assertTrue(done.stdout, done.stderr)
        return json.loads(done.stdout)

    def test_goodput_stays_at_its_peak(self):
        peak = self.measure("--in-flight", "4")["frames"]["results"] / self.SECONDS
        for factor in (6, 10):
            told = self.measure("--rate", str(factor * peak))
            # The frames that were due in this time are answered within as long a time, some two seconds later.
            goodput = told["frames"]["results"] / self.SECONDS
            print(f"{self.id()}: {factor} times the load: {goodput / peak:.0%} of the peak of {peak:.0f} results/s", flush=True)
            self.assertGreater(goodput, self.LEAST_SHARE * peak, told)


if __name__ == "__main__":
    unittest.main()
