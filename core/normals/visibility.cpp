// SPDX-License-Identifier: Apache-2.0
#include "core/normals/visibility.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/base/stop_check.hpp"
#include "core/normals/normal_orientation.hpp"

namespace segserve {
namespace {

/// The least distance in every direction, on the faces of a cube around the sensor.
class DirectionCube {
 public:
  /// Enters a ball of `radius` at `offset` from the sensor. Returns the number of cells that it covers.
  std::uint64_t cover(const Vec3& offset, float distance, double radius) {
    const Cell s = cell_of(offset);
    // Few voxels are so near that they would cover more. The rest of their cells is left out.
    constexpr int kMost = 32;
    const double cells = 0.5 * kEdge * radius / s.depth;
    const int r = static_cast<int>(std::min<double>(cells, kMost));
    for (int v = std::max(s.v - r, 0); v <= std::min(s.v + r, kEdge - 1); ++v) {
      for (int u = std::max(s.u - r, 0); u <= std::min(s.u + r, kEdge - 1); ++u) {
        float& nearest = nearest_[position(s.face, u, v)];
        nearest = std::min(nearest, distance);
      }
    }
    return static_cast<std::uint64_t>(2 * r + 1) * static_cast<std::uint64_t>(2 * r + 1);
  }

  float nearest(const Vec3& offset) const {
    const Cell s = cell_of(offset);
    return nearest_[position(s.face, s.u, s.v)];
  }

 private:
  static constexpr int kEdge = 512;

  struct Cell {
    int face, u, v;
    double depth;  // along the axis of the face
  };

  static std::size_t position(int face, int u, int v) {
    return (static_cast<std::size_t>(face) * kEdge + static_cast<std::size_t>(v)) * kEdge + static_cast<std::size_t>(u);
  }

  static Cell cell_of(const Vec3& d) {
    const double x = std::fabs(d.x), y = std::fabs(d.y), z = std::fabs(d.z);
    const double depth = std::max({x, y, z, 1e-9});
    const auto index = [&](double across) {
      return std::min(static_cast<int>((across / depth + 1) * (0.5 * kEdge)), kEdge - 1);
    };
    if (x >= y && x >= z) return {d.x < 0 ? 1 : 0, index(d.y), index(d.z), depth};
    if (y >= z) return {d.y < 0 ? 3 : 2, index(d.x), index(d.z), depth};
    return {d.z < 0 ? 5 : 4, index(d.x), index(d.y), depth};
  }

  std::vector<float> nearest_ =
      std::vector<float>(std::size_t{6} * kEdge * kEdge, std::numeric_limits<float>::infinity());
};

}  // namespace

absl::Status find_visible_voxels(const FrameContext& frame, const VoxelGrid& grid, std::vector<bool>& visible) {
  constexpr double kMargin = 2;  // voxels
  const Vec3 sensor = sensor_of(frame.view());
  DirectionCube cube;
  std::vector<float> distance(grid.size());
  StopCheck check(frame.stop);
  check.for_each(0, grid.size(), [&](std::size_t v) {
    const Vec3 offset = grid.centroid[v] - sensor;
    distance[v] = static_cast<float>(norm(offset));
    return cube.cover(offset, distance[v], voxel_edge(frame.scale, frame.view(), grid.centroid[v]));
  });
  visible.resize(grid.size());
  check.for_each(0, grid.size(), [&](std::size_t v) {
    const double margin = kMargin * voxel_edge(frame.scale, frame.view(), grid.centroid[v]);
    visible[v] = distance[v] <= cube.nearest(grid.centroid[v] - sensor) + margin;
  });
  return check.status();
}

}  // namespace segserve
