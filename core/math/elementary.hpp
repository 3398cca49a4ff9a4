// SPDX-License-Identifier: Apache-2.0
//
// Elementary functions that give the same bits on every CPU, so that labels are the same. Those of libm differ between
// CPUs and versions. Errors are within 4 units in the last place on the ranges that colors and geometry need.
#pragma once

#include <cstdint>

namespace segserve::math {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180;  ///< in radians

/// Natural logarithm; x must be positive and normal.
double ln(double x);

/// e^x for |x| <= 700.
double exp(double x);

/// x^y; x must be positive and normal.
double pow(double x, double y);

/// Cube root; x must be positive and normal.
double cbrt(double x);

/// Sine and cosine of an angle in radians, |x| <= 1000.
double sin(double x);
double cos(double x);

/// Angle of (x, y) in radians, in (-pi, pi]; 0 for the origin.
double atan2(double y, double x);

/// Largest integer <= x, for |x| < 2^31.
inline std::int32_t floor_to_int(double x) {
  const auto truncated = static_cast<std::int32_t>(x);
  return truncated - static_cast<std::int32_t>(x < static_cast<double>(truncated));
}

}  // namespace segserve::math
