// Part of the kernels; see math/lanes.hpp.
#pragma once

#include "segserve/metric/kernels/ciede2000.hpp"
#include "segserve/metric/kernels/geometry.hpp"

namespace segserve::SEGSERVE_KERNELS {

extern const MetricKernels kMetricKernels;
const MetricKernels kMetricKernels{color_differences, geometric_terms};

}  // namespace segserve::SEGSERVE_KERNELS
