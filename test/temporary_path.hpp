// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace segserve::test {

/// The path of a file in the temporary folder that no other test uses, of those that run at the same time, too.
inline std::string temporary_path(const std::string& ending) {
  const testing::TestInfo* const test = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + "-" + test->name() + "-" + ending;
  for (char& c : name) c = c == '/' ? '-' : c;  // of tests with parameters
  return testing::TempDir() + "segserve-" + name;
}

}  // namespace segserve::test
