#pragma once

#include <cstddef>

#include "core/math/vec3.hpp"
#include "core/region_graph/region_edge.hpp"
#include "core/weights/lab_color.hpp"

namespace segserve {

/// Where a region is and which way it faces.
struct Surfaces {
  const Vec3* centroid;
  const Vec3* normal;  ///< unit, or 0
};

/// What metrics compute of many regions, or pairs of regions, compiled once for each kind of CPU. All give the same
/// bytes.
struct MetricKernels {
  /// The colours `rgb`, sRGB (IEC 61966-2-1) with channels 0..255.
  void (*srgb_to_lab)(const Vec3* rgb, std::size_t count, Lab* colors);
  /// CIEDE2000 between the colours of the two regions of each pair, which need not be in order.
  void (*color_differences)(const Lab* colors, const RegionEdge* pairs, std::size_t count, double* differences);
  /// eq. 5 of each pair; eq. 7 if `halve_convex`.
  void (*geometric_terms)(const Surfaces& surfaces, bool halve_convex, const RegionEdge* pairs, std::size_t count,
                          double* terms);
};

/// Those for `cpu_in_use`.
const MetricKernels& metric_kernels();

}  // namespace segserve
