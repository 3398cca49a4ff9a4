// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/coarser_resolution.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/voxels/cell_input.hpp"
#include "core/voxels/cell_mapping.hpp"
#include "core/voxels/point_selections.hpp"
#include "core/voxels/simd/voxel_kernels.hpp"
#include "core/voxels/voxel_key.hpp"

namespace segserve {
namespace {

/// Counts distinct numbers by the bits of a table that they leave unset.
class LinearCounter {
 public:
  void add(std::uint64_t value) {
    const std::uint64_t bit = mix(value) & (kBits - 1);
    words_[bit / 64] |= std::uint64_t{1} << (bit % 64);
  }
  double estimate() const {
    std::uint64_t set = 0;
    for (const std::uint64_t word : words_) set += static_cast<std::uint64_t>(std::popcount(word));
    const double unset = static_cast<double>(kBits - set);
    return unset == 0 ? HUGE_VAL : -static_cast<double>(kBits) * std::log(unset / static_cast<double>(kBits));
  }

 private:
  static constexpr std::uint64_t kBits = std::uint64_t{1} << 23U;

  /// The finalizer of SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, 2014).
  static std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
    return x ^ (x >> 31U);
  }

  std::vector<std::uint64_t> words_ = std::vector<std::uint64_t>(kBits / 64);
};

/// The key of the cell that holds this one where cells are 2^power times as long.
VoxelKey coarser(VoxelKey key, int power) {
  constexpr VoxelKey kCoordinate = (VoxelKey{1} << kCellBits) - 1;
  const VoxelKey kept = kCoordinate >> power << power;
  return key & (kept | kept << kCellBits | kept << (2 * kCellBits));
}

/// The number of voxels of the frame where cells are 2^power times as long, estimated.
double count_voxels(const FrameContext& frame, int power, StopCheck& check) {
  constexpr std::size_t kChunk = 512, kRoom = 8;
  std::array<VoxelKey, kChunk + kRoom> keys;
  std::array<std::int32_t, kChunk + kRoom> x, y, z;
  const CellMapping mapping(frame.scale);
  const PointSelections selections(frame.options, frame.view());
  LinearCounter counter;
  for (std::size_t first = 0, count = 0; first < frame.cloud.size(); first += count) {
    const PointSelections::Part& part = selections.at(first);
    count = std::min({kChunk, frame.cloud.size() - first, part.end - first});
    if (check.after(count)) break;
    const CellInput in = cell_input(frame.cloud, part.selection, mapping, first);
    voxel_kernels().find_cells(in, count, {keys.data(), x.data(), y.data(), z.data()});
    for (std::size_t i = 0; i < count; ++i) {
      if (keys[i] != kNoKey) counter.add(coarser(keys[i], power));
    }
  }
  return counter.estimate();
}

}  // namespace

double coarser_resolution(const FrameContext& frame, std::size_t voxels) {
  constexpr double kMargin = 1.05;
  StopCheck check(frame.stop);
  int power = 1;
  while (power < kCellBits && !check.stopped() &&
         kMargin * count_voxels(frame, power, check) > static_cast<double>(voxels)) {
    ++power;
  }
  return std::ldexp(frame.scale.voxel, power);
}

}  // namespace segserve
