// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/sweep_cells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/math/elementary.hpp"
#include "core/math/vec3.hpp"
#include "core/voxels/voxel_grid.hpp"
#include "core/voxels/voxel_key.hpp"

namespace segserve {
namespace {

bool is_within(float limit, float x, float y, float z) {
  return std::fabs(x) < limit && std::fabs(y) < limit && std::fabs(z) < limit;
}

/// The first and the last column also hold what rounding puts beyond the ends of the turn.
std::int32_t column_of(double position, std::int32_t columns) {
  return std::clamp(math::floor_to_int(position), -columns / 2, columns / 2 - 1);
}

VoxelKey biased(std::int32_t coordinate) {
  return static_cast<VoxelKey>(static_cast<std::int64_t>(coordinate) + kCellBias);
}

}  // namespace

bool is_without_echo(const VoxelScale& scale, const Vec3& point) {
  return scale.sweep && depth_of(scale, point) < SweepProjection::kNearest;
}

PointsWithoutCell find_sweep_cells(const CellInput& in, const CellMapping& mapping, const PointSelection& selection,
                                   std::size_t count, const CellOutput& out) {
  const double cells_per_radian = 1 / mapping.scale.voxel;
  const std::int32_t columns = columns_of_turn(mapping.scale);
  PointsWithoutCell without;
  for (std::size_t i = 0; i < count; ++i) {
    out.keys[i] = kNoKey;
    out.x[i] = out.y[i] = out.z[i] = 0;
    const float x = in.x[i], y = in.y[i], z = in.z[i];
    if (!is_finite(x, y, z) || !selection.selects(x, y, z)) continue;
    if (!is_within(mapping.coordinate_limit(), x, y, z)) {
      if (without.others++ == 0) without.first_other = i;
      continue;
    }
    const Vec3 point{x, y, z};
    if (is_without_echo(mapping.scale, point)) {
      ++without.zeros;
      continue;
    }
    const Vec3 position = cells_per_radian * to_voxel_space(mapping.scale, point);
    out.keys[i] = biased(column_of(position.x, columns)) | biased(math::floor_to_int(position.y)) << kCellBits |
                  biased(math::floor_to_int(position.z)) << (2 * kCellBits);
    const auto fixed = [&](float v) { return math::floor_to_int(static_cast<double>(v * in.units_per_meter) + 0.5); };
    out.x[i] = fixed(x), out.y[i] = fixed(y), out.z[i] = fixed(z);
  }
  return without;
}

}  // namespace segserve
