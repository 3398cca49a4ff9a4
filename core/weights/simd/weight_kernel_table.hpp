// SPDX-License-Identifier: Apache-2.0
// The kernels, compiled for one SimdTarget; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/weights/simd/ciede2000.hpp"
#include "core/weights/simd/geometric_term.hpp"
#include "core/weights/simd/srgb_to_lab.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {

extern const WeightKernels kWeightKernels;
const WeightKernels kWeightKernels{srgb_to_lab, color_differences, geometric_terms};

}  // namespace segserve::SEGSERVE_SIMD_TARGET
