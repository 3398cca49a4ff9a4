# SPDX-License-Identifier: Apache-2.0
"""Every rule of commit_message.py fails on a message that breaks it, and accepts one that does not."""

import unittest

from commit_message import faults


class CommitMessageTest(unittest.TestCase):
    def check(self, message, *expected):
        found = list(faults(message))
        self.assertEqual(len(found), len(expected), found)
        for fault, words in zip(found, expected):
            self.assertIn(words, fault)

    def test_good_messages(self):
        self.check("Refuse ports above 65535\n\nThey wrapped around in silence.\n")
        self.check("Seed growth from the densest cells")
        self.check("Process frames in the order of their deadlines")

    def test_long_subjects(self):
        self.check("Add " + "x" * 68)
        self.check("Add " + "x" * 69, "73 columns")

    def test_periods(self):
        self.check("Refuse ports above 65535.", "ends with a period")

    def test_other_moods(self):
        for subject in ("Refused ports", "Refusing ports", "Refuses ports", "Voxels: slots are made as they are found"):
            self.check(subject, "not imperative")

    def test_small_letters(self):
        self.check("refuse ports", "capital letter")

    def test_the_second_line(self):
        self.check("Refuse ports\nabove 65535", "not blank")

    def test_empty_messages(self):
        self.check("\n", "empty")


if __name__ == "__main__":
    unittest.main()
