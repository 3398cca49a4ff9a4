# SPDX-License-Identifier: Apache-2.0
"""The package of client/js gives objects the ids that segctl gives them, also when servers change.

JS_PACKAGE is the folder of the package that was built of client/js.
"""
import json
import pathlib
import signal
import subprocess
import threading
import time
import unittest

from harness import Server
import pcd
from test_js_client import node, PACKAGE
from test_js_web import WebClient

SCRIPT = pathlib.Path(__file__).resolve().parent / "clients" / "js_tracking.mjs"
FRAMES = 8


class FollowingObjects(WebClient):
    """A moving scene, and what segctl tells of it."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.moving, followed = cls.folder / "moving", cls.folder / "followed"
        cls().run_well("synth", "--moving", cls.moving, "--frames", FRAMES, "--rate", 4, "--width", 160, "--height", 120,
                       "--objects", 6, "--clutter", 0, "--compact", "--quiet")
        done = cls().run_well("segment", cls.moving, "--track", "--json", "-", "--out-dir", followed, "--server", cls.server.address)
        cls.told = [json.loads(line) for line in done.stdout.splitlines()]
        cls.of_points = [pcd.read_labels(followed / f"frame_{i:04}.pcd") for i in range(FRAMES)]

    def begin(self, by, address=None, **options):
        process = node(SCRIPT, PACKAGE, address or self.server.address, self.moving, json.dumps({"by": by} | options),
                       stdin=subprocess.PIPE)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def follow(self, by, address=None, **options):
        """What the client tells of each frame."""
        output, error = (process := self.begin(by, address, **options)).communicate(timeout=120)
        self.assertEqual((process.returncode, error), (0, ""))
        return [json.loads(line) for line in output.splitlines()]

    def check(self, lines, begin=0, end=FRAMES):
        """They tell of these frames what segctl does."""
        for number, ours, theirs in zip(range(begin, end), lines, self.told[begin:end], strict=True):
            with self.subTest(frame=number):
                self.assertEqual(ours["ids"], theirs["track_ids"])
                self.assertEqual([(event["kind"], event["track"], event["other"]) for event in ours["events"]],
                                 [(event["kind"], event["track"], event.get("other", 0)) for event in theirs["track_events"]])
                self.assertEqual(ours["stateBytes"], theirs["track_state_bytes"])
                self.assertTrue(ours["ofPoints"] == self.of_points[number], "the ids of points differ")


class AsSegctlTells(FollowingObjects):
    def test_the_scene_is_worth_a_test(self):
        ids = [set(line["track_ids"]) - {0} for line in self.told]
        self.assertGreaterEqual(len(set.intersection(*ids)), 4, ids)
        self.assertTrue(any(line["track_events"] for line in self.told[1:]), "nothing becomes of any object")

    def test_by_calls(self):
        self.check(self.follow("calls"))

    def test_by_the_client_for_browsers(self):
        self.check(self.follow("calls", self.url, web=True))

    def test_by_a_stream(self):
        for rules in ({}, {"maxInFlight": 1}, {"order": "done", "maxWaiting": 8}):
            self.check(self.follow("stream", rules=rules))

    def test_a_saved_state_goes_on_in_another_process(self):
        state = self.path("state")
        self.check(self.follow("stream", to=3, save=str(state)), 0, 3)
        self.check(self.follow("calls", **{"from": 3}, to=5, restore=str(state), save=str(state)), 3, 5)
        self.check(self.follow("stream", **{"from": 5}, restore=str(state)), 5)


class WhenServersChange(FollowingObjects):
    """Two servers of their own, one of which stops in mid-stream."""

    PAUSE = 3  # before the frame of this number

    def setUp(self):
        self.pair = [Server(self.folder) for _ in range(2)]
        for server in self.pair:
            self.addCleanup(server.close)

    def run_through(self, stop):
        """Calls `stop` with the server that has the stream, and with a function that lets the stream go on."""
        process = self.begin("stream", ",".join(server.address for server in self.pair), pauseAt=self.PAUSE)
        lines = [json.loads(process.stdout.readline()) for _ in range(self.PAUSE)]
        first = next(server for server in self.pair if server.address == lines[0]["server"])

        def go_on():
            process.stdin.write("\n")
            process.stdin.flush()

        stop(first, go_on)
        output, error = process.communicate(timeout=120)
        self.assertEqual((process.returncode, error), (0, ""))
        lines += map(json.loads, output.splitlines())
        self.check(lines)
        self.assertEqual({line["server"] for line in lines[:self.PAUSE]}, {first.address})
        self.assertEqual({line["server"] for line in lines[self.PAUSE:]}, {server.address for server in self.pair} - {first.address})
        return max(line["attempts"] for line in lines)

    def test_between_frames(self):
        def stop(server, go_on):
            server.close()
            go_on()

        self.run_through(stop)

    def test_while_a_frame_is_under_way(self):
        def stop(server, go_on):
            server.process.send_signal(signal.SIGSTOP)
            go_on()
            time.sleep(0.5)
            server.close()

        self.assertEqual(self.run_through(stop), 2)

    def test_by_draining(self):
        def stop(server, go_on):
            thread = threading.Thread(target=server.terminate)
            thread.start()
            thread.join()
            go_on()

        self.run_through(stop)


del FollowingObjects, WebClient  # which have no tests

if __name__ == "__main__":
    unittest.main()
