// SPDX-License-Identifier: Apache-2.0
#include "command_line/closest_name.hpp"

#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace segserve {
namespace {

TEST(EditDistance, CountsInsertionsRemovalsReplacementsAndSwaps) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("abc", ""), 3U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("treshold", "threshold"), 1U);
  EXPECT_EQ(edit_distance("thershold", "threshold"), 1U);
  EXPECT_EQ(edit_distance("ca", "abc"), 3U);  // no letter is changed twice
}

TEST(ClosestName, IsWhatWasMeant) {
  const std::vector<std::string> names{"--threshold", "--output", "--out-dir", "--drop-unlabeled", "--rgb", "segment"};
  EXPECT_EQ(closest_name("--treshold", names), "--threshold");
  EXPECT_EQ(closest_name("-threshold", names), "--threshold");
  EXPECT_EQ(closest_name("--drop-unlabelled", names), "--drop-unlabeled");
  EXPECT_EQ(closest_name("segmnt", names), "segment");
  EXPECT_EQ(closest_name("--outdir", names), "--out-dir");
  EXPECT_EQ(closest_name("--drop", names), "--drop-unlabeled") << "its beginning";
}

TEST(ClosestName, IsNothingIfNoNameIsClose) {
  const std::vector<std::string> names{"--threshold", "--rgb"};
  EXPECT_EQ(closest_name("--clients", names), std::nullopt);
  EXPECT_EQ(closest_name("--th", names), std::nullopt) << "too short a beginning";
  EXPECT_EQ(closest_name("--", names), std::nullopt);
  EXPECT_EQ(closest_name(std::string(1'000'000, 'x'), names), std::nullopt);
  EXPECT_EQ(closest_name("--rgb", {}), std::nullopt);
}

}  // namespace
}  // namespace segserve
