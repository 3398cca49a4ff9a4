// Part of the kernels; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/region_graph/region_edge.hpp"
#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

/// out[i] = function(a, b) for all pairs, as many at once as a vector has lanes: each number of the two regions by
/// `read(lane, a, b)`, then `compute()`. Where fewer pairs are left, the last one fills the lanes.
template <typename Input, typename Compute>
SEGSERVE_INLINE void for_each_pair(const RegionEdge* pairs, std::size_t count, Input&& input, Compute&& compute,
                                   double* out) {
  for (std::size_t i = 0; i < count; i += kReals) {
    auto lanes = input();
#pragma GCC unroll 4
    for (std::size_t k = 0; k < kReals; ++k) {
      const RegionEdge& pair = pairs[i + k < count ? i + k : count - 1];
      lanes.read(k, pair.a, pair.b);
    }
    const Real result = compute(lanes);
    if (i + kReals <= count) {
      store(result, out + i);
    } else {
      for (std::size_t k = 0; i + k < count; ++k) out[i + k] = result[k];
    }
  }
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
