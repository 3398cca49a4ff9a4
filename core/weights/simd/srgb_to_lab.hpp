// SPDX-License-Identifier: Apache-2.0
// A kernel; see core/simd/simd_vectors.hpp. Converts several colors at once to CIE 1976 L*a*b*.
#pragma once

#include "core/simd/elementary_functions.hpp"
#include "core/weights/simd/weight_kernels.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

/// The inverse of the transfer curve of sRGB, from a channel in 0..255 to [0, 1].
SEGSERVE_INLINE Doubles linear(Doubles channel) {
  const Doubles c = channel / 255.0;
  const Doubles curved = pow((c + 0.055) / 1.055, 2.4);
  return c <= 0.04045 ? c / 12.92 : curved;
}

/// f of CIE 1976 L*a*b*: the cube root, or a straight line near zero.
SEGSERVE_INLINE Doubles lab_curve(Doubles t) {
  constexpr double kDelta = 6.0 / 29;
  const Doubles root = cbrt(t);
  return t > kDelta * kDelta * kDelta ? root : t / (3 * kDelta * kDelta) + 4.0 / 29;
}

/// Converts as many colors at once as a vector has lanes. Where fewer are left, the last one fills the lanes.
void srgb_to_lab(const Vec3* rgb, std::size_t count, Lab* colors) {
  for (std::size_t i = 0; i < count; i += kDoubleLanes) {
    Doubles red, green, blue;
    for (std::size_t k = 0; k < kDoubleLanes; ++k) {
      const Vec3& color = rgb[i + k < count ? i + k : count - 1];
      red[k] = color.x, green[k] = color.y, blue[k] = color.z;
    }
    const Doubles r = linear(red), g = linear(green), b = linear(blue);
    const Doubles fx = lab_curve((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
    const Doubles fy = lab_curve(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
    const Doubles fz = lab_curve((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
    const Doubles lightness = 116.0 * fy - 16.0, a_star = 500.0 * (fx - fy), b_star = 200.0 * (fy - fz);
    for (std::size_t k = 0; k < kDoubleLanes && i + k < count; ++k)
      colors[i + k] = {lightness[k], a_star[k], b_star[k]};
  }
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
