// SPDX-License-Identifier: Apache-2.0
// The kernels, compiled for one SimdTarget; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/normals/simd/neighborhood_plane_fit.hpp"
#include "core/normals/simd/ring_moments.hpp"
#include "core/normals/simd/row_spans.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {

extern const NormalKernels kNormalKernels;
const NormalKernels kNormalKernels{ring_moments, fit_planes, find_spans, fit_neighborhoods, refit_neighborhoods};

}  // namespace segserve::SEGSERVE_SIMD_TARGET
