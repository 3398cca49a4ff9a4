// SPDX-License-Identifier: Apache-2.0
#include "core/supervoxels/simd/growth_kernels.hpp"

#include "core/simd/simd_dispatch.hpp"

namespace segserve {

namespace baseline {
extern const GrowthKernels kGrowthKernels;
}
namespace avx2 {
extern const GrowthKernels kGrowthKernels;
}

const GrowthKernels& growth_kernels() {
#if defined(SEGSERVE_AVX2)
  if (simd_target() == SimdTarget::kAvx2) return avx2::kGrowthKernels;
#endif
  return baseline::kGrowthKernels;
}

}  // namespace segserve
