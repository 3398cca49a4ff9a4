// Part of the kernels; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/normals/simd/neighborhood_plane_fit.hpp"
#include "core/normals/simd/ring_moments.hpp"
#include "core/normals/simd/row_spans.hpp"

namespace segserve::SEGSERVE_KERNELS {

extern const NormalKernels kNormalKernels;
const NormalKernels kNormalKernels{ring_moments, fit_planes, find_spans, fit_windows, refit_windows};

}  // namespace segserve::SEGSERVE_KERNELS
