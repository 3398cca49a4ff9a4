// Part of the kernels; see math/lanes.hpp.
#pragma once

#include "segserve/supervoxel/kernels/claims.hpp"
#include "segserve/supervoxel/kernels/touching.hpp"

namespace segserve::SEGSERVE_KERNELS {

extern const growth::Kernels kGrowthKernels;
const growth::Kernels kGrowthKernels{find_claims, keep_touching, find_fresh};

}  // namespace segserve::SEGSERVE_KERNELS
