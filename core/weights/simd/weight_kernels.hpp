// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/math/vec3.hpp"
#include "core/region_graph/region_edge.hpp"
#include "core/weights/lab_color.hpp"

namespace segserve {

/// The centroids and normals of all regions.
struct RegionSurfaces {
  const Vec3* centroid;
  const Vec3* normal;  ///< unit vectors, or 0
};

/// The inner loops of metrics over many regions or pairs of regions, compiled once for each SimdTarget. All versions
/// give the same bytes.
struct WeightKernels {
  /// Converts the colors `rgb` from sRGB (IEC 61966-2-1), with channels 0..255.
  void (*srgb_to_lab)(const Vec3* rgb, std::size_t count, Lab* colors);
  /// CIEDE2000 between the colors of the two regions of each pair, in which a may be larger than b.
  void (*color_differences)(const Lab* colors, const RegionEdge* pairs, std::size_t count, double* differences);
  /// delta_G of eq. 5 for each pair, or delta'_G of eq. 7 with `halve_convex`.
  void (*geometric_terms)(const RegionSurfaces& surfaces, bool halve_convex, const RegionEdge* pairs, std::size_t count,
                          double* terms);
};

/// The kernels for `simd_target`.
const WeightKernels& weight_kernels();

}  // namespace segserve
