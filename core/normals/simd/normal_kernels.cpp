// SPDX-License-Identifier: Apache-2.0
#include "core/normals/simd/normal_kernels.hpp"

#include "core/simd/simd_dispatch.hpp"

namespace segserve {

namespace baseline {
extern const NormalKernels kNormalKernels;
}
namespace avx2 {
extern const NormalKernels kNormalKernels;
}

const NormalKernels& normal_kernels() {
#if defined(SEGSERVE_AVX2)
  if (simd_target() == SimdTarget::kAvx2) return avx2::kNormalKernels;
#endif
  return baseline::kNormalKernels;
}

}  // namespace segserve
