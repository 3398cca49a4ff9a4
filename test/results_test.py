# SPDX-License-Identifier: Apache-2.0
"""results.py tells which tests failed, and counts them."""
import pathlib
import tempfile
import unittest

import results


def report(**tests):
    """The XML of tests by their names: their state, or the output of one that failed."""
    status = {"passed": "run", "skipped": "notrun"}
    cases = "".join(f'<testcase name="{name.replace("__", ".")}" status="{status.get(told, "fail")}">'
                    f"<system-out>{told}</system-out></testcase>" for name, told in tests.items())
    return f"<testsuite>{cases}</testsuite>"


class ResultsTest(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def write(self, alone=None, **tests):
        (self.folder / results.ALL).write_text(report(**tests))
        if alone:
            (self.folder / results.ALONE).write_text(report(**alone))

    def test_tests_are_counted_beside_others(self):
        self.write(Pcd__Reads="passed", e2e__view="skipped")
        self.assertEqual(results.summary(5, 0, [self.folder, self.folder / "absent"]), ["6 passed, 0 failed, 1 skipped"])
        self.assertEqual(results.failed(self.folder), {})

    def test_a_failure_is_named_with_the_end_of_its_output(self):
        self.write(Pcd__Reads="passed", e2e__load="\n".join(f"line {i}" for i in range(100)))
        lines = results.summary(0, 1, [self.folder])
        self.assertEqual((lines[0], lines[1], lines[-2], lines[-1]),
                         (f"{self.folder}: e2e.load failed. Its output ends with:", "  line 70", "  line 99", "1 passed, 2 failed, 0 skipped"))
        self.assertEqual(list(results.failed(self.folder)), ["e2e.load"])

    def test_what_passed_alone_is_told(self):
        self.write(e2e__load="slow", e2e__tls="wrong", alone={"e2e__load": "passed", "e2e__tls": "wrong again"})
        self.assertEqual(list(results.failed(self.folder)), ["e2e.tls"])
        self.assertEqual(results.summary(0, 0, [self.folder]),
                         [f"{self.folder}: e2e.load failed beside other tests, and passed alone.",
                          f"{self.folder}: e2e.tls failed. Its output ends with:", "  wrong again", "1 passed, 1 failed, 0 skipped"])


if __name__ == "__main__":
    unittest.main()
