// Part of the kernels; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/supervoxels/simd/candidate_assignment.hpp"
#include "core/supervoxels/simd/neighbor_queries.hpp"

namespace segserve::SEGSERVE_KERNELS {

extern const growth::Kernels kGrowthKernels;
const growth::Kernels kGrowthKernels{find_claims, keep_touching, find_fresh};

}  // namespace segserve::SEGSERVE_KERNELS
