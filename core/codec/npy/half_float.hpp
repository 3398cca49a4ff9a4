// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace segserve::codec {

/// A float of 16 bits (IEEE 754 binary16).
inline float half_value(std::uint16_t half) {
  const int exponent = (half >> 10U) & 0x1F, mantissa = half & 0x3FF;
  const float sign = (half & 0x8000U) != 0 ? -1.0F : 1.0F;
  if (exponent == 0x1F) return sign * (mantissa == 0 ? std::numeric_limits<float>::infinity() : std::nanf(""));
  if (exponent == 0) return sign * std::ldexp(static_cast<float>(mantissa), -24);
  return sign * std::ldexp(static_cast<float>(mantissa + 1024), exponent - 25);
}

}  // namespace segserve::codec
