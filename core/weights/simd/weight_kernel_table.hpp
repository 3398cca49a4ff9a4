// Part of the kernels; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/weights/simd/ciede2000.hpp"
#include "core/weights/simd/geometric_term.hpp"
#include "core/weights/simd/srgb_to_lab.hpp"

namespace segserve::SEGSERVE_KERNELS {

extern const MetricKernels kMetricKernels;
const MetricKernels kMetricKernels{srgb_to_lab, color_differences, geometric_terms};

}  // namespace segserve::SEGSERVE_KERNELS
