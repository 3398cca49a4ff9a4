// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "core/normals/two_ring_normals.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/supervoxels/seed_selection.hpp"
#include "core/supervoxels/supervoxel_growth.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "core/voxels/voxel_positions.hpp"
#include "core/voxels/voxelization.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve::test {

/// The paper's settings of supervoxels.
inline Options paper_options() {
  return {.method = Method::kLambdaConvex,
          .voxel_resolution = 0.008,
          .seed_resolution = 0.08,
          .color_weight = 0.2,
          .spatial_weight = 0.4,
          .normal_weight = 1};
}

/// The results of the stages from voxels to supervoxels.
struct SupervoxelStages {
  VoxelGrid grid;
  VoxelAdjacency adjacency;
  std::vector<Vec3> normals;
  std::vector<Vec3> positions;  ///< empty unless the scale is in proportion
  Seeds seeds;
  Supervoxels supervoxels;
};

inline SupervoxelStages run_supervoxel_stages(const FrameContext& frame) {
  SupervoxelStages s;
  EXPECT_TRUE(Voxelization().run(frame, s.grid).ok());
  EXPECT_TRUE(find_adjacency(frame, s.grid, s.adjacency).ok());
  EXPECT_TRUE(TwoRingNormals().run(frame, s.grid, s.adjacency, s.normals).ok());
  EXPECT_TRUE(find_positions(frame, s.grid, s.positions).ok());
  const std::vector<Vec3>& positions = s.positions.empty() ? s.grid.centroid : s.positions;
  EXPECT_TRUE(SeedSelection().run(frame, positions, s.seeds).ok());
  EXPECT_TRUE(SupervoxelGrowth().run(frame, s.grid, positions, s.adjacency, s.normals, s.seeds, s.supervoxels).ok());
  return s;
}

/// The graph outlives the builder that made it.
inline RegionGraph build_region_graph(const FrameContext& frame, const SupervoxelStages& s) {
  RegionGraph graph;
  EXPECT_TRUE(RegionGraphConstruction().run(frame, s.grid, s.adjacency, s.normals, s.supervoxels, graph).ok());
  return graph;
}

/// A red and a blue square patch side by side.
inline Cloud two_colored_patches() {
  Cloud cloud = unorganized();
  add_patch(cloud, 0, 0, 0.004F, 0.4F, 0.004F, 0xff0000);
  add_patch(cloud, 0.4F, 0, 0.004F, 0.4F, 0.004F, 0x0000ff);
  return cloud;
}

}  // namespace segserve::test
