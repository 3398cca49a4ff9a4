#pragma once

#include <cstdint>
#include <vector>

#include "segserve/pipeline/stop_token.hpp"
#include "segserve/supervoxel/distances.hpp"
#include "segserve/supervoxel/state.hpp"
#include "segserve/voxel/adjacency.hpp"

namespace segserve::growth {

/// Clusters that take turns to grow from their seeds.
class Rounds {
 public:
  Rounds(const VoxelAdjacency& adjacency, const Distance& distance, StopCheck& check, State& state)
      : adjacency_(adjacency), distance_(distance), check_(check), state_(state) {}

  /// One cluster for each seed that has no owner.
  void plant(const std::vector<std::uint32_t>& seeds);

  /// PCL's first round measures from the origin, so that what counts is who comes first: a seed next
  /// to an earlier one is taken by it and dies. That thins the seeds out well, so we do it on purpose.
  void first();

  /// Returns whether anything changed.
  bool next();

 private:
  void prefetch_turns_after(std::uint32_t c) const;
  template <typename Measure>
  void expand(std::uint32_t c, Measure&& measure);
  template <typename Measure>
  std::size_t find_claims(std::uint32_t c, Measure&& measure);
  std::size_t drop_claims_that_do_not_touch(std::size_t claims);
  bool touches(std::uint32_t v, std::uint32_t c) const;
  std::size_t add_candidates_around(std::uint32_t v, std::uint32_t c, std::size_t fresh);
  void take(const Claim& claim);
  bool move_centres();

  const VoxelAdjacency& adjacency_;
  const Distance& distance_;
  StopCheck& check_;
  State& state_;
};

}  // namespace segserve::growth
