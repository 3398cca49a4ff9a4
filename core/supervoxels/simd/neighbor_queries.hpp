// SPDX-License-Identifier: Apache-2.0
// Kernels; see core/simd/simd_vectors.hpp. Queries of the neighbors of voxels that a cluster is about to be assigned.
#pragma once

#include "core/simd/simd_vectors.hpp"
#include "core/supervoxels/simd/growth_kernels.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

#if defined(__AVX2__)

SEGSERVE_INLINE Ints broadcast_int(std::uint32_t value) { return static_cast<std::int32_t>(value) - Ints{}; }

/// Up to eight numbers from numbers[at] on. Lanes beyond numbers[end - 1] hold `filler`.
SEGSERVE_INLINE Ints load_up_to_eight(const std::uint32_t* numbers, std::uint32_t at, std::uint32_t end,
                                      std::uint32_t filler) {
  constexpr Ints kLane{0, 1, 2, 3, 4, 5, 6, 7};
  const Ints valid = kLane < broadcast_int(end - at);
  return valid ? __builtin_ia32_maskloadd256(reinterpret_cast<const Ints*>(numbers + at), valid)
               : broadcast_int(filler);
}

/// The clusters of eight voxels.
SEGSERVE_INLINE Ints gather_clusters(const growth::Voxel* voxels, Ints indices) {
  static_assert(sizeof(growth::Voxel) == 64);  // The largest factor of a gather is 8; the shift makes it 64.
  const auto* const first = reinterpret_cast<const int*>(reinterpret_cast<const unsigned char*>(voxels) +
                                                         __builtin_offsetof(growth::Voxel, cluster));
#if defined(__clang__)
  return __builtin_ia32_gatherd_d256(Ints{}, first, indices << 3, ~Ints{}, 8);
#else
  return __builtin_ia32_gathersiv8si(Ints{}, first, indices << 3, ~Ints{}, 8);
#endif
}

/// Whether a neighbor of v, which is not in the cluster, is. Looks at eight neighbors at a time.
SEGSERVE_INLINE bool is_adjacent(const growth::Expansion& expansion, std::uint32_t v) {
  Ints in_cluster{};
  const growth::Voxel& voxel = expansion.voxels[v];
  const std::uint32_t end = voxel.first_neighbor + voxel.neighbor_count;
  for (std::uint32_t at = voxel.first_neighbor; at < end; at += 8) {
    const Ints neighbors = load_up_to_eight(expansion.neighbor, at, end, v);
    in_cluster |= gather_clusters(expansion.voxels, neighbors) == broadcast_int(expansion.cluster);
  }
  return any(in_cluster);
}

#else

/// Whether a neighbor of v is in the cluster.
SEGSERVE_INLINE bool is_adjacent(const growth::Expansion& expansion, std::uint32_t v) {
  const growth::Voxel& voxel = expansion.voxels[v];
  const std::uint32_t end = voxel.first_neighbor + voxel.neighbor_count;
  for (std::uint32_t at = voxel.first_neighbor; at < end; ++at) {
    if (expansion.voxels[expansion.neighbor[at]].cluster == expansion.cluster) return true;
  }
  return false;
}

#endif

growth::QueryCounts keep_adjacent(const growth::Expansion& expansion, const growth::AssignedVoxel* assigned,
                                  std::size_t count, growth::AssignedVoxel* kept) {
  // The memory of all these neighbors is asked for at once, so that one is not waited for after the other.
  for (std::size_t i = 0; i < count; ++i) {
    __builtin_prefetch(expansion.neighbor + expansion.voxels[assigned[i].voxel].first_neighbor);
  }
  growth::QueryCounts counts{0, 0};
  for (std::size_t i = 0; i < count; ++i) {
    const growth::AssignedVoxel one = assigned[i];
    const bool adjacent = is_adjacent(expansion, one.voxel);
    growth::Voxel& voxel = expansion.voxels[one.voxel];
    kept[counts.found] = one;
    counts.found += static_cast<std::size_t>(adjacent);
    counts.visited += voxel.neighbor_count;
    voxel.visited_in = adjacent ? expansion.number : 0;
  }
  return counts;
}

/// The neighbors of several voxels, one after the other, so that a single loop goes through all of them. With a loop
/// for each voxel the CPU would mispredict the end of each.
struct NeighborBuffer {
  static constexpr std::size_t kUsual = 16, kMost = 512;
  std::uint32_t neighbors[kMost + kUsual];
  std::size_t size = 0;

  /// Appends the neighbors of the voxel if there is room for them. Returns whether there was.
  SEGSERVE_INLINE bool append(const growth::Expansion& expansion, const growth::Voxel& voxel) {
    const std::size_t begin = voxel.first_neighbor, count = voxel.neighbor_count;
    if (size + count > kMost) return false;
    if (begin + kUsual <= expansion.neighbor_entries && count <= kUsual) {
      __builtin_memcpy(neighbors + size, expansion.neighbor + begin, kUsual * sizeof(std::uint32_t));
    } else {
      __builtin_memcpy(neighbors + size, expansion.neighbor + begin, count * sizeof(std::uint32_t));
    }
    size += count;
    return true;
  }
};

/// Appends those of the voxels that are not in the cluster and not yet visited to the candidates, without branches.
SEGSERVE_INLINE void append_new(const growth::Expansion& expansion, const std::uint32_t* voxels, std::size_t count,
                                std::uint32_t* candidates, growth::QueryCounts& counts) {
  const std::uint32_t cluster = expansion.cluster, number = expansion.number;
  std::size_t end = counts.found;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t u = voxels[i];
    growth::Voxel& voxel = expansion.voxels[u];
    candidates[end] = u;
    end += static_cast<std::size_t>((voxel.cluster != cluster) & (voxel.visited_in != number));
    voxel.visited_in = number;
  }
  counts.found = end;
  counts.visited += count;
}

growth::QueryCounts find_new_candidates(const growth::Expansion& expansion, const growth::AssignedVoxel* assigned,
                                        std::size_t count, std::uint32_t* candidates) {
  growth::QueryCounts counts{0, 0};
  NeighborBuffer buffer;
  for (std::size_t i = 0; i < count; ++i) {
    const growth::Voxel& voxel = expansion.voxels[assigned[i].voxel];
    if (buffer.append(expansion, voxel)) continue;
    append_new(expansion, buffer.neighbors, buffer.size, candidates, counts);
    buffer.size = 0;
    if (buffer.append(expansion, voxel)) continue;
    append_new(expansion, expansion.neighbor + voxel.first_neighbor, voxel.neighbor_count, candidates, counts);
  }
  append_new(expansion, buffer.neighbors, buffer.size, candidates, counts);
  return counts;
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
