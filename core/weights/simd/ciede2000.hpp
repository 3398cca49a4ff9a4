// SPDX-License-Identifier: Apache-2.0
// A kernel; see core/simd/simd_vectors.hpp. Computes CIEDE2000 of several pairs of colors at once.
#pragma once

#include "core/simd/elementary_functions.hpp"
#include "core/weights/simd/region_pair_vectors.hpp"
#include "core/weights/simd/weight_kernels.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

SEGSERVE_INLINE Doubles square(Doubles x) { return x * x; }

/// sqrt(c^7 / (c^7 + 25^7))
SEGSERVE_INLINE Doubles chroma_seventh(Doubles c) {
  const Doubles c2 = c * c;
  const Doubles c7 = c2 * c2 * c2 * c;
  return square_root(c7 / (c7 + 6103515625.0));
}

/// The hue angle in [0, 2 pi); 0 for gray.
SEGSERVE_INLINE Doubles hue(Doubles a, Doubles b) {
  const Doubles h = atan2(b, a);
  return h < 0.0 ? h + 2 * kPi : h;
}

struct HuePair {
  Doubles difference, mean;  // in radians; defined for grays, too
};

SEGSERVE_INLINE HuePair compare_hues(Doubles h1, Doubles h2, Int64s gray) {
  const Doubles d = h2 - h1;
  const Doubles sum = h1 + h2;
  // Opposite hues are pi apart up to rounding. The margin keeps them on one side of the formula's discontinuity there.
  const Int64s near = absolute(d) <= kPi + 1e-12;
  const Doubles around = d > 0.0 ? d - 2 * kPi : d + 2 * kPi;
  const Doubles opposite = sum < 2 * kPi ? sum / 2.0 + kPi : sum / 2.0 - kPi;
  return {gray ? Doubles{} : near ? d : around, gray ? sum : near ? sum / 2.0 : opposite};
}

/// The term of eq. 22 that rotates blue hues. Other hues are not affected by it beyond rounding.
SEGSERVE_INLINE Doubles rotation(Doubles from_blue, Doubles c, Doubles chroma, Doubles hue) {
  const Doubles angle = 30 * kDegree * exp(-from_blue);
  const Doubles rt = -2.0 * chroma_seventh(c) * sin(2.0 * angle);
  return rt * chroma * hue;
}

struct LabPairs {
  const Lab* colors;
  Doubles pl, pa, pb, ql, qa, qb;
  SEGSERVE_INLINE void read(std::size_t lane, std::uint32_t i, std::uint32_t j) {
    const Lab &p = colors[i], &q = colors[j];
    pl[lane] = p.l, pa[lane] = p.a, pb[lane] = p.b;
    ql[lane] = q.l, qa[lane] = q.a, qb[lane] = q.b;
  }
};

/// Sharma, Wu, Dalal 2005, eq. 2 to 22, with k_L = k_C = k_H = 1.
SEGSERVE_INLINE Doubles ciede2000(const LabPairs& x) {
  const Doubles mean_chroma = (square_root(x.pa * x.pa + x.pb * x.pb) + square_root(x.qa * x.qa + x.qb * x.qb)) / 2.0;
  const Doubles g = 0.5 * (1.0 - chroma_seventh(mean_chroma));  // eq. 4 stretches a* near gray
  const Doubles a1 = (1.0 + g) * x.pa, a2 = (1.0 + g) * x.qa;
  const Doubles c1 = square_root(a1 * a1 + x.pb * x.pb), c2 = square_root(a2 * a2 + x.qb * x.qb);
  const HuePair h = compare_hues(hue(a1, x.pb), hue(a2, x.qb), c1 * c2 == 0.0);

  const Doubles dl = x.ql - x.pl;
  const Doubles dc = c2 - c1;
  const Doubles dh = 2.0 * square_root(c1 * c2) * sin(h.difference / 2.0);

  const Doubles l = (x.pl + x.ql) / 2.0;
  const Doubles c = (c1 + c2) / 2.0;
  const Doubles t = 1.0 - 0.17 * cos(h.mean - 30 * kDegree) + 0.24 * cos(2.0 * h.mean) +
                    0.32 * cos(3.0 * h.mean + 6 * kDegree) - 0.20 * cos(4.0 * h.mean - 63 * kDegree);
  const Doubles sl = 1.0 + 0.015 * square(l - 50.0) / square_root(20.0 + square(l - 50.0));
  const Doubles sc = 1.0 + 0.045 * c;
  const Doubles sh = 1.0 + 0.015 * c * t;
  const Doubles whole = square(dl / sl) + square(dc / sc) + square(dh / sh);
  const Doubles from_blue = square((h.mean / kDegree - 275.0) / 25.0);
  const Int64s blue = from_blue <= 40.0;
  if (!any(blue)) return square_root(whole);
  return square_root(blue ? whole + rotation(from_blue, c, dc / sc, dh / sh) : whole);
}

void color_differences(const Lab* colors, const RegionEdge* pairs, std::size_t count, double* differences) {
  for_each_pair(
      pairs, count, [&]() SEGSERVE_INLINE_LAMBDA { return LabPairs{colors, {}, {}, {}, {}, {}, {}}; },
      [](const LabPairs& x) SEGSERVE_INLINE_LAMBDA { return ciede2000(x); }, differences);
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
