// Part of the kernels; see core/simd/simd_vectors.hpp. CIE 1976 L*a*b* of several colours at once.
#pragma once

#include "core/simd/simd_functions.hpp"
#include "core/weights/simd/weight_kernels.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

/// The inverse of sRGB's transfer curve; channel 0..255, result 0..1.
SEGSERVE_INLINE Real linear(Real channel) {
  const Real c = channel / 255.0;
  const Real curved = power((c + 0.055) / 1.055, 2.4);
  return c <= 0.04045 ? c / 12.92 : curved;
}

/// f of CIE 1976 L*a*b*: the cube root, with a straight line near zero.
SEGSERVE_INLINE Real lab_curve(Real t) {
  constexpr double kDelta = 6.0 / 29;
  const Real root = cube_root(t);
  return t > kDelta * kDelta * kDelta ? root : t / (3 * kDelta * kDelta) + 4.0 / 29;
}

/// As many at once as a vector has lanes; where fewer are left, the last one fills them.
void srgb_to_lab(const Vec3* rgb, std::size_t count, Lab* colors) {
  for (std::size_t i = 0; i < count; i += kReals) {
    Real red, green, blue;
    for (std::size_t k = 0; k < kReals; ++k) {
      const Vec3& color = rgb[i + k < count ? i + k : count - 1];
      red[k] = color.x, green[k] = color.y, blue[k] = color.z;
    }
    const Real r = linear(red), g = linear(green), b = linear(blue);
    const Real fx = lab_curve((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
    const Real fy = lab_curve(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
    const Real fz = lab_curve((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
    const Real lightness = 116.0 * fy - 16.0, a_star = 500.0 * (fx - fy), b_star = 200.0 * (fy - fz);
    for (std::size_t k = 0; k < kReals && i + k < count; ++k) colors[i + k] = {lightness[k], a_star[k], b_star[k]};
  }
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
