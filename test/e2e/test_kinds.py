# SPDX-License-Identifier: Apache-2.0
"""test/bench/kinds.py scores scenes of every kind of sensor."""
import json
import pathlib
import subprocess
import unittest

from harness import SEGCTL, EndToEnd

KINDS = pathlib.Path(__file__).resolve().parents[1] / "bench/kinds.py"


class Kinds(EndToEnd):
    def kinds(self, *flags):
        return subprocess.run([KINDS, "--segctl", SEGCTL, *map(str, flags)], capture_output=True, timeout=240, check=True,
                              text=True).stdout

    def test_a_row_has_the_scores_of_eval(self):
        scenes, numbers = self.path("scenes"), self.path("numbers.json")
        text = self.kinds("--kinds", "^(table-small|street-16)$", "--scenes", 2, "--keep", scenes, "--json", numbers)
        rows = json.loads(numbers.read_text())
        self.assertEqual(list(rows), ["table-small", "street-16"])
        for kind, row in rows.items():
            told = json.loads(self.run_well("eval", "--data", scenes / f"{kind}-1-2", "--json", "-").stdout)
            self.assertEqual(row["a"]["one_to_one"], told["one_to_one"]["wov"])
            self.assertEqual(row["a"]["objects"], told["paper_objects"]["wov"])
            self.assertEqual((row["a"]["segments"], len(row["a"]["per_scene"])), (told["segments"], 2))
            self.assertIn(f"| {kind} | 2 | {row['regions']:.0f} | {row['a']['one_to_one']:.4f} |", text)
        self.assertGreater(rows["street-16"]["regions"], 20)
        self.assertIn("**mean of kinds**", text)

    def test_two_settings_stand_side_by_side(self):
        numbers = self.path("numbers.json")
        flags = ("--kinds", "^table-small$", "--scenes", 1, "--json", numbers)
        self.kinds(*flags, "--other", SEGCTL)
        row = json.loads(numbers.read_text())["table-small"]
        self.assertEqual(row["a"]["one_to_one"], row["b"]["one_to_one"])
        text = self.kinds(*flags, "--b=--threshold 1")
        row = json.loads(numbers.read_text())["table-small"]
        self.assertGreater(row["a"]["one_to_one"], row["b"]["one_to_one"])
        self.assertIn(f"| {row['b']['one_to_one'] - row['a']['one_to_one']:+.4f} | 0 : 1 |", text)

    def test_every_listed_kind_can_be_made(self):
        for line in self.kinds("--list").splitlines():
            kind, _, command, *flags = line.split()
            with self.subTest(kind=kind):
                self.assertEqual(command, "synth")
                self.run_well(command, *flags, "-q", "-o", self.path("scene.pcd"))


if __name__ == "__main__":
    unittest.main()
