// SPDX-License-Identifier: Apache-2.0
#include "core/weights/color_geometry_weight.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace segserve {
namespace {

TEST(AdaptiveLambda, GivesBothTermsTheSameMean) {
  const std::vector<double> color{0.1, 0.2, 0.3}, geometry{0.4, 0.5, 0.9};
  const ColorGeometryWeight u = *ColorGeometryWeight::adaptive(color, geometry);
  EXPECT_DOUBLE_EQ(u.lambda(), 0.6 / (0.2 + 0.6));
  EXPECT_DOUBLE_EQ(u(0.2, 0), u(0, 0.6));  // lambda mu_C = (1 - lambda) mu_G
}

TEST(AdaptiveLambda, IsOneHalfWhereNothingDiffers) {
  EXPECT_EQ(ColorGeometryWeight::adaptive(std::vector{0.0, 0.0}, std::vector{0.0, 0.0})->lambda(), 0.5);
  EXPECT_EQ(ColorGeometryWeight::adaptive({}, {})->lambda(), 0.5);
}

TEST(AdaptiveLambda, LeavesOutATermThatIsZeroEverywhere) {
  EXPECT_EQ((*ColorGeometryWeight::adaptive(std::vector{0.0, 0.0}, std::vector{0.1, 0.3}))(0, 0.3), 0.3);
  EXPECT_EQ((*ColorGeometryWeight::adaptive(std::vector{0.1, 0.3}, std::vector{0.0, 0.0}))(0.3, 0), 0.3);
}

TEST(Equalization, IsHalfTheShareOfInitialEdgesNotAbove) {
  const ColorGeometryWeight u =
      *ColorGeometryWeight::equalization(std::vector{0.3, 0.1, 0.1, 0.2}, std::vector{0.0, 1.0, 0.5, 0.25});
  EXPECT_DOUBLE_EQ(u(0.1, 0), 0.5 * 0.5 + 0.5 * 0.25);
  EXPECT_DOUBLE_EQ(u(0.05, -1), 0);
  EXPECT_DOUBLE_EQ(u(9, 9), 1);
  EXPECT_DOUBLE_EQ(u(0.29, 0.6), 0.5 * 0.75 + 0.5 * 0.75);
}

TEST(ColorGeometryWeight, LearningStopsWhenAsked) {
  const std::vector<double> values{0.1, 0.2};
  const std::atomic<bool> cancelled = true;
  const StopToken stop(&cancelled);
  EXPECT_EQ(ColorGeometryWeight::adaptive(values, values, stop).status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(ColorGeometryWeight::equalization(values, values, stop).status().code(), absl::StatusCode::kCancelled);
}

TEST(FixedLambda, WeighsTheTerms) {
  EXPECT_DOUBLE_EQ(ColorGeometryWeight::fixed(0.25)(0.4, 0.8), 0.25 * 0.4 + 0.75 * 0.8);
}

}  // namespace
}  // namespace segserve
