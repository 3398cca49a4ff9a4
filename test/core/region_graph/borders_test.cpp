// SPDX-License-Identifier: Apache-2.0
#include "core/region_graph/borders.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/math/elementary.hpp"
#include "test/core/support/supervoxel_stages.hpp"

namespace segserve {
namespace {

constexpr double kDeadZone = 4;

struct ExpectedBorder {
  double contacts = 0, angles = 0;
};
using ExpectedBorders = std::map<std::pair<std::uint32_t, std::uint32_t>, ExpectedBorder>;

ExpectedBorders borders_of_all_pairs(const test::SupervoxelStages& s) {
  ExpectedBorders expected;
  const std::vector<std::uint32_t>& supervoxel = s.supervoxels.supervoxel_of_voxel;
  for (std::uint32_t v = 0; v < s.grid.size(); ++v) {
    for (const std::uint32_t u : s.adjacency.of(v)) {
      if (u < v || supervoxel[u] == supervoxel[v]) continue;
      ExpectedBorder& border = expected[std::minmax(supervoxel[u], supervoxel[v])];
      border.contacts += 1;
      const Vec3 &nv = s.normals[v], &nu = s.normals[u];
      const bool concave = dot(nv - nu, s.grid.centroid[v] - s.grid.centroid[u]) < 0;
      const bool defined = norm(nv) > 0 && norm(nu) > 0;
      const double angle = std::acos(std::clamp(dot(nv, nu), -1.0, 1.0)) / math::kDegree;
      if (concave && defined) border.angles += std::max(0.0, angle - kDeadZone);
    }
  }
  return expected;
}

Options coarse_options() {
  Options options = test::paper_options();
  options.voxel_resolution = 0.01;
  return options;
}

TEST(MeasureBorders, EqualsAllPairsOfVoxels) {
  const Cloud cloud = test::random_cloud(6000, 0.3F, 1, View::camera());
  const test::TestFrame frame(cloud, coarse_options());
  const test::SupervoxelStages s = test::run_supervoxel_stages(frame);
  const RegionGraph graph = test::build_region_graph(frame, s);
  const ExpectedBorders expected = borders_of_all_pairs(s);
  std::vector<Border> borders;
  ASSERT_TRUE(measure_borders(frame, graph, s.grid, s.normals, {kDeadZone}, borders).ok());
  ASSERT_EQ(borders.size(), expected.size());
  for (std::size_t e = 0; e < borders.size(); ++e) {
    const ExpectedBorder& border = expected.at({graph.edges[e].a, graph.edges[e].b});
    EXPECT_EQ(borders[e].contacts, border.contacts);
    EXPECT_NEAR(borders[e].concavity, border.angles / border.contacts, 1e-5);
  }
}

TEST(MeasureBorders, StopsWhenAsked) {
  const Cloud cloud = test::two_colored_patches();
  const test::TestFrame frame(cloud, coarse_options());
  const test::SupervoxelStages s = test::run_supervoxel_stages(frame);
  const RegionGraph graph = test::build_region_graph(frame, s);
  const std::atomic<bool> cancelled = true;
  const test::TestFrame stopped(cloud, coarse_options(), StopToken(&cancelled));
  std::vector<Border> borders;
  EXPECT_EQ(measure_borders(stopped, graph, s.grid, s.normals, {kDeadZone}, borders).code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace segserve
