#pragma once

#include <cstddef>
#include <cstdint>

#include "segserve/pipeline/stop_token.hpp"
#include "segserve/supervoxel/state.hpp"
#include "segserve/voxel/adjacency.hpp"

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
