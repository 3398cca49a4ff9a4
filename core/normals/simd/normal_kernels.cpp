#include "core/normals/simd/normal_kernels.hpp"

#include "core/simd/simd_dispatch.hpp"

namespace segserve {

namespace plain_kernels {
extern const NormalKernels kNormalKernels;
}
namespace avx2_kernels {
extern const NormalKernels kNormalKernels;
}

const NormalKernels& normal_kernels() {
#if defined(SEGSERVE_AVX2)
  if (cpu_in_use() == Cpu::kAvx2) return avx2_kernels::kNormalKernels;
#endif
  return plain_kernels::kNormalKernels;
}

}  // namespace segserve
