// SPDX-License-Identifier: Apache-2.0
// The kernels for every CPU of the architecture.
#define SEGSERVE_SIMD_TARGET baseline
#include "core/weights/simd/weight_kernel_table.hpp"
