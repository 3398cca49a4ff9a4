#include "core/supervoxels/simd/growth_kernels.hpp"

#include "core/simd/simd_dispatch.hpp"

namespace segserve {

namespace plain_kernels {
extern const growth::Kernels kGrowthKernels;
}
namespace avx2_kernels {
extern const growth::Kernels kGrowthKernels;
}

const growth::Kernels& growth::kernels() {
#if defined(SEGSERVE_AVX2)
  if (cpu_in_use() == Cpu::kAvx2) return avx2_kernels::kGrowthKernels;
#endif
  return plain_kernels::kGrowthKernels;
}

}  // namespace segserve
