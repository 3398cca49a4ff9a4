# SPDX-License-Identifier: Apache-2.0
"""tidy.py and thread_safety.py look at the right sources, and clang finds what it should."""

import tempfile
import unittest

import include_graph
import thread_safety
import tidy

TEXTS = {
    "server/a.hpp": "Mutex mutex_; int count_ ABSL_GUARDED_BY(mutex_);",
    "server/b.hpp": '#include "server/a.hpp"',
    "server/a.cpp": '#include "server/a.hpp"',
    "server/c.cpp": '#include "server/b.hpp"',
    "server/d.cpp": "",
}
SOURCES = ["server/a.cpp", "server/c.cpp", "server/d.cpp"]
TOUCHES_WITHOUT_LOCK = """
#include "absl/base/thread_annotations.h"
struct ABSL_LOCKABLE Mutex {};
struct Counter {
  Mutex mutex;
  int count ABSL_GUARDED_BY(mutex);
  void add() %s { ++count; }
};
"""


class TidySelectionTest(unittest.TestCase):
    def check(self, changed, expected):
        self.assertEqual(tidy.select_changed(SOURCES, include_graph.graph_of(TEXTS), changed), expected)

    def test_changed_sources_are_selected(self):
        self.check({"server/a.cpp", "server/d.cpp", "README.md"}, {"server/a.cpp", "server/d.cpp"})

    def test_a_changed_header_selects_its_own_source(self):
        self.check({"server/a.hpp"}, {"server/a.cpp"})

    def test_a_changed_header_without_source_selects_one_that_includes_it(self):
        self.check({"server/b.hpp"}, {"server/c.cpp"})

    def test_a_changed_header_selects_nothing_if_a_changed_source_includes_it(self):
        self.check({"server/a.hpp", "server/c.cpp"}, {"server/c.cpp"})


class ThreadSafetyTest(unittest.TestCase):
    def complaints(self, annotation):
        with tempfile.NamedTemporaryFile("w", suffix=".cpp") as file:
            file.write(TOUCHES_WITHOUT_LOCK % annotation)
            file.flush()
            return thread_safety.check({"command": f"g++ -o none.o -c {file.name}", "directory": "."})

    def test_sources_with_marks_or_marked_headers_are_selected(self):
        self.assertEqual(thread_safety.marked_sources(TEXTS, SOURCES), ["server/a.cpp"])

    def test_touching_without_the_lock_is_a_fault(self):
        self.assertIn("requires holding mutex 'mutex'", self.complaints(""))

    def test_touching_under_the_lock_is_none(self):
        self.assertEqual("", self.complaints("ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex)"))


if __name__ == "__main__":
    unittest.main()
