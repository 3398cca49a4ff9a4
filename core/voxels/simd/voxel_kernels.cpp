#include "core/voxels/simd/voxel_kernels.hpp"

#include "core/simd/simd_dispatch.hpp"

namespace segserve {

namespace plain_kernels {
extern const VoxelKernels kVoxelKernels;
}
namespace avx2_kernels {
extern const VoxelKernels kVoxelKernels;
}

const VoxelKernels& voxel_kernels() {
#if defined(SEGSERVE_AVX2)
  if (cpu_in_use() == Cpu::kAvx2) return avx2_kernels::kVoxelKernels;
#endif
  return plain_kernels::kVoxelKernels;
}

}  // namespace segserve
