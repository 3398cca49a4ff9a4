# SPDX-License-Identifier: Apache-2.0
"""segctl bench shows a load test on a terminal while it goes on, and nothing where there is none; --html shows it afterwards."""
import fcntl
import json
import os
import pty
import re
import struct
import subprocess
import termios
import unittest

from harness import SEGCTL, SUCCESS, EndToEnd

SMALL = ("--size", "96x72", "--scenes", "1", "--warm-up", "1", "--duration", "2")
MOVES_UP = re.compile(r"\x1b\[\d+A\r\x1b\[J")
COLORS = re.compile(r"\x1b\[[\d;]*m")


class BenchLive(EndToEnd):
    def on_terminal(self, *flags, columns=100, **variables):
        """The exit code, and what a terminal gets on standard error; standard output goes elsewhere."""
        here, there = pty.openpty()
        fcntl.ioctl(there, termios.TIOCSWINSZ, struct.pack("HHHH", 30, columns, 0, 0))
        environment = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "LC_ALL", "LC_CTYPE")}
        command = [SEGCTL, "bench", "--server", self.server.address, *SMALL, *flags]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=there,
                              env=environment | {"TERM": "xterm", "LANG": "C.UTF-8"} | variables) as process:
            os.close(there)
            text = b""
            while True:
                try:
                    part = os.read(here, 65536)
                except OSError:  # The other end is closed.
                    break
                if not part:
                    break
                text += part
            process.stdout.read()
        os.close(here)
        return process.returncode, text.decode().replace("\r\n", "\n")

    def test_a_terminal_shows_rate_percentiles_and_bars_and_is_left_clean(self):
        code, text = self.on_terminal("--rate", "20")
        self.assertEqual(code, SUCCESS, text)
        pictures = [COLORS.sub("", picture) for picture in MOVES_UP.split(text)]
        self.assertIn("warm-up", text)
        last = pictures[-2].splitlines()  # After the last one everything is wiped.
        self.assertEqual(pictures[-1], "")
        self.assertRegex(last[0], r"^bench +\d+ % \[#+-*\]  1 client, planar$")
        self.assertRegex("".join(pictures), r"\nnow +[\d.]+ of [\d.]+ frames/s +p50 ")
        # A slow server still answers when nothing is sent any more, and no rate is planned.
        self.assertRegex(last[1], r"^now +[\d.]+( of [\d.]+)? frames/s +p50 +[\d.]+  p99 +[\d.]+ ms  0 failed$")
        self.assertRegex(last[2], r"^so far +\d+ results +p50 +[\d.]+  p99 +[\d.]+ ms  0 failed$")
        self.assertRegex(last[3], r"^p99 +[▁▂▃▄▅▆▇█ ]+ [\d.]+ to [\d.]+ ms$")

    def test_colors_are_left_out_where_they_are_not_wanted(self):
        self.assertRegex(self.on_terminal()[1], COLORS)
        self.assertNotRegex(self.on_terminal(NO_COLOR="1")[1], COLORS)

    def test_a_narrow_terminal_gets_lines_that_fit(self):
        for line in MOVES_UP.sub("", COLORS.sub("", self.on_terminal(columns=40)[1])).splitlines():
            self.assertLess(len(line), 40, line)

    def test_a_terminal_that_cannot_move_its_cursor_gets_nothing(self):
        self.assertEqual(self.on_terminal(TERM="dumb"), (SUCCESS, ""))

    def test_a_run_is_saved_shown_and_compared(self):
        saved, page = self.path("run.json"), self.path("run.html")
        done = self.run_well("bench", "--server", self.server.address, *SMALL, "--json", saved)
        told = json.loads(saved.read_text())
        self.assertIn(f"throughput    {told['achieved_frames_per_s']:.1f} frames/s", done.stdout.decode())
        shown = self.run_well("bench", "show", saved).stdout.decode()
        self.assertIn(f"throughput    {told['achieved_frames_per_s']:.1f} frames/s", shown)
        same = self.run_well("bench", "diff", saved, saved).stdout.decode()
        self.assertRegex(same, r"\np50, ms +([\d.]+) +\1 +\+0\.0 %")
        self.run_well("bench", "--server", self.server.address, *SMALL, "--json", saved, "--html", page)
        data = re.search(r'<script type="application/json" id="page-data">(.*?)</script>', page.read_text())[1]
        self.assertEqual(json.loads(data), json.loads(saved.read_text()))


if __name__ == "__main__":
    unittest.main()
