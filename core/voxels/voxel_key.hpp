// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace segserve {

/// The cell of a voxel: three signed 21-bit coordinates, each biased by 2^20, with z in the highest bits. So keys sort
/// by z, then y, then x.
using VoxelKey = std::uint64_t;
inline constexpr int kCellBits = 21;
inline constexpr std::int32_t kCellBias = 1 << (kCellBits - 1);
inline constexpr VoxelKey kNoKey = ~VoxelKey{0};  ///< is the key of no voxel, because keys use 63 bits

}  // namespace segserve
