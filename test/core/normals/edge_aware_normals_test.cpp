// SPDX-License-Identifier: Apache-2.0
#include "core/normals/edge_aware_normals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "core/math/elementary.hpp"
#include "core/math/symmetric_matrix3.hpp"
#include "core/voxels/voxelization.hpp"
#include "test/core/support/clouds.hpp"
#include "test/core/support/test_frame.hpp"

namespace segserve {
namespace {

struct Normals {
  VoxelGrid grid;
  std::vector<Vec3> fitted, refined;  // by fit_neighborhood_normals and by refine_normals
};

Normals normals_of(const Cloud& cloud, std::uint32_t threads = 1) {
  const test::TestFrame frame(cloud, {.voxel_resolution = 0.01, .threads = threads});
  Normals n;
  VoxelAdjacency adjacency;
  EXPECT_TRUE(Voxelization().run(frame, n.grid).ok());
  EXPECT_TRUE(find_adjacency(frame, n.grid, adjacency).ok());
  Neighborhoods neighborhoods;
  EXPECT_TRUE(find_neighborhoods(frame, n.grid, neighborhoods).ok());
  EXPECT_TRUE(fit_neighborhood_normals(frame, n.grid, adjacency, neighborhoods, n.fitted).ok());
  n.refined = n.fitted;
  EXPECT_TRUE(refine_normals(frame, {}, neighborhoods, n.refined).ok());
  return n;
}

/// Top (z = 0.3) and right side (x = 0.3) of a box, seen from outside. The noise is in meters.
Cloud box_edge(double noise) {
  Cloud cloud = test::unorganized(View::world(3, 0.15F, 3));
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

/// Mean angle in degrees between the normals of the second row of voxels from the edge and those of their faces.
double error_at_edge(const Normals& n, const std::vector<Vec3>& normals) {
  double sum = 0, count = 0;
  for (std::size_t v = 0; v < n.grid.size(); ++v) {
    const Vec3& c = n.grid.centroid[v];
    const double from_top = std::fabs(0.3 - c.z), from_side = std::fabs(0.3 - c.x);
    if (std::max(from_top, from_side) > 0.02 || std::max(from_top, from_side) < 0.01) continue;
    const Vec3 face = from_top < from_side ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    sum += math::atan2(norm(cross(face, normals[v])), dot(face, normals[v])) / math::kDegree;
    ++count;
  }
  return sum / count;
}

TEST(EdgeAwareNormals, AreNotAveragedAcrossAnEdge) {
  for (const double noise : {0.0, 0.001}) {
    const Normals n = normals_of(box_edge(noise));
    const double fitted = error_at_edge(n, n.fitted), refined = error_at_edge(n, n.refined);
    EXPECT_GT(fitted, 3) << "noise " << noise;
    EXPECT_LT(refined, fitted / 3) << "noise " << noise;
  }
}

TEST(EdgeAwareNormals, FaceTheSensorAtFirst) {
  const Cloud cloud = test::random_cloud(3000, 0.3F, 1, View::camera());
  const Normals n = normals_of(cloud);
  for (std::size_t v = 0; v < n.grid.size(); ++v) EXPECT_LE(dot(n.fitted[v], n.grid.centroid[v]), 0);
}

TEST(EdgeAwareNormals, AgreeOnASideWithoutASensor) {
  Cloud plane = test::unorganized(View::world());
  for (float x = 0.0013F; x < 0.2F; x += 0.004F) {
    for (float y = 0.0013F; y < 0.2F; y += 0.004F) test::add(plane, x, y, 0.3F * x, 0);
  }
  const Normals n = normals_of(plane);
  ASSERT_GT(n.grid.size(), 300U);
  for (const auto& normals : {n.fitted, n.refined}) {
    for (const Vec3& normal : normals) EXPECT_GT(normal.z, 0.9);
  }
}

TEST(EdgeAwareNormals, StayOnTheirSideAndOfUnitLength) {
  const Normals n = normals_of(test::random_cloud(3000, 0.3F, 1, View::camera()));
  for (std::size_t v = 0; v < n.grid.size(); ++v) {
    EXPECT_GE(dot(n.fitted[v], n.refined[v]), 0);
    EXPECT_NEAR(norm(n.refined[v]), norm(n.fitted[v]), 1e-12);
  }
}

TEST(EdgeAwareNormals, LeaveWhatHasNoNormalOrNoSupport) {
  Cloud cloud = test::unorganized();
  test::add(cloud, 5, 5, 5, 0);
  for (int i = 0; i < 3; ++i) test::add(cloud, 0.01F * static_cast<float>(i), 0.012F * static_cast<float>(i % 2), 0, 0);
  const Normals n = normals_of(cloud);
  for (std::size_t v = 0; v < n.grid.size(); ++v)
    EXPECT_NEAR(std::fabs(dot(n.fitted[v], n.refined[v])), norm(n.fitted[v]), 1e-9);
}

/// The angle between two lines, degrees.
double between(const Vec3& a, const Vec3& b) {
  return math::atan2(norm(cross(a, b)), std::fabs(dot(a, b))) / math::kDegree;
}

int axis(VoxelKey key, int axis) { return static_cast<int>(key >> (axis * kCellBits) & ((1U << kCellBits) - 1)); }

bool within_two_cells(VoxelKey a, VoxelKey b) {
  for (int i = 0; i < 3; ++i) {
    if (std::abs(axis(a, i) - axis(b, i)) > 2) return false;
  }
  return true;
}

struct Fit {
  double weights = 0;
  Vec3 normal;
};

/// The plane through the neighborhood of v, in double precision, over all pairs of voxels. weight(u, d) is the weight
/// of voxel u at d from v.
template <typename Weight>
Fit fit(const VoxelGrid& grid, std::size_t v, Weight&& weight) {
  Fit result;
  Vec3 sum;
  Symmetric3 scatter;
  for (std::size_t u = 0; u < grid.size(); ++u) {
    if (!within_two_cells(grid.key[u], grid.key[v])) continue;
    const Vec3 d = grid.centroid[u] - grid.centroid[v];
    const double w = weight(u, d);
    result.weights += w;
    sum += w * d;
    scatter += w * outer(d);
  }
  scatter += (-1 / result.weights) * outer(sum);
  result.normal = smallest_eigenvector(scatter);
  return result;
}

double edge_of(const VoxelGrid& grid, const View& view, std::size_t v) {
  return view.kind == ViewKind::kCamera ? 0.01 * grid.centroid[v].z : 0.01;
}

Vec3 fitted_by_definition(const Normals& n, const View& view, std::size_t v) {
  const double range = 3.2 * edge_of(n.grid, view, v);
  return fit(n.grid, v,
             [&](std::size_t, const Vec3& d) {
               const double rest = std::max(0.0, 1 - dot(d, d) / (range * range));
               return rest * rest;
             })
      .normal;
}

Vec3 refined_by_definition(const Normals& n, const View& view, std::size_t v) {
  const double sigma = 0.25 * edge_of(n.grid, view, v), radians = 20 * math::kDegree;
  const Fit refined = fit(n.grid, v, [&](std::size_t u, const Vec3& d) {
    const double own = dot(n.fitted[v], d), other = dot(n.fitted[u], d);
    return std::exp(-2 * (1 - dot(n.fitted[v], n.fitted[u])) / (radians * radians) -
                    std::min(own * own, other * other) / (2 * sigma * sigma));
  });
  return refined.weights <= 2.5 || refined.normal == Vec3{} ? n.fitted[v] : refined.normal;
}

TEST(EdgeAwareNormals, EqualTheDefinition) {
  const Cloud clouds[] = {box_edge(0.001), test::random_cloud(3000, 0.3F, 1, View::camera()),
                          test::random_cloud(1000, 0.12F, 0, View::world(1, 2, 3))};
  for (const Cloud& cloud : clouds) {
    const Normals n = normals_of(cloud);
    std::size_t fitted = 0, refined = 0, changed = 0;
    for (std::size_t v = 0; v < n.grid.size(); ++v) {
      fitted += between(fitted_by_definition(n, cloud.view, v), n.fitted[v]) < 0.01;
      refined += between(refined_by_definition(n, cloud.view, v), n.refined[v]) < 0.01;
      changed += between(n.fitted[v], n.refined[v]) > 1;
    }
    // Where the smallest two eigenvalues are nearly equal, single precision may turn the plane.
    EXPECT_GE(fitted, n.grid.size() * 998 / 1000) << n.grid.size() << " voxels";
    EXPECT_GE(refined, n.grid.size() * 998 / 1000) << n.grid.size() << " voxels";
    EXPECT_GT(changed, n.grid.size() / 20);
  }
}

TEST(EdgeAwareNormals, AreAsGoodFarFromTheOrigin) {
  Cloud far = box_edge(0.0);
  for (float& x : far.x) x += 1024;  // Single precision has steps of 0.1 mm there.
  for (float& y : far.y) y -= 512;
  far.view = View::world(1027, -511.85F, 3);
  Normals n = normals_of(far);
  for (Vec3& c : n.grid.centroid) c = c - Vec3{1024, -512, 0};
  EXPECT_LT(error_at_edge(n, n.refined), error_at_edge(n, n.fitted) / 3);
  EXPECT_LT(error_at_edge(n, n.refined), 1);
}

TEST(EdgeAwareNormals, DoNotDependOnThreads) {
  const Cloud cloud = test::random_cloud(3000, 0.3F, 1, View::camera());
  const Normals one = normals_of(cloud, 1), many = normals_of(cloud, 5);
  EXPECT_EQ(one.fitted, many.fitted);
  EXPECT_EQ(one.refined, many.refined);
}

}  // namespace
}  // namespace segserve
