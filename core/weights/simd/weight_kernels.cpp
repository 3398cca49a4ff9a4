// SPDX-License-Identifier: Apache-2.0
#include "core/weights/simd/weight_kernels.hpp"

#include "core/simd/simd_dispatch.hpp"

namespace segserve {

namespace baseline {
extern const WeightKernels kWeightKernels;
}
namespace avx2 {
extern const WeightKernels kWeightKernels;
}

const WeightKernels& weight_kernels() {
#if defined(SEGSERVE_AVX2)
  if (simd_target() == SimdTarget::kAvx2) return avx2::kWeightKernels;
#endif
  return baseline::kWeightKernels;
}

}  // namespace segserve
