#include "core/weights/simd/weight_kernels.hpp"

#include "core/simd/simd_dispatch.hpp"

namespace segserve {

namespace plain_kernels {
extern const MetricKernels kMetricKernels;
}
namespace avx2_kernels {
extern const MetricKernels kMetricKernels;
}

const MetricKernels& metric_kernels() {
#if defined(SEGSERVE_AVX2)
  if (cpu_in_use() == Cpu::kAvx2) return avx2_kernels::kMetricKernels;
#endif
  return plain_kernels::kMetricKernels;
}

}  // namespace segserve
