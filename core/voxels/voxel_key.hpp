#pragma once

#include <cstdint>

namespace segserve {

/// Cell of a voxel: three signed 21-bit coordinates, z in the highest bits, each biased by 2^20, so
/// that keys sort by z, then y, then x.
using VoxelKey = std::uint64_t;
inline constexpr int kCellBits = 21;
inline constexpr std::int32_t kCellBias = 1 << (kCellBits - 1);
inline constexpr VoxelKey kNoKey = ~VoxelKey{0};  ///< of no voxel: keys use 63 bits

}  // namespace segserve
