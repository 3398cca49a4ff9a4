// SPDX-License-Identifier: Apache-2.0
// See core/simd/simd_vectors.hpp. Computes a function of as many pairs of regions at once as a vector has lanes.
#pragma once

#include "core/region_graph/region_edge.hpp"
#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

/// results[i] = function(a, b) for all pairs. make_input() makes an object with vectors of all numbers that the
/// function needs; its read(lane, a, b) fills a lane; compute(input) computes the function. Where fewer pairs are left
/// than lanes, the last pair fills them.
template <typename MakeInput, typename Compute>
SEGSERVE_INLINE void for_each_pair(const RegionEdge* pairs, std::size_t count, MakeInput&& make_input,
                                   Compute&& compute, double* results) {
  for (std::size_t i = 0; i < count; i += kDoubleLanes) {
    auto input = make_input();
#pragma GCC unroll 4
    for (std::size_t lane = 0; lane < kDoubleLanes; ++lane) {
      const RegionEdge& pair = pairs[i + lane < count ? i + lane : count - 1];
      input.read(lane, pair.a, pair.b);
    }
    const Doubles result = compute(input);
    if (i + kDoubleLanes <= count) {
      store(result, results + i);
    } else {
      for (std::size_t lane = 0; i + lane < count; ++lane) results[i + lane] = result[lane];
    }
  }
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
