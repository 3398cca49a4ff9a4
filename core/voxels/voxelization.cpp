// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/voxelization.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "core/base/parallel_parts.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/voxels/cell_mapping.hpp"
#include "core/voxels/point_selections.hpp"
#include "fmt/format.h"

namespace segserve {
namespace {

/// Adds up the points without a cell of all parts, which are in the order of the cloud.
PointsWithoutCell sum_of(const std::vector<PartialVoxels>& parts) {
  PointsWithoutCell sum;
  for (const PartialVoxels& part : parts) {
    sum.zeros += part.without_cell.zeros;
    sum.others += part.without_cell.others;
    sum.first_other = std::min(sum.first_other, part.without_cell.first_other);
  }
  return sum;
}

/// Whether so few points have no cell that they are taken for faults of the sensor: a few single ones, or one in a
/// hundred. More of them mean that the cloud as a whole lies elsewhere.
bool are_single(const PointsWithoutCell& without, std::size_t finite_points) {
  constexpr std::size_t kFew = 3, kShare = 100;
  const std::size_t good = finite_points - without.others;
  return without.others <= std::max(good / kShare, std::min(kFew, good / 2));
}

absl::Status invalid_point(const CloudView& cloud, const CellMapping& mapping, double resolution, std::size_t i) {
  const float x = cloud.x[i], y = cloud.y[i], z = cloud.z[i];
  if (cloud.view.kind == ViewKind::kCamera && z <= 0) {
    return absl::InvalidArgumentError(fmt::format(
        "point {} at ({}, {}, {}): z must be above 0 in a CAMERA view; is this a WORLD cloud?", i, x, y, z));
  }
  return absl::InvalidArgumentError(fmt::format(
      "point {} at ({}, {}, {}) is beyond the grid, which reaches {} m{} at voxel_resolution {} m; is the unit of "
      "the coordinates right? larger voxels reach farther",
      i, x, y, z, mapping.coordinate_limit(),
      cloud.view.kind == ViewKind::kCamera ? fmt::format(" and |x/z|, |y/z| < {:.0f}", resolution * kCellBias) : "",
      resolution));
}

/// Ranks the keys of the voxels: numbers that sort as the keys do, but with the fewest bits, because every bit less
/// shortens the radix sort. Each coordinate counts from the smallest of all voxels.
void rank_keys(const VoxelList& voxels, StopCheck& check, std::vector<std::uint64_t>& ranked) {
  constexpr VoxelKey kMask = (VoxelKey{1} << kCellBits) - 1;
  const auto coordinate = [](VoxelKey key, std::size_t axis) {
    return key >> (static_cast<int>(axis) * kCellBits) & kMask;
  };
  std::array<VoxelKey, 3> least{kMask, kMask, kMask}, most{};
  ranked.resize(voxels.size());
  check.for_each(0, voxels.size(), [&](std::size_t i) {
    ranked[i] = voxels[i].key;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least[axis] = std::min(least[axis], coordinate(ranked[i], axis));
      most[axis] = std::max(most[axis], coordinate(ranked[i], axis));
    }
  });
  const int y_shift = std::bit_width(most[0] - least[0]), z_shift = y_shift + std::bit_width(most[1] - least[1]);
  check.for_each(0, voxels.size(), [&](std::size_t i) {
    ranked[i] = (coordinate(ranked[i], 0) - least[0]) | (coordinate(ranked[i], 1) - least[1]) << y_shift |
                (coordinate(ranked[i], 2) - least[2]) << z_shift;
  });
}

}  // namespace

absl::Status Voxelization::run(const FrameContext& frame, VoxelGrid& grid, VoxelAdmission* admission) {
  const std::size_t points = frame.cloud.size();
  const unsigned threads = frame.executor.threads();
  const PointSelections selections(frame.options, frame.view());
  const CellMapping mapping(frame.scale);
  if (parts_.size() != threads) parts_ = std::vector<PartialVoxels>(threads);
  // A single thread appends the slots chunk by chunk, so that each chunk is written while it is in the cache.
  grid.slot_of_point.clear();
  grid.slot_of_point.reserve(points);
  if (threads > 1) grid.slot_of_point.resize(points);
  RETURN_IF_ERROR(parallel_parts(frame.executor, frame.stop, points,
                                 [&](unsigned part, std::size_t begin, std::size_t end, StopCheck& check) {
                                   RangeVoxelizer(frame.cloud, selections, mapping, parts_[part], grid.slot_of_point)
                                       .run(begin, end, check, admission);
                                 }));
  if (admission != nullptr) RETURN_IF_ERROR(admission->status());
  const PointsWithoutCell without = sum_of(parts_);
  RETURN_IF_ERROR(merge_parts(frame, grid));
  if (!are_single(without, grid.finite_points)) {
    return invalid_point(frame.cloud, mapping, frame.scale.voxel, without.first_other);
  }
  grid.zero_points = without.zeros;
  grid.points_beyond_grid = without.others;
  return sort_voxels(frame, mapping.unit(), grid);
}

/// Gathers the voxels of all parts in the first one, and makes the slots of all points those of the first one.
absl::Status Voxelization::merge_parts(const FrameContext& frame, VoxelGrid& grid) {
  PartialVoxels& merged = parts_[0];
  std::vector<std::vector<std::uint32_t>> merged_slot(parts_.size());
  StopCheck check(frame.stop);
  for (std::size_t p = 1; p < parts_.size(); ++p) {
    const VoxelList& voxels = parts_[p].table.voxels();
    merged_slot[p].assign(voxels.size() + 1, 0);
    VoxelTable::Lookups lookups(merged.table, voxels.size());
    check.for_each(0, voxels.size(), [&](std::size_t s) {
      const std::uint32_t slot = lookups.find_or_insert(voxels[s].key);
      merged.table.voxel(slot).add(voxels[s]);
      merged_slot[p][s + 1] = slot;
    });
    merged.finite_points += parts_[p].finite_points;
  }
  grid.finite_points = merged.finite_points;
  RETURN_IF_ERROR(check.status());
  if (parts_.size() == 1) return absl::OkStatus();
  return parallel_parts(frame.executor, frame.stop, frame.cloud.size(),
                        [&](unsigned part, std::size_t begin, std::size_t end, StopCheck& part_check) {
                          if (part == 0) return;
                          part_check.for_each(begin, end, [&](std::size_t i) {
                            grid.slot_of_point[i] = merged_slot[part][grid.slot_of_point[i]];
                          });
                        });
}

absl::Status Voxelization::sort_voxels(const FrameContext& frame, double coordinate_unit, VoxelGrid& grid) {
  const VoxelList& voxels = parts_[0].table.voxels();
  const std::size_t count = voxels.size();
  StopCheck check(frame.stop);
  rank_keys(voxels, check, ranked_);
  math::sort_order(ranked_, order_, sort_, check);
  constexpr std::size_t kAhead = 16;  // The memory is asked for this many voxels at the same time.
  grid.key.resize(count);
  grid.centroid.resize(count);
  grid.color_sum.resize(count);
  grid.points.resize(count);
  grid.voxel_of_slot.resize(count + 1);
  grid.voxel_of_slot[0] = 0;
  check.for_each(0, count, [&](std::size_t v) {
    const std::uint32_t i = order_[v];
    __builtin_prefetch(&voxels[order_[std::min(v + kAhead, count - 1)]]);
    const VoxelSums& sums = voxels[i];
    const double scale = coordinate_unit / static_cast<double>(sums.points);
    grid.key[v] = sums.key;
    grid.centroid[v] = {scale * static_cast<double>(sums.x), scale * static_cast<double>(sums.y),
                        scale * static_cast<double>(sums.z)};
    grid.color_sum[v] = {static_cast<double>(sums.red), static_cast<double>(sums.green),
                         static_cast<double>(sums.blue)};
    grid.points[v] = static_cast<std::uint32_t>(sums.points);
    grid.voxel_of_slot[i + 1] = static_cast<std::uint32_t>(v);
  });
  return check.status();
}

void Voxelization::free_scattered_tables() {
  for (PartialVoxels& part : parts_) part.table.free_if_scattered();
}

}  // namespace segserve
