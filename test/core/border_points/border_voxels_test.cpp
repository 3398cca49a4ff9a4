// SPDX-License-Identifier: Apache-2.0
#include "core/border_points/border_voxels.hpp"

#include <atomic>

#include "gmock/gmock.h"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Five voxels in a row, of the supervoxels 0, 0, 1, 2 and 2, and a contact of voxels 1 and 3, too. Only the edges from
/// supervoxel 1 to 0 and from 2 to 0 are borders of objects.
struct Row {
  Cloud cloud = test::random_cloud(5, 1, 2, View::camera());
  Supervoxels supervoxels{.supervoxel_of_voxel = {0, 0, 1, 2, 2}, .count = 3};
  RegionGraph graph;
  std::vector<BorderEvidence> evidence;

  Row() {
    graph.edges = {{0, 1}, {0, 2}, {1, 2}};
    graph.contacts = {{1, 2}, {1, 3}, {2, 3}};
    graph.edge_of_contact = {0, 1, 2};
    const double bias = BorderConstants{}.bias;
    evidence = {{1, bias}, {2, 2 * bias + 1}, {3, 3 * bias - 1e-6}};
  }
};

TEST(BorderVoxels, KnowTheSupervoxelsAcrossTheBorder) {
  const Row row;
  BorderVoxels border;
  ASSERT_TRUE(find_border_voxels(test::TestFrame(row.cloud), row.supervoxels, row.graph, row.evidence, border).ok());
  ASSERT_EQ(border.size(), 5U);
  EXPECT_THAT(border.opposite_of(0), IsEmpty());
  EXPECT_THAT(border.opposite_of(1), ElementsAre(1, 2));
  EXPECT_THAT(border.opposite_of(2), ElementsAre(0));
  EXPECT_THAT(border.opposite_of(3), ElementsAre(0));
  EXPECT_THAT(border.opposite_of(4), IsEmpty());
}

TEST(BorderVoxels, NameASupervoxelOnceHoweverManyContactsThereAre) {
  Row row;
  row.graph.contacts = {{0, 2}, {1, 2}};
  row.graph.edge_of_contact = {0, 0};
  BorderVoxels border;
  ASSERT_TRUE(find_border_voxels(test::TestFrame(row.cloud), row.supervoxels, row.graph, row.evidence, border).ok());
  EXPECT_THAT(border.opposite_of(2), ElementsAre(0));
}

TEST(BorderVoxels, StopWhenAsked) {
  const Row row;
  const std::atomic<bool> cancelled = true;
  BorderVoxels border;
  const test::TestFrame frame(row.cloud, {}, StopToken(&cancelled));
  EXPECT_EQ(find_border_voxels(frame, row.supervoxels, row.graph, row.evidence, border).code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
