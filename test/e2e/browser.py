# SPDX-License-Identifier: Apache-2.0
"""Opens pages in headless Chromium."""
import json
import os
import pathlib
import shutil
import subprocess
import unittest

import node_packages

HERE = pathlib.Path(__file__).resolve().parent
CHROMIUM = shutil.which("chromium")
PLAYWRIGHT = {"playwright-core": "1.60.0"}
SIZE = (760, 460)


class Browser:
    """Chromium, in which clients/browser.js does steps."""

    def __init__(self):
        environment = os.environ | {"NODE_PATH": str(node_packages.installed("playwright", PLAYWRIGHT))}
        self.process = subprocess.Popen(["node", HERE / "clients/browser.js", CHROMIUM], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, env=environment)

    def visit(self, page, steps, downloads, size):
        told = {"page": str(page), "size": size, "steps": steps, "downloads": str(downloads)}
        self.process.stdin.write(json.dumps(told).encode() + b"\n")
        self.process.stdin.flush()
        answer = json.loads(self.process.stdout.readline())
        if "error" in answer:
            raise AssertionError(answer["error"])
        return answer

    def close(self):
        self.process.stdin.close()
        self.process.wait(timeout=60)
        self.process.stdout.close()


class PageTest(unittest.TestCase):
    """Tests of pages in `folder`, which a class sets."""

    folder = None

    @classmethod
    def start_browser(cls):
        if CHROMIUM is not None:
            cls.browser = Browser()
            cls.addClassCleanup(cls.browser.close)

    def open(self, page, *steps, faults=(), size=SIZE):
        """The answers to the steps. `faults` are expected in the page, one text for each."""
        if CHROMIUM is None:
            self.skipTest("there is no chromium: pages are not opened")
        downloads = self.folder / self.id()
        downloads.mkdir(exist_ok=True)
        told = self.browser.visit(page, steps, downloads, size)
        addresses = [address for address in told["requests"] if not address.startswith("blob:")]  # These are saved.
        self.assertEqual(addresses, [f"file://{page}"], "the page must load nothing")
        self.assertEqual(len(told["faults"]), len(faults), told["faults"])
        for fault, expected in zip(told["faults"], faults):
            self.assertIn(expected, fault)
        return told["answers"]
