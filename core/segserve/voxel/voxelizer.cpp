#include "segserve/voxel/voxelizer.hpp"

namespace segserve {
namespace {

constexpr int kColorBits = 21;

constexpr std::uint64_t spread_color(std::uint32_t rgb) {
  return std::uint64_t{rgb & 0xff0000U} << (2 * kColorBits - 16) | std::uint64_t{rgb & 0xff00U} << (kColorBits - 8) |
         (rgb & 0xffU);
}

/// sums[i] = value(0) + .. + value(i - 1).
template <typename Sum, typename Value>
void running_sum(std::size_t count, Sum* sums, Value&& value) {
  Sum sum = sums[0] = 0;
  for (std::size_t i = 0; i < count; ++i) sums[i + 1] = sum += value(i);
}

}  // namespace

void RangeVoxelizer::run(std::size_t begin, std::size_t end, StopCheck& check) {
  part_.table.clear();
  part_.first_invalid = SIZE_MAX;
  part_.finite_points = 0;
  for (std::size_t first = begin; first < end; first += kChunk) {
    const std::size_t count = std::min(kChunk, end - first);
    if (check.after(count)) return;
    if (!find_cells(first, count)) return;
    if (!selection_.all()) count_finite(first, count);
    sum_up(first, count);
    find_slots(find_runs(count));
    std::copy_n(slots_.begin(), count, slot_of_point_.begin() + static_cast<std::ptrdiff_t>(first));
  }
}

/// False: a point of the chunk has no cell.
bool RangeVoxelizer::find_cells(std::size_t first, std::size_t count) {
  const CellInput in{cloud_.x.data() + first,
                     cloud_.y.data() + first,
                     cloud_.z.data() + first,
                     cloud_.view.kind == ViewKind::kCamera,
                     mapping_.cells_per_metre,
                     mapping_.units_per_metre,
                     selection_.all() ? nullptr : &selection_.limits()};
  const std::size_t valid = kernels_.find_cells(in, count, {keys_.data(), x_.data(), y_.data(), z_.data()});
  if (valid < count) part_.first_invalid = first + valid;
  return valid == count;
}

void RangeVoxelizer::count_finite(std::size_t first, std::size_t count) {
  for (std::size_t i = first; i < first + count; ++i) {
    part_.finite_points += static_cast<std::size_t>(is_finite(cloud_.x[i], cloud_.y[i], cloud_.z[i]));
  }
}

/// So that the sums of a run are differences, without a loop of its length, which nobody can predict.
void RangeVoxelizer::sum_up(std::size_t first, std::size_t count) {
  running_sum(count, sum_x_.data(), [this](std::size_t i) { return x_[i]; });
  running_sum(count, sum_y_.data(), [this](std::size_t i) { return y_[i]; });
  running_sum(count, sum_z_.data(), [this](std::size_t i) { return z_[i]; });
  if (!cloud_.has_color()) return;
  running_sum(count, sum_color_.data(),
              [rgb = cloud_.rgb.data() + first](std::size_t i) { return spread_color(rgb[i]); });
}

/// Neighbouring points mostly share a voxel: one look-up for each run of equal keys. Returns the number of runs.
std::size_t RangeVoxelizer::find_runs(std::size_t count) {
  run_begin_[0] = 0;
  std::size_t runs = 1;
  for (std::size_t i = 1; i < count; ++i) {
    run_begin_[runs] = static_cast<std::uint32_t>(i);
    runs += static_cast<std::size_t>(keys_[i] != keys_[i - 1]);
  }
  run_begin_[runs] = static_cast<std::uint32_t>(count);
  return runs;
}

void RangeVoxelizer::find_slots(std::size_t runs) {
  for (std::size_t run = 0; run < runs; ++run) {
    hash_[run] = VoxelTable::hash(keys_[run_begin_[run]]);
    part_.table.prefetch_place(hash_[run]);
  }
  for (std::size_t run = 0; run < runs; ++run) part_.table.prefetch_voxel(hash_[run]);
  for (std::size_t run = 0; run < runs; ++run) {
    const std::uint32_t slot = keys_[run_begin_[run]] == kNoKey ? 0 : add_run(run);
    // Eight at once, whether the run is as long or not: the next one overwrites the rest.
    for (std::size_t i = run_begin_[run]; i < run_begin_[run + 1]; i += kRoom) std::fill_n(&slots_[i], kRoom, slot);
  }
}

std::uint32_t RangeVoxelizer::add_run(std::size_t run) {
  const std::size_t begin = run_begin_[run], end = run_begin_[run + 1];
  const std::uint32_t slot = part_.table.find_or_insert(keys_[begin], hash_[run]);
  VoxelSums& sums = part_.table.voxel(slot);
  sums.x += sum_x_[end] - sum_x_[begin];
  sums.y += sum_y_[end] - sum_y_[begin];
  sums.z += sum_z_[end] - sum_z_[begin];
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kColorBits) - 1;
  const std::uint64_t color = sum_color_[end] - sum_color_[begin];
  sums.red += color >> (2 * kColorBits);
  sums.green += color >> kColorBits & kMask;
  sums.blue += color & kMask;
  sums.points += end - begin;
  if (selection_.all()) part_.finite_points += end - begin;
  return slot;
}

}  // namespace segserve
