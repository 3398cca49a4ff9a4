// SPDX-License-Identifier: Apache-2.0
// A kernel; see core/simd/simd_vectors.hpp. Computes the geometric dissimilarity of several pairs of regions at once.
#pragma once

#include "core/simd/elementary_functions.hpp"
#include "core/weights/simd/region_pair_vectors.hpp"
#include "core/weights/simd/weight_kernels.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

struct Triple {
  Doubles x, y, z;
};
SEGSERVE_INLINE Doubles dot(const Triple& a, const Triple& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
SEGSERVE_INLINE Triple cross(const Triple& a, const Triple& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
SEGSERVE_INLINE Doubles norm(const Triple& a) { return square_root(dot(a, a)); }

struct SurfacePairs {
  const RegionSurfaces& surfaces;
  Triple between, ni, nj;
  SEGSERVE_INLINE void read(std::size_t lane, std::uint32_t i, std::uint32_t j) {
    const Vec3 &xi = surfaces.centroid[i], &xj = surfaces.centroid[j], &a = surfaces.normal[i], &b = surfaces.normal[j];
    between.x[lane] = xi.x - xj.x, between.y[lane] = xi.y - xj.y, between.z[lane] = xi.z - xj.z;
    ni.x[lane] = a.x, ni.y[lane] = a.y, ni.z[lane] = a.z;
    nj.x[lane] = b.x, nj.y[lane] = b.y, nj.z[lane] = b.z;
  }
};

/// delta_G of eq. 5. Where the centroids coincide, c_ij is 0. The brackets make (i, j) and (j, i) give the same bits.
SEGSERVE_INLINE Doubles geometric_term(const SurfacePairs& s, bool halve_convex) {
  const Doubles length = norm(s.between);
  const Doubles scale = 1.0 / length;
  const Int64s apart = length > 0.0;
  const Triple c{apart ? scale * s.between.x : Doubles{}, apart ? scale * s.between.y : Doubles{},
                 apart ? scale * s.between.z : Doubles{}};
  const Doubles along_i = dot(s.ni, c), along_j = dot(s.nj, c);
  const Doubles term = (norm(cross(s.ni, s.nj)) + (absolute(along_i) + absolute(along_j))) / 3.0;
  if (!halve_convex) return term;
  return along_i - along_j >= 0.0 ? term / 2.0 : term;  // eq. 7
}

void geometric_terms(const RegionSurfaces& surfaces, bool halve_convex, const RegionEdge* pairs, std::size_t count,
                     double* terms) {
  for_each_pair(
      pairs, count,
      [&]() SEGSERVE_INLINE_LAMBDA {
        return SurfacePairs{surfaces, {}, {}, {}};
      },
      [&](const SurfacePairs& s) SEGSERVE_INLINE_LAMBDA { return geometric_term(s, halve_convex); }, terms);
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
