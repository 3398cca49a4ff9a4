// SPDX-License-Identifier: Apache-2.0
#include "core/voxels/simd/voxel_kernels.hpp"

#include "core/simd/simd_dispatch.hpp"

namespace segserve {

namespace baseline {
extern const VoxelKernels kVoxelKernels;
}
namespace avx2 {
extern const VoxelKernels kVoxelKernels;
}

const VoxelKernels& voxel_kernels() {
#if defined(SEGSERVE_AVX2)
  if (simd_target() == SimdTarget::kAvx2) return avx2::kVoxelKernels;
#endif
  return baseline::kVoxelKernels;
}

}  // namespace segserve
