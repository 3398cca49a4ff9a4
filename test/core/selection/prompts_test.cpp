// SPDX-License-Identifier: Apache-2.0
#include "segserve/prompts.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint32_t kWidth = 48, kHeight = 32;

/// An organized cloud of steps of different heights, in which every fifth pixel was not measured.
Cloud steps() {
  Cloud cloud = test::unorganized(View::world(0, 0, 5));
  for (std::uint32_t row = 0; row < kHeight; ++row) {
    for (std::uint32_t column = 0; column < kWidth; ++column) {
      const bool is_missing = (row * kWidth + column) % 5 == 0;
      const float z = is_missing ? std::numeric_limits<float>::quiet_NaN() : 0.3F * static_cast<float>(column / 12);
      test::add(cloud, 0.02F * static_cast<float>(column), 0.02F * static_cast<float>(row), z, 0x808080);
    }
  }
  cloud.width = kWidth;
  cloud.height = kHeight;
  return cloud;
}

class PromptsTest : public testing::Test {
 protected:
  const Cloud cloud_ = steps();
  const Segmentation segmentation_ =
      segment(cloud_, {.method = Method::kLambdaConvex, .voxel_resolution = 0.02, .seed_resolution = 0.08}).value();

  absl::StatusOr<PromptedSelection> ask(const Prompts& prompts, std::optional<std::uint32_t> regions = {}) const {
    return select_by_prompts(cloud_, segmentation_, regions, prompts);
  }
};

TEST_F(PromptsTest, SelectWhatBruteForceFinds) {
  std::mt19937 random(7);
  const auto coordinate = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() % 1000) / 1000;
  };
  ASSERT_GT(segmentation_.tree.leaf_count(), 20U);
  int selected = 0;
  for (int k = 0; k < 200; ++k) {
    Prompts prompts{.include = {}, .exclude = {}, .larger = static_cast<int>(random() % 5) - 2};
    std::vector<std::uint32_t> positives, negatives;
    for (std::size_t i = 0; i < 1 + random() % 4; ++i) {
      const Eigen::Vector3d position(coordinate(-0.1, 1), coordinate(-0.1, 0.7), coordinate(-0.1, 1));
      std::size_t nearest = 0;
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t point = 0; point < cloud_.size(); ++point) {
        if (segmentation_.supervoxels[point] == 0) continue;
        const double distance =
            (Eigen::Vector3d(cloud_.x[point], cloud_.y[point], cloud_.z[point]) - position).squaredNorm();
        if (distance < least) least = distance, nearest = point;
      }
      const bool is_negative = i > 1;
      (is_negative ? prompts.exclude : prompts.include).emplace_back(position);
      (is_negative ? negatives : positives).push_back(segmentation_.supervoxels[nearest] - 1);
    }
    const auto expected = select(segmentation_.tree, positives, negatives);
    const auto actual = ask(prompts);
    ASSERT_EQ(actual.ok(), expected.ok()) << actual.status();
    if (!actual.ok()) continue;
    ++selected;
    EXPECT_EQ(actual->selection, *expected);
    const auto usual =
        static_cast<int>(candidate_at_threshold(segmentation_.tree, *expected, *segmentation_.threshold));
    const int last = static_cast<int>(expected->candidates()) - 1;
    EXPECT_EQ(actual->candidate, std::clamp(usual + prompts.larger, 0, last));
    const auto below = leaves_below(segmentation_.tree, nodes_of(*expected, actual->candidate));
    for (std::size_t point = 0; point < cloud_.size(); ++point) {
      const std::uint32_t supervoxel = segmentation_.supervoxels[point];
      ASSERT_EQ(actual->labels[point], supervoxel > 0 && below[supervoxel - 1] ? 1U : 0U);
    }
  }
  EXPECT_GT(selected, 100);
}

TEST_F(PromptsTest, PixelsStandForTheirPoints) {
  const auto selected = ask({.include = {Pixel{7, 3}}, .exclude = {Pixel{30, 3}}});
  ASSERT_TRUE(selected.ok()) << selected.status();
  const std::size_t point = 3 * kWidth + 7;
  EXPECT_THAT(selected->include, ElementsAre(PromptedPoint{point, segmentation_.supervoxels[point], 0}));
  EXPECT_EQ(selected->labels[point], 1U);
  EXPECT_EQ(selected->labels[3 * kWidth + 30], 0U);
}

TEST_F(PromptsTest, HaveStatisticsIfTheyAreDescribed) {
  auto selected = *ask({.include = {Pixel{7, 3}}}, 1);
  ASSERT_TRUE(describe(cloud_, 1, {}, selected).ok());
  EXPECT_EQ(selected.statistics->points, std::ranges::count(selected.labels, 1U));
  EXPECT_EQ(selected.statistics->thresholds, selected.thresholds);
}

TEST_F(PromptsTest, NameEveryPlaceThatStandsForNoPoint) {
  const auto status =
      ask({.include = {Pixel{7, 3}, Pixel{0, 0}, Pixel{kWidth, 1}}, .exclude = {Eigen::Vector3d(1e200, 0, 0)}})
          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), AllOf(HasSubstr("pixel 0,0 has no segmented point"),
                                                   HasSubstr("pixel 48,1 is outside the image of 48 x 32 pixels"),
                                                   HasSubstr("position 1e+200,0,0 is too far away")));
  EXPECT_THAT(std::string(ask({.include = {Pixel{7, 3}}, .exclude = {Pixel{7, 3}}}).status().message()),
              HasSubstr("both included and excluded"));

  const Cloud row = test::random_cloud(500, 1, 0, View::world());
  const Segmentation of_row = segment(row, {}).value();
  EXPECT_THAT(std::string(select_by_prompts(row, of_row, {}, {.include = {Pixel{1, 0}}}).status().message()),
              HasSubstr("pixel 1,0: the cloud is no image"));
}

TEST(PromptViolations, AreToldAllAtOnce) {
  EXPECT_TRUE(violations(Prompts{.include = {Pixel{0, 0}}}).empty());
  const std::vector<Prompt> many(kMostPrompts + 1, Pixel{0, 0});
  const auto faults =
      violations(Prompts{.include = {}, .exclude = {Pixel{0, 0}, Eigen::Vector3d(0, NAN, 0)}, .larger = 0});
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_EQ(faults[0].field, "include");
  EXPECT_EQ(faults[1].field, "exclude[1]");
  EXPECT_THAT(violations(Prompts{.include = many}).front().description, HasSubstr("has 65 places"));
}

TEST_F(PromptsTest, StopWhenTheyAreTold) {
  const std::atomic<bool> stopped{true};
  EXPECT_TRUE(absl::IsCancelled(select_by_prompts(cloud_, segmentation_, {}, {.include = {Eigen::Vector3d(0, 0, 0)}},
                                                  StopToken(&stopped, std::nullopt))
                                    .status()));
}

}  // namespace
}  // namespace segserve
