// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace segserve {
namespace growth {

/// The point of a voxel, or of the center of a cluster, in the space in which growth measures distances: position and
/// color, both scaled by their weights, and normal.
struct Feature {
  static constexpr std::size_t kSize = 9;
  enum Index : std::size_t { kX, kY, kZ, kNormalX, kNormalY, kNormalZ, kRed, kGreen, kBlue };
  float value[kSize];
};

/// All that growth asks of a voxel, in one cache line.
struct alignas(64) Voxel {
  Feature feature;
  float distance;                ///< to the center of its cluster, measured when the voxel was assigned to it
  std::uint32_t cluster;         ///< or kNoCluster
  std::uint32_t visited_in;      ///< the number of the last expansion that had the voxel among its candidates
  std::uint32_t first_neighbor;  ///< where its neighbors begin in VoxelAdjacency::neighbor
  std::uint32_t neighbor_count;
};

/// The part of the distance of VCCS that features do not contain. They are scaled by the other two weights.
struct DistanceWeights {
  float normal;
  bool colored;  ///< false if all colors are 0
};

/// A voxel that is about to be assigned to a cluster, and its distance to the center of that.
struct AssignedVoxel {
  std::uint32_t voxel;
  float distance;
};

/// One expansion of a cluster: the voxels and neighbors that it reads, and the voxels that it marks as visited.
struct Expansion {
  Voxel* voxels;
  const std::uint32_t* neighbor;  ///< as in VoxelAdjacency
  std::size_t neighbor_entries;   ///< the length of `neighbor`
  std::uint32_t cluster, number;
};

/// The number of voxels that a query found, and that of the neighbors that it looked at.
struct QueryCounts {
  std::size_t found, visited;
};

}  // namespace growth

/// The inner loops of supervoxel growth, compiled once for each SimdTarget. All versions give the same bytes.
struct GrowthKernels {
  /// Writes the candidates that are nearer to `center` than to the center of their own cluster to `assigned`, which
  /// must have room for all, and returns their number. Writes the others to `kept`, which may be `candidates`. Marks
  /// all of them as visited.
  std::size_t (*assign_candidates)(const growth::Expansion& expansion, const growth::DistanceWeights& weights,
                                   const growth::Feature& center, const std::uint32_t* candidates, std::size_t count,
                                   growth::AssignedVoxel* assigned, std::uint32_t* kept);
  /// Writes the assigned voxels with a neighbor in the cluster to `kept`, which may be `assigned`. Marks the others as
  /// not visited.
  growth::QueryCounts (*keep_adjacent)(const growth::Expansion& expansion, const growth::AssignedVoxel* assigned,
                                       std::size_t count, growth::AssignedVoxel* kept);
  /// Writes the neighbors of the assigned voxels that are in other clusters, or in none, and not yet visited to
  /// `candidates`, each once, and marks them as visited. `candidates` must have room for all neighbors and one more.
  growth::QueryCounts (*find_new_candidates)(const growth::Expansion& expansion, const growth::AssignedVoxel* assigned,
                                             std::size_t count, std::uint32_t* candidates);
};

/// The kernels for `simd_target`.
const GrowthKernels& growth_kernels();

}  // namespace segserve
