#include "core/normals/edge_aware_normals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "core/math/elementary.hpp"
#include "core/math/symmetric_matrix3.hpp"
#include "test/core/support/clouds.hpp"

namespace segserve {
namespace {

struct Normals {
  VoxelGrid grid;
  std::vector<Vec3> plain, refined;  // by window_normals and by refine_normals
};

Normals normals_of(const Cloud& cloud, unsigned threads = 1) {
  Normals n;
  VoxelizeScratch scratch;
  VoxelAdjacency adjacency;
  EXPECT_TRUE(voxelize(cloud, 0.01, 1, StopToken(), scratch, n.grid).ok());
  find_adjacency(n.grid, adjacency);
  VoxelWindows windows;
  EXPECT_TRUE(find_windows(n.grid, cloud.view, 0.01, threads, StopToken(), windows).ok());
  EXPECT_TRUE(window_normals(n.grid, adjacency, cloud.view, StopToken(), windows, n.plain).ok());
  n.refined = n.plain;
  EXPECT_TRUE(refine_normals({}, StopToken(), windows, n.refined).ok());
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

TEST(EdgeAwareNormals, FaceTheSensorAtFirst) {
  const Cloud cloud = test::random_cloud(3000, 0.3F, 1, View::camera());
  const Normals n = normals_of(cloud);
  for (std::size_t v = 0; v < n.grid.size(); ++v) EXPECT_LE(dot(n.plain[v], n.grid.centroid[v]), 0);
}

TEST(EdgeAwareNormals, AgreeOnASideWithoutASensor) {
  Cloud plane = test::unorganised(View::world());
  for (float x = 0.0013F; x < 0.2F; x += 0.004F) {
    for (float y = 0.0013F; y < 0.2F; y += 0.004F) test::add(plane, x, y, 0.3F * x, 0);
  }
  const Normals n = normals_of(plane);
  ASSERT_GT(n.grid.size(), 300U);
  for (const auto& normals : {n.plain, n.refined}) {
    for (const Vec3& normal : normals) EXPECT_GT(normal.z, 0.9);
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

/// Degrees between two lines.
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

/// The plane through the window of v, in double precision, over all pairs. weight(u, d): d is the way from v to u.
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

Vec3 first_by_definition(const Normals& n, const View& view, std::size_t v) {
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
    const double own = dot(n.plain[v], d), other = dot(n.plain[u], d);
    return std::exp(-2 * (1 - dot(n.plain[v], n.plain[u])) / (radians * radians) -
                    std::min(own * own, other * other) / (2 * sigma * sigma));
  });
  return refined.weights <= 2.5 || refined.normal == Vec3{} ? n.plain[v] : refined.normal;
}

TEST(EdgeAwareNormals, EqualTheDefinition) {
  const Cloud clouds[] = {box_edge(0.001), test::random_cloud(3000, 0.3F, 1, View::camera()),
                          test::random_cloud(1000, 0.12F, 0, View::world(1, 2, 3))};
  for (const Cloud& cloud : clouds) {
    const Normals n = normals_of(cloud);
    std::size_t first = 0, close = 0, changed = 0;
    for (std::size_t v = 0; v < n.grid.size(); ++v) {
      first += between(first_by_definition(n, cloud.view, v), n.plain[v]) < 0.01;
      close += between(refined_by_definition(n, cloud.view, v), n.refined[v]) < 0.01;
      changed += between(n.plain[v], n.refined[v]) > 1;
    }
    // Where the smallest two eigenvalues are nearly equal, single precision may turn the plane.
    EXPECT_GE(first, n.grid.size() * 998 / 1000) << n.grid.size() << " voxels";
    EXPECT_GE(close, n.grid.size() * 998 / 1000) << n.grid.size() << " voxels";
    EXPECT_GT(changed, n.grid.size() / 20);
  }
}

TEST(EdgeAwareNormals, AreAsGoodFarFromTheOrigin) {
  Cloud far = box_edge(0.0);
  for (float& x : far.x) x += 1024;  // where single precision has steps of 0.1 mm
  for (float& y : far.y) y -= 512;
  far.view = View::world(1027, -511.85F, 3);
  Normals n = normals_of(far);
  for (Vec3& c : n.grid.centroid) c = c - Vec3{1024, -512, 0};
  EXPECT_LT(error_at_edge(n, n.refined), error_at_edge(n, n.plain) / 3);
  EXPECT_LT(error_at_edge(n, n.refined), 1);
}

TEST(EdgeAwareNormals, DoNotDependOnThreads) {
  const Cloud cloud = test::random_cloud(3000, 0.3F, 1, View::camera());
  const Normals one = normals_of(cloud, 1), many = normals_of(cloud, 5);
  EXPECT_EQ(one.plain, many.plain);
  EXPECT_EQ(one.refined, many.refined);
}

}  // namespace
}  // namespace segserve
