#pragma once

#include <bit>
#include <cstdint>

// Elementary functions out of +, -, *, / and integer operations alone. libm differs between CPUs
// and versions; these give the same bits everywhere (IEEE 754, no contraction), so that labels do.
// Errors are within 4 units in the last place on the ranges that colours and geometry need.

namespace segserve::math {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180;

/// Natural logarithm; x must be positive and normal.
double ln(double x);

/// e^x for |x| <= 700.
double exp(double x);

/// x^y for x > 0.
double pow(double x, double y);

/// Cube root; x must be positive and normal.
double cbrt(double x);

/// Sine and cosine for |x| <= 1000.
double sin(double x);
double cos(double x);

/// Angle of (x, y) in (-pi, pi]; 0 for the origin.
double atan2(double y, double x);

/// Natural logarithm in single precision, branch-free so that loops over it vectorise; relative
/// error below 3e-7. x must be positive and normal.
inline float ln(float x) {
  // x = m 2^e with m in [sqrt(1/2), sqrt(2)), then the series of 2 artanh((m - 1) / (m + 1)).
  constexpr std::uint32_t kSqrtHalf = 0x3f3504f3U;
  const std::uint32_t shifted = std::bit_cast<std::uint32_t>(x) - kSqrtHalf;
  const auto exponent = static_cast<float>(static_cast<std::int32_t>(shifted) >> 23);
  const auto m = std::bit_cast<float>((shifted & 0x007fffffU) + kSqrtHalf);
  const float s = (m - 1.0F) / (m + 1.0F);
  const float q = s * s;
  const float series = 2.0F + q * (2.0F / 3 + q * (2.0F / 5 + q * (2.0F / 7 + q * (2.0F / 9))));
  return exponent * 0.693147181F + s * series;
}

/// Largest integer <= x, for |x| < 2^31, without a libm call.
template <typename Real>
std::int32_t floor_to_int(Real x) {
  const auto truncated = static_cast<std::int32_t>(x);
  return truncated - static_cast<std::int32_t>(x < static_cast<Real>(truncated));
}

/// e^x in single precision for -80 <= x <= 80, branch-free as well; relative error below 4e-7.
inline float exp(float x) {
  // x = n ln 2 + r with |r| <= ln 2 / 2, then Taylor's series of e^r times 2^n.
  const std::int32_t n = floor_to_int(x * 1.44269504F + 0.5F);
  const auto m = static_cast<float>(n);
  const float r = (x - m * 0.693359375F) - m * -2.12194440e-4F;
  const float series =
      1.0F + r * (1.0F + r * (1.0F / 2 + r * (1.0F / 6 + r * (1.0F / 24 + r * (1.0F / 120 + r * (1.0F / 720))))));
  return series * std::bit_cast<float>((n + 127) << 23);
}

}  // namespace segserve::math
