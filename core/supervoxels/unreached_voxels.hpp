// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/stop_check.hpp"
#include "core/supervoxels/growth_state.hpp"
#include "core/voxels/voxel_adjacency.hpp"

namespace segserve::growth {

/// Assigns the voxels that the iterations did not reach to clusters.
///
/// All methods leave off when `check` stops them.
class UnreachedVoxelAssigner {
 public:
  /// Finds the unreached voxels.
  UnreachedVoxelAssigner(const VoxelAdjacency& adjacency, const DistanceWeights& weights, StopCheck& check,
                         GrowthState& state);

  /// Assigns unreached voxels with a neighbor in a cluster to the nearest such cluster. They are the first layer, and
  /// their unreached neighbors are the next, until no unreached voxel is connected with a cluster.
  void assign_by_layers();

  /// Makes a cluster of each connected component of the voxels that are still unreached. They are numbered by their
  /// smallest voxel.
  void make_clusters_of_components();

 private:
  std::size_t add_to_layer(std::uint32_t v);
  void drop_reached();

  const VoxelAdjacency& adjacency_;
  DistanceWeights weights_;
  StopCheck& check_;
  GrowthState& state_;
};

}  // namespace segserve::growth
