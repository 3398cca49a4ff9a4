// SPDX-License-Identifier: Apache-2.0
// A kernel; see core/simd/simd_vectors.hpp. Finds the voxels of nearby rows of cells that are in a neighborhood.
#pragma once

#include "core/normals/simd/normal_kernels.hpp"
#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

/// Counts the cells before the first one that is not below `limit`. There are 8 cells, of which the first `most`, which
/// ascend, count. It has no branches.
SEGSERVE_INLINE std::uint32_t count_below(const std::int32_t* cells, std::int32_t limit, std::uint32_t most) {
  std::uint32_t below = 0;
#pragma GCC unroll 2
  for (std::size_t k = 0; k < kColumnPadding; k += kFloatLanes) below |= bits(load<Ints>(cells + k) < limit) << k;
  const auto count = static_cast<std::uint32_t>(__builtin_ctz(~below));
  return count < most ? count : most;
}

SpanCount find_spans(const std::int32_t* cell_x, std::int32_t left, std::int32_t right, CellRow* rows,
                     std::size_t count, RowSpan* spans) {
  RowSpan* out = spans;
  std::uint32_t voxels = 0;
  for (CellRow* row = rows; row < rows + count; ++row) {
    std::uint32_t next = row->next, passed = 0;
    do {
      passed = count_below(cell_x + next, left, row->end - next);
      next += passed;
    } while (passed == kColumnPadding);
    row->next = next;
    const std::uint32_t found = count_below(cell_x + next, right + 1, row->end - next);
    *out = {next, found};
    out += static_cast<std::ptrdiff_t>(found > 0);
    voxels += found;
  }
  return {static_cast<std::uint32_t>(out - spans), voxels};
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
