// Part of the kernels; see math/lanes.hpp. What lies around claims.
#pragma once

#include "segserve/math/lanes.hpp"
#include "segserve/supervoxel/kernels/kernels.hpp"

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

SEGSERVE_INLINE Int gather(const std::uint32_t* from, Int of) {
#if defined(__clang__)  // which names it otherwise
  return __builtin_ia32_gatherd_d256(Int{}, reinterpret_cast<const int*>(from), of, ~Int{}, 4);
#else
  return __builtin_ia32_gathersiv8si(Int{}, reinterpret_cast<const int*>(from), of, ~Int{}, 4);
#endif
}

/// Whether the cluster owns a neighbour of v, which it does not own: eight of them at a time.
SEGSERVE_INLINE bool touches(const growth::Turn& turn, std::uint32_t v) {
  Int touching{};
  const std::uint32_t end = turn.offset[v + 1];
  for (std::uint32_t at = turn.offset[v]; at < end; at += 8) {
    touching |= gather(turn.owner, eight_of(turn.neighbor, at, end, v)) == broadcast(turn.cluster);
  }
  return any(touching);
}

#else

/// Whether the cluster owns a neighbour of v.
SEGSERVE_INLINE bool touches(const growth::Turn& turn, std::uint32_t v) {
  const std::uint32_t end = turn.offset[v + 1];
  for (std::uint32_t at = turn.offset[v]; at < end; ++at) {
    if (turn.owner[turn.neighbor[at]] == turn.cluster) return true;
  }
  return false;
}

#endif

std::size_t keep_touching(const growth::Turn& turn, const growth::Claim* claims, std::size_t count,
                          growth::Claim* kept) {
  std::size_t left = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const growth::Claim claim = claims[i];
    const bool touching = touches(turn, claim.voxel);
    kept[left] = claim;
    left += static_cast<std::size_t>(touching);
    turn.seen[claim.voxel] = touching ? turn.number : 0;
  }
  return left;
}

/// Rows of neighbours, one after the other, so that a single loop goes through all of them: the end of a loop for each
/// is mispredicted.
struct Rows {
  static constexpr std::size_t kUsual = 16, kMost = 512;
  std::uint32_t list[kMost + kUsual];
  std::size_t size = 0;

  /// False, and nothing is done, if there is no room.
  SEGSERVE_INLINE bool append(const growth::Turn& turn, std::uint32_t v) {
    const std::size_t begin = turn.offset[v], count = turn.offset[v + 1] - begin;
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

/// Appends the fresh ones of some voxels to a list. Returns their number. Without branches.
SEGSERVE_INLINE std::size_t append_fresh(const growth::Turn& turn, const std::uint32_t* voxels, std::size_t count,
                                         std::uint32_t* fresh) {
  const std::uint32_t cluster = turn.cluster, number = turn.number;
  const std::uint32_t* owner = turn.owner;
  std::uint32_t* seen = turn.seen;
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t u = voxels[i];
    fresh[found] = u;
    found += static_cast<std::size_t>((owner[u] != cluster) & (seen[u] != number));
    seen[u] = number;
  }
  return found;
}

std::size_t find_fresh(const growth::Turn& turn, const growth::Claim* claims, std::size_t count, std::uint32_t* fresh) {
  std::size_t found = 0;
  Rows rows;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t v = claims[i].voxel;
    if (rows.append(turn, v)) continue;
    found += append_fresh(turn, rows.list, rows.size, fresh + found);
    rows.size = 0;
    if (rows.append(turn, v)) continue;  // else it has more neighbours than there ever is room for
    found += append_fresh(turn, turn.neighbor + turn.offset[v], turn.offset[v + 1] - turn.offset[v], fresh + found);
  }
  return found + append_fresh(turn, rows.list, rows.size, fresh + found);
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
