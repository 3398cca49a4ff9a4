// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/range_voxelizer.hpp"

#include "core/base/stop_check.hpp"
#include "core/voxels/cell_input.hpp"
#include "core/voxels/sweep_cells.hpp"

namespace segserve {

void RangeVoxelizer::run(std::size_t begin, std::size_t end, StopCheck& check, VoxelAdmission* admission) {
  part_.table.clear();
  part_.without_cell = {};
  part_.finite_points = 0;
  std::size_t reported = 0;
  for (std::size_t first = begin, count = 0; first < end; first += count) {
    const PointSelections::Part& part = selections_.at(first);
    count = std::min({kChunk, end - first, part.end - first});
    if (check.after(count)) return;
    find_cells(part.selection, first, count);
    if (!selections_.all()) count_finite(first, count);
    find_slots(find_runs(first, count));
    const std::size_t voxels = part_.table.voxels().size();
    if (admission != nullptr && voxels - reported >= VoxelAdmission::kPortion) {
      if (!admission->add(voxels - reported)) return;
      reported = voxels;
    }
    if (first + count > slot_of_point_.size()) slot_of_point_.resize(first + count);
    std::copy_n(slots_.begin(), count, slot_of_point_.begin() + static_cast<std::ptrdiff_t>(first));
  }
}

void RangeVoxelizer::find_cells(const PointSelection& selection, std::size_t first, std::size_t count) {
  const CellInput in = cell_input(cloud_, selection, mapping_, first);
  const CellOutput out{keys_.data(), x_.data(), y_.data(), z_.data()};
  const PointsWithoutCell chunk = mapping_.scale.sweep ? find_sweep_cells(in, mapping_, selection, count, out)
                                                       : kernels_.find_cells(in, count, out);
  PointsWithoutCell& sum = part_.without_cell;
  if (chunk.others > 0 && sum.others == 0) sum.first_other = first + chunk.first_other;
  sum.zeros += chunk.zeros;
  sum.others += chunk.others;
  // Points with a cell are counted by find_slots.
  if (selections_.all()) part_.finite_points += chunk.others;
}

void RangeVoxelizer::count_finite(std::size_t first, std::size_t count) {
  const bool camera = cloud_.view.kind == ViewKind::kCamera;
  for (std::size_t i = first; i < first + count; ++i) {
    const float x = cloud_.x[i], y = cloud_.y[i], z = cloud_.z[i];
    const bool is_zero = (camera && x == 0 && y == 0 && z == 0) || is_without_echo(mapping_.scale, {x, y, z});
    part_.finite_points += static_cast<std::size_t>(is_finite(x, y, z) && !is_zero);
  }
}

/// Neighboring points mostly share a voxel, so the table is asked once for each run of equal keys. Returns the number
/// of runs.
std::size_t RangeVoxelizer::find_runs(std::size_t first, std::size_t count) {
  const std::uint32_t* const rgb = cloud_.has_color() ? cloud_.rgb.data() + first : nullptr;
  return kernels_.find_runs({keys_.data(), x_.data(), y_.data(), z_.data(), rgb}, count,
                            {run_begin_.data(), sums_.data()});
}

void RangeVoxelizer::find_slots(std::size_t runs) {
  VoxelTable::Lookups lookups(part_.table, runs);
  for (std::size_t run = 0; run < runs; ++run) {
    hash_[run] = VoxelTable::hash(keys_[run_begin_[run]]);
    lookups.prefetch(hash_[run]);
  }
  for (std::size_t run = 0; run < runs; ++run) cells_[run] = lookups.find_cell(keys_[run_begin_[run]], hash_[run]);
  for (std::size_t run = 0; run < runs; ++run) {
    const VoxelKey key = keys_[run_begin_[run]];
    slot_of_run_[run] = key == kNoKey ? 0 : lookups.find_or_insert(key, cells_[run]);
  }
  std::size_t finite = 0;
  for (std::size_t run = 0; run < runs; ++run) {
    const std::size_t begin = run_begin_[run], end = run_begin_[run + 1];
    const std::uint32_t slot = slot_of_run_[run];
    if (slot != 0) {
      part_.table.voxel(slot).add(sums_[run], sums_[run + 1], end - begin);
      finite += end - begin;
    }
    // Writes eight entries at a time, however long the run is: the next run overwrites the rest.
    for (std::size_t i = begin; i < end; i += kRoom) std::fill_n(&slots_[i], kRoom, slot);
  }
  if (selections_.all()) part_.finite_points += finite;
}

}  // namespace segserve
