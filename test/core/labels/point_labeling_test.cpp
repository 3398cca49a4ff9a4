// SPDX-License-Identifier: Apache-2.0
#include "core/labels/point_labeling.hpp"

#include <atomic>

#include "gmock/gmock.h"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

using testing::ElementsAre;

/// Seven points in voxels 0 to 3, by slots: 0 for the third point, which is not segmented. Voxel 1 was removed.
struct Input {
  Cloud cloud = test::random_cloud(7, 1, 2, View::camera());
  VoxelGrid grid;
  Supervoxels supervoxels{.supervoxel_of_voxel = {0, 1, 1}, .count = 2};
  Cut cut{.segment_of_leaf = {2, 1}, .segments = 2};

  Input() {
    grid.slot_of_point = {1, 1, 0, 2, 3, 4, 2};
    grid.voxel_of_slot = {0, 2, 0, kNoVoxel, 1};
  }
};

class PointLabelingTest : public testing::TestWithParam<std::uint32_t> {};
INSTANTIATE_TEST_SUITE_P(Threads, PointLabelingTest, testing::Values(1U, 2U, 7U));

TEST_P(PointLabelingTest, GivesEveryPointTheSupervoxelAndSegmentOfItsVoxel) {
  Input in;
  std::vector<std::uint32_t> supervoxel_of_point, segment_of_point;
  const test::TestFrame frame(in.cloud, {.threads = GetParam()});
  ASSERT_TRUE(
      PointLabeling().run(frame, in.supervoxels, {}, in.cut, in.grid, supervoxel_of_point, segment_of_point).ok());
  EXPECT_THAT(supervoxel_of_point, ElementsAre(2, 2, 0, 1, 0, 2, 1));
  EXPECT_THAT(segment_of_point, ElementsAre(1, 1, 0, 2, 0, 1, 2));
}

TEST_P(PointLabelingTest, GivesReassignedPointsWhatTheyWereGiven) {
  Input in;
  std::vector<std::uint32_t> supervoxel_of_point, segment_of_point;
  const test::TestFrame frame(in.cloud, {.threads = GetParam()});
  const std::vector<ReassignedPoint> reassigned = {{1, 0}, {6, 1}};
  ASSERT_TRUE(PointLabeling()
                  .run(frame, in.supervoxels, reassigned, in.cut, in.grid, supervoxel_of_point, segment_of_point)
                  .ok());
  EXPECT_THAT(supervoxel_of_point, ElementsAre(2, 1, 0, 1, 0, 2, 2));
  EXPECT_THAT(segment_of_point, ElementsAre(1, 2, 0, 2, 0, 1, 1));
}

TEST(PointLabelingTest, StopsWhenAsked) {
  Input in;
  std::vector<std::uint32_t> supervoxel_of_point, segment_of_point;
  const std::atomic<bool> cancelled = true;
  const test::TestFrame frame(in.cloud, {}, StopToken(&cancelled));
  const absl::Status status =
      PointLabeling().run(frame, in.supervoxels, {}, in.cut, in.grid, supervoxel_of_point, segment_of_point);
  EXPECT_EQ(status.code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
