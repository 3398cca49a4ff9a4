// Part of the kernels; see core/simd/simd_vectors.hpp. What lies around claims.
#pragma once

#include "core/simd/simd_vectors.hpp"
#include "core/supervoxels/simd/growth_kernels.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

#if defined(__AVX2__)

SEGSERVE_INLINE Int broadcast(std::uint32_t value) { return static_cast<std::int32_t>(value) - Int{}; }

/// Up to eight numbers of a row, from `at` on; `filler` in the lanes beyond its end.
SEGSERVE_INLINE Int eight_of(const std::uint32_t* numbers, std::uint32_t at, std::uint32_t end, std::uint32_t filler) {
  constexpr Int kLane{0, 1, 2, 3, 4, 5, 6, 7};
  const Int valid = kLane < broadcast(end - at);
  return valid ? __builtin_ia32_maskloadd256(reinterpret_cast<const Int*>(numbers + at), valid) : broadcast(filler);
}

/// The owners of eight voxels.
SEGSERVE_INLINE Int owners(const growth::Voxel* voxels, Int of) {
  static_assert(sizeof(growth::Voxel) == 64);  // eight times what a gather multiplies by
#if defined(__clang__)                         // which names it otherwise
  return __builtin_ia32_gatherd_d256(Int{}, reinterpret_cast<const int*>(&voxels->owner), of << 3, ~Int{}, 8);
#else
  return __builtin_ia32_gathersiv8si(Int{}, reinterpret_cast<const int*>(&voxels->owner), of << 3, ~Int{}, 8);
#endif
}

/// Whether the cluster owns a neighbour of v, which it does not own: eight of them at a time.
SEGSERVE_INLINE bool touches(const growth::Turn& turn, std::uint32_t v) {
  Int touching{};
  const growth::Voxel& voxel = turn.voxels[v];
  const std::uint32_t end = voxel.first + voxel.neighbors;
  for (std::uint32_t at = voxel.first; at < end; at += 8) {
    touching |= owners(turn.voxels, eight_of(turn.neighbor, at, end, v)) == broadcast(turn.cluster);
  }
  return any(touching);
}

#else

/// Whether the cluster owns a neighbour of v.
SEGSERVE_INLINE bool touches(const growth::Turn& turn, std::uint32_t v) {
  const growth::Voxel& voxel = turn.voxels[v];
  const std::uint32_t end = voxel.first + voxel.neighbors;
  for (std::uint32_t at = voxel.first; at < end; ++at) {
    if (turn.voxels[turn.neighbor[at]].owner == turn.cluster) return true;
  }
  return false;
}

#endif

growth::Found keep_touching(const growth::Turn& turn, const growth::Claim* claims, std::size_t count,
                            growth::Claim* kept) {
  growth::Found found{0, 0};
  for (std::size_t i = 0; i < count; ++i) {
    const growth::Claim claim = claims[i];
    const bool touching = touches(turn, claim.voxel);
    kept[found.count] = claim;
    found.count += static_cast<std::size_t>(touching);
    found.visits += turn.voxels[claim.voxel].neighbors;
    turn.voxels[claim.voxel].seen = touching ? turn.number : 0;
  }
  return found;
}

/// Rows of neighbours, one after the other, so that a single loop goes through all of them: the end of a loop for each
/// is mispredicted.
struct Rows {
  static constexpr std::size_t kUsual = 16, kMost = 512;
  std::uint32_t list[kMost + kUsual];
  std::size_t size = 0;

  /// False, and nothing is done, if there is no room.
  SEGSERVE_INLINE bool append(const growth::Turn& turn, const growth::Voxel& voxel) {
    const std::size_t begin = voxel.first, count = voxel.neighbors;
    if (size + count > kMost) return false;
    if (begin + kUsual <= turn.neighbors && count <= kUsual) {
      __builtin_memcpy(list + size, turn.neighbor + begin, kUsual * sizeof(std::uint32_t));
    } else {
      __builtin_memcpy(list + size, turn.neighbor + begin, count * sizeof(std::uint32_t));
    }
    size += count;
    return true;
  }
};

/// Appends the fresh ones of some voxels to a list. Without branches.
SEGSERVE_INLINE void append_fresh(const growth::Turn& turn, const std::uint32_t* voxels, std::size_t count,
                                  std::uint32_t* fresh, growth::Found& found) {
  const std::uint32_t cluster = turn.cluster, number = turn.number;
  std::size_t end = found.count;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t u = voxels[i];
    growth::Voxel& voxel = turn.voxels[u];
    fresh[end] = u;
    end += static_cast<std::size_t>((voxel.owner != cluster) & (voxel.seen != number));
    voxel.seen = number;
  }
  found.count = end;
  found.visits += count;
}

growth::Found find_fresh(const growth::Turn& turn, const growth::Claim* claims, std::size_t count,
                         std::uint32_t* fresh) {
  growth::Found found{0, 0};
  Rows rows;
  for (std::size_t i = 0; i < count; ++i) {
    const growth::Voxel& voxel = turn.voxels[claims[i].voxel];
    if (rows.append(turn, voxel)) continue;
    append_fresh(turn, rows.list, rows.size, fresh, found);
    rows.size = 0;
    if (rows.append(turn, voxel)) continue;  // else it has more neighbours than there ever is room for
    append_fresh(turn, turn.neighbor + voxel.first, voxel.neighbors, fresh, found);
  }
  append_fresh(turn, rows.list, rows.size, fresh, found);
  return found;
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
