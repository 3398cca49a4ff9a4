// Part of the kernels; see math/lanes.hpp.
#pragma once

#include "segserve/metric/kernels/ciede2000.hpp"
#include "segserve/metric/kernels/geometry.hpp"
#include "segserve/metric/kernels/lab_colors.hpp"

namespace segserve::SEGSERVE_KERNELS {

extern const MetricKernels kMetricKernels;
const MetricKernels kMetricKernels{srgb_to_lab, color_differences, geometric_terms};

}  // namespace segserve::SEGSERVE_KERNELS
