#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/stop_check.hpp"
#include "core/supervoxels/growth_state.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::growth {

/// What the rounds did not reach: every voxel gets an owner. The first finds these voxels.
class Filling {
 public:
  Filling(const VoxelAdjacency& adjacency, const Distance& distance, StopCheck& check, State& state);

  /// Layer by layer, gives voxels without owner to the nearest cluster that touches them.
  void reach_the_rest();

  /// Components that no seed lies in: one cluster each, from the smallest voxel.
  void adopt_components();

 private:
  std::size_t claim_for_nearest(std::uint32_t v);
  void trim_rest();

  const VoxelAdjacency& adjacency_;
  Distance distance_;
  StopCheck& check_;
  State& state_;
};

}  // namespace segserve::growth
