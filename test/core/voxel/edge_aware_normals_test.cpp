#include "segserve/voxel/edge_aware_normals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "segserve/math/elementary.hpp"
#include "segserve/voxel/normals.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

struct Normals {
  VoxelGrid grid;
  std::vector<Vec3> plain, refined;
};

Normals normals_of(const Cloud& cloud, unsigned threads = 1) {
  Normals n;
  VoxelizeScratch scratch;
  VoxelAdjacency adjacency;
  EXPECT_TRUE(voxelize(cloud, 0.01, 1, StopToken(), scratch, n.grid).ok());
  find_adjacency(n.grid, adjacency);
  EXPECT_TRUE(compute_normals(n.grid, adjacency, cloud.view, 1, StopToken(), n.plain).ok());
  n.refined = n.plain;
  EXPECT_TRUE(refine_normals(n.grid, adjacency, cloud.view, 0.01, {}, threads, StopToken(), n.refined).ok());
  return n;
}

/// Top (z = 0.3) and right side (x = 0.3) of a box, seen from outside; `noise` in metres.
Cloud box_edge(double noise) {
  Cloud cloud = test::unorganised(View::world(3, 0.15F, 3));
  std::mt19937 random(1);
  const auto jitter = [&] { return static_cast<float>(noise * (static_cast<double>(random() % 2001) / 1000 - 1)); };
  for (float u = 0.0013F; u < 0.3F; u += 0.004F) {
    for (float y = 0.0013F; y < 0.3F; y += 0.004F) {
      test::add(cloud, u, y, 0.3F + jitter(), 0);
      test::add(cloud, 0.3F + jitter(), y, u, 0);
    }
  }
  return cloud;
}

/// Mean angle in degrees between normals and those of the face they lie on, in the second row of voxels from the edge.
double error_at_edge(const Normals& n, const std::vector<Vec3>& normals) {
  double sum = 0, count = 0;
  for (std::size_t v = 0; v < n.grid.size(); ++v) {
    const Vec3& c = n.grid.centroid[v];
    const double from_top = std::fabs(0.3 - c.z), from_side = std::fabs(0.3 - c.x);
    if (std::max(from_top, from_side) > 0.02 || std::max(from_top, from_side) < 0.01)
      continue;  // 2nd voxel from the fold
    const Vec3 face = from_top < from_side ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    sum += math::atan2(norm(cross(face, normals[v])), dot(face, normals[v])) / math::kDegree;
    ++count;
  }
  return sum / count;
}

TEST(EdgeAwareNormals, AreNotAveragedAcrossAnEdge) {
  for (const double noise : {0.0, 0.001}) {
    const Normals n = normals_of(box_edge(noise));
    const double plain = error_at_edge(n, n.plain), refined = error_at_edge(n, n.refined);
    EXPECT_GT(plain, 3) << "noise " << noise;
    EXPECT_LT(refined, plain / 3) << "noise " << noise;
  }
}

TEST(EdgeAwareNormals, StayOnTheirSideAndOfUnitLength) {
  const Normals n = normals_of(test::random_cloud(3000, 0.3F, 1, View::camera()));
  for (std::size_t v = 0; v < n.grid.size(); ++v) {
    EXPECT_GE(dot(n.plain[v], n.refined[v]), 0);
    EXPECT_NEAR(norm(n.refined[v]), norm(n.plain[v]), 1e-12);
  }
}

TEST(EdgeAwareNormals, LeaveWhatHasNoNormalOrNoSupport) {
  Cloud cloud = test::unorganised();
  test::add(cloud, 5, 5, 5, 0);
  for (int i = 0; i < 3; ++i) test::add(cloud, 0.01F * static_cast<float>(i), 0.012F * static_cast<float>(i % 2), 0, 0);
  const Normals n = normals_of(cloud);
  for (std::size_t v = 0; v < n.grid.size(); ++v)
    EXPECT_NEAR(std::fabs(dot(n.plain[v], n.refined[v])), norm(n.plain[v]), 1e-9);
}

TEST(EdgeAwareNormals, DoNotDependOnThreads) {
  const Cloud cloud = test::random_cloud(3000, 0.3F, 1, View::camera());
  EXPECT_EQ(normals_of(cloud, 1).refined, normals_of(cloud, 5).refined);
}

}  // namespace
}  // namespace segserve
