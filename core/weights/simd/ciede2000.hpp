// Part of the kernels; see core/simd/simd_vectors.hpp. CIEDE2000 of several pairs of colours at once.
#pragma once

#include "core/simd/simd_functions.hpp"
#include "core/weights/simd/region_pair_vectors.hpp"
#include "core/weights/simd/weight_kernels.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

SEGSERVE_INLINE Real square(Real x) { return x * x; }

/// sqrt(c^7 / (c^7 + 25^7))
SEGSERVE_INLINE Real chroma_seventh(Real c) {
  const Real c2 = c * c;
  const Real c7 = c2 * c2 * c2 * c;
  return square_root(c7 / (c7 + 6103515625.0));
}

/// Hue angle in [0, 2 pi); 0 for grey.
SEGSERVE_INLINE Real hue(Real a, Real b) {
  const Real h = atan2(b, a);
  return h < 0.0 ? h + 2 * kPi : h;
}

struct HuePair {
  Real difference, mean;  // radians; sensible for greys, too
};

SEGSERVE_INLINE HuePair compare_hues(Real h1, Real h2, RealMask grey) {
  const Real d = h2 - h1;
  const Real sum = h1 + h2;
  // Opposite hues are pi apart up to rounding; the formula is discontinuous just beyond.
  const RealMask near = absolute(d) <= kPi + 1e-12;
  const Real around = d > 0.0 ? d - 2 * kPi : d + 2 * kPi;
  const Real opposite = sum < 2 * kPi ? sum / 2.0 + kPi : sum / 2.0 - kPi;
  return {grey ? Real{} : near ? d : around, grey ? sum : near ? sum / 2.0 : opposite};
}

/// The rotation of blue hues, times both differences: elsewhere it is lost in rounding, and mostly spared.
SEGSERVE_INLINE Real rotation(Real from_blue, Real c, Real chroma, Real hue) {
  const Real angle = 30 * kDegree * exponential(-from_blue);
  const Real rt = -2.0 * chroma_seventh(c) * sin(2.0 * angle);
  return rt * chroma * hue;
}

struct LabPairs {
  const Lab* colors;
  Real pl, pa, pb, ql, qa, qb;
  SEGSERVE_INLINE void read(std::size_t lane, std::uint32_t i, std::uint32_t j) {
    const Lab &p = colors[i], &q = colors[j];
    pl[lane] = p.l, pa[lane] = p.a, pb[lane] = p.b;
    ql[lane] = q.l, qa[lane] = q.a, qb[lane] = q.b;
  }
};

/// Sharma, Wu, Dalal 2005, eq. 2 to 22, with k_L = k_C = k_H = 1.
SEGSERVE_INLINE Real ciede2000(const LabPairs& x) {
  const Real mean_chroma = (square_root(x.pa * x.pa + x.pb * x.pb) + square_root(x.qa * x.qa + x.qb * x.qb)) / 2.0;
  const Real g = 0.5 * (1.0 - chroma_seventh(mean_chroma));  // eq. 4: stretches a* near grey
  const Real a1 = (1.0 + g) * x.pa, a2 = (1.0 + g) * x.qa;
  const Real c1 = square_root(a1 * a1 + x.pb * x.pb), c2 = square_root(a2 * a2 + x.qb * x.qb);
  const HuePair h = compare_hues(hue(a1, x.pb), hue(a2, x.qb), c1 * c2 == 0.0);

  const Real dl = x.ql - x.pl;
  const Real dc = c2 - c1;
  const Real dh = 2.0 * square_root(c1 * c2) * sin(h.difference / 2.0);

  const Real l = (x.pl + x.ql) / 2.0;
  const Real c = (c1 + c2) / 2.0;
  const Real t = 1.0 - 0.17 * cos(h.mean - 30 * kDegree) + 0.24 * cos(2.0 * h.mean) +
                 0.32 * cos(3.0 * h.mean + 6 * kDegree) - 0.20 * cos(4.0 * h.mean - 63 * kDegree);
  const Real sl = 1.0 + 0.015 * square(l - 50.0) / square_root(20.0 + square(l - 50.0));
  const Real sc = 1.0 + 0.045 * c;
  const Real sh = 1.0 + 0.015 * c * t;
  const Real whole = square(dl / sl) + square(dc / sc) + square(dh / sh);
  const Real from_blue = square((h.mean / kDegree - 275.0) / 25.0);
  const RealMask blue = from_blue <= 40.0;
  if (!any(blue)) return square_root(whole);
  return square_root(blue ? whole + rotation(from_blue, c, dc / sc, dh / sh) : whole);
}

void color_differences(const Lab* colors, const RegionEdge* pairs, std::size_t count, double* differences) {
  for_each_pair(
      pairs, count, [&]() SEGSERVE_INLINE_LAMBDA { return LabPairs{colors, {}, {}, {}, {}, {}, {}}; },
      [](const LabPairs& x) SEGSERVE_INLINE_LAMBDA { return ciede2000(x); }, differences);
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
