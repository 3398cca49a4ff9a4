#pragma once

#include <cstdint>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/supervoxels/growth_state.hpp"
#include "core/voxels/voxel_adjacency.hpp"
#include "segserve/stop_token.hpp"

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
  std::uint32_t turn_after(std::uint32_t c) const;
  void prefetch_turns_after(std::uint32_t c) const;
  void prefetch_rows(const Turn& turn, std::size_t claims) const;
  template <typename FindClaims>
  void expand(std::uint32_t c, FindClaims&& find_claims);
  template <typename FindClaims>
  std::size_t split_candidates(const Turn& turn, FindClaims&& find_claims);
  std::size_t drop_claims_that_do_not_touch(const Turn& turn, std::size_t claims);
  void take(std::uint32_t c, std::size_t claims);
  void add_candidates(const Turn& turn, std::size_t claims);
  bool move_centres();

  const VoxelAdjacency& adjacency_;
  Distance distance_;
  StopCheck& check_;
  State& state_;
  const Kernels& kernels_ = kernels();
};

}  // namespace segserve::growth
