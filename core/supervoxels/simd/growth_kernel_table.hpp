// SPDX-License-Identifier: Apache-2.0
// The kernels, compiled for one SimdTarget; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/supervoxels/simd/candidate_assignment.hpp"
#include "core/supervoxels/simd/neighbor_queries.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {

extern const GrowthKernels kGrowthKernels;
const GrowthKernels kGrowthKernels{assign_candidates, keep_adjacent, find_new_candidates};

}  // namespace segserve::SEGSERVE_SIMD_TARGET
