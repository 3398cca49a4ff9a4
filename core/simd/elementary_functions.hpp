// SPDX-License-Identifier: Apache-2.0
//
// Elementary functions made of the operations of IEEE 754 and of integers alone, so that they give the same bits on
// every CPU. The one source of both math::exp and its like (core/math/elementary.hpp, which gives ranges and errors)
// and of those that kernels compute in every lane: `Number` is double or Doubles.
//
// The rules for kernels in simd_vectors.hpp hold here, too.
#pragma once

#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_SIMD_TARGET {
namespace {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180;
inline constexpr double kLn2High = 6.93147180369123816490e-01;  // the upper 32 bits of ln 2, and the rest
inline constexpr double kLn2Low = 1.90821492927058770002e-10;
inline constexpr double kHalfPiHigh = 1.57079632673412561417e+00;  // likewise of pi / 2
inline constexpr double kHalfPiLow = 6.07710050650619224932e-11;

/// Integers of as many bits and lanes as a Number has.
template <typename Number>
struct IntegersOf;
template <>
struct IntegersOf<double> {
  using Signed = std::int64_t;
  using Unsigned = std::uint64_t;
};
template <>
struct IntegersOf<Doubles> {
  using Signed = Int64s;
  using Unsigned = std::uint64_t __attribute__((vector_size(kVectorBytes)));
};
template <typename Number>
using SignedOf = typename IntegersOf<Number>::Signed;

template <typename To, typename From>
SEGSERVE_INLINE To bits_as(From from) {
  return __builtin_bit_cast(To, from);
}

template <typename Number>
SEGSERVE_INLINE Number broadcast(double value) {
  return value - Number{};
}

template <typename Number>
SEGSERVE_INLINE Number absolute(Number x) {
  return bits_as<Number>(bits_as<SignedOf<Number>>(x) & 0x7fffffffffffffffLL);
}

/// The coefficients of a power series.
template <std::size_t N>
struct Series {
  double coefficient[N];
};

/// 1, 1/3, 1/5, ... with alternating signs if `sign` is -1: the series of artanh and arctan in x^2.
template <std::size_t N>
constexpr Series<N> odd_reciprocals(double sign) {
  Series<N> series{};
  double s = 1;
  for (std::size_t i = 0; i < N; ++i, s *= sign) series.coefficient[i] = s / static_cast<double>(2 * i + 1);
  return series;
}

/// 1/k! for k = first, first + step, ... with alternating signs if `sign` is -1.
template <std::size_t N>
constexpr Series<N> reciprocal_factorials(int first, int step, double sign) {
  Series<N> series{};
  double factorial = 1;
  for (int k = 2; k <= first; ++k) factorial *= k;
  double s = 1;
  int k = first;
  for (std::size_t i = 0; i < N; ++i, s *= sign) {
    series.coefficient[i] = s / factorial;
    for (int next = k + step; k < next;) factorial *= ++k;
  }
  return series;
}

/// The sum of coefficient(i) x^i for i < n by Horner's rule. The coefficients may differ between lanes.
template <std::size_t n, typename Coefficient, typename Number>
SEGSERVE_INLINE Number horner(const Coefficient& coefficient, Number x, Number sum = Number{}) {
  if constexpr (n == 0) {
    return sum;
  } else {
    return horner<n - 1>(coefficient, x, sum * x + coefficient(n - 1));
  }
}

template <std::size_t N, typename Number>
SEGSERVE_INLINE Number horner(const Series<N>& series, Number x) {
  return horner<N>([&](std::size_t i) SEGSERVE_INLINE_LAMBDA { return broadcast<Number>(series.coefficient[i]); }, x);
}

/// A whole number, as such and as an integer.
template <typename Number>
struct Whole {
  Number value;
  SignedOf<Number> integer;
};

/// x rounded to a whole number, halves away from zero; |x| < 2^50. Adding a large number and subtracting it again
/// rounds, and the sum has the integer in its lowest bits. SSE2 has no conversion of two doubles to 64-bit integers.
template <typename Number>
SEGSERVE_INLINE Whole<Number> rounded(Number x) {
  using Signed = SignedOf<Number>;
  const Number large = broadcast<Number>(6755399441055744.0);  // 1.5 * 2^52
  const Number y = x < 0.0 ? x - 0.5 : x + 0.5;
  const Number near = (y + large) - large;
  const Number whole = x < 0.0 ? (near < y ? near + 1.0 : near) : (near > y ? near - 1.0 : near);  // towards zero
  return {whole, bits_as<Signed>(whole + large) - bits_as<Signed>(large)};
}

/// Natural logarithm of positive, normal numbers. x = 2^e m with m in [sqrt(1/2), sqrt(2)), and
/// ln m = 2 artanh((m - 1) / (m + 1)).
template <typename Number>
SEGSERVE_INLINE Number ln(Number x) {
  using Signed = SignedOf<Number>;
  static constexpr Series kSeries = odd_reciprocals<12>(1.0);
  constexpr std::int64_t kSqrtHalf = 0x3fe6a09e667f3bcdLL;
  const Signed shifted = bits_as<Signed>(x) - kSqrtHalf;
  // e + 1024 is not negative. In the low bits of 2^52 it becomes a double by a subtraction.
  const auto biased = bits_as<typename IntegersOf<Number>::Unsigned>(shifted + (1024LL << 52)) >> 52;
  const Number exponent = bits_as<Number>(biased | 0x4330000000000000ULL) - (4503599627370496.0 + 1024);
  const Number m = bits_as<Number>((shifted & 0x000fffffffffffffLL) + kSqrtHalf);
  const Number s = (m - 1.0) / (m + 1.0);
  return exponent * kLn2High + (2.0 * s * horner(kSeries, s * s) + exponent * kLn2Low);
}

/// x = n ln 2 + r with |r| <= ln 2 / 2, and e^x = 2^n e^r.
template <typename Number>
SEGSERVE_INLINE Number exp(Number x) {
  static constexpr Series kSeries = reciprocal_factorials<15>(0, 1, 1.0);
  const Whole<Number> n = rounded(x / (kLn2High + kLn2Low));
  const Number r = (x - n.value * kLn2High) - n.value * kLn2Low;
  return horner(kSeries, r) * bits_as<Number>((n.integer + 1023) << 52);
}

/// x^y of positive, normal x.
template <typename Number>
SEGSERVE_INLINE Number pow(Number x, double y) {
  return exp(y * ln(x));
}

SEGSERVE_INLINE std::int64_t divided_by_3(std::int64_t n) { return n / 3; }
SEGSERVE_INLINE Int64s divided_by_3(Int64s n) {
  for (std::size_t i = 0; i < kDoubleLanes; ++i) n[i] /= 3;
  return n;
}

/// Cube root of positive, normal numbers. A third of the exponent is right to 5 %; each step of Halley's method
/// triples the number of right digits.
template <typename Number>
SEGSERVE_INLINE Number cbrt(Number x) {
  Number root = bits_as<Number>(divided_by_3(bits_as<SignedOf<Number>>(x)) + 0x2a9f7893782da1ceLL);
  for (int step = 0; step < 4; ++step) {
    const Number cube = root * root * root;
    root *= (cube + 2.0 * x) / (2.0 * cube + x);
  }
  return root;
}

/// Sine of x + quarters pi / 2. x = n pi / 2 + r with r in [-pi / 4, pi / 4]; n + quarters, modulo 4, says whether the
/// series of sine or that of cosine gives the result, and its sign.
template <int quarters, typename Number>
SEGSERVE_INLINE Number shifted_sin(Number x) {
  using Signed = SignedOf<Number>;
  static constexpr Series kSine = reciprocal_factorials<10>(1, 2, -1.0);
  static constexpr Series kCosine = reciprocal_factorials<10>(0, 2, -1.0);
  const Whole<Number> n = rounded(x * (2 / kPi));
  const Number r = (x - n.value * kHalfPiHigh) - n.value * kHalfPiLow;
  const Signed quadrant = n.integer + quarters;
  const auto odd = (quadrant & 1) != 0;
  const auto coefficient = [&](std::size_t i) SEGSERVE_INLINE_LAMBDA {
    return odd ? broadcast<Number>(kCosine.coefficient[i]) : broadcast<Number>(kSine.coefficient[i]);
  };
  const Number without_sign = (odd ? broadcast<Number>(1.0) : r) * horner<10>(coefficient, r * r);
  return bits_as<Number>(bits_as<Signed>(without_sign) ^ ((quadrant & 2) << 62));
}
template <typename Number>
SEGSERVE_INLINE Number sin(Number x) {
  return shifted_sin<0>(x);
}
template <typename Number>
SEGSERVE_INLINE Number cos(Number x) {
  return shifted_sin<1>(x);
}

/// Angle of (x, y) in (-pi, pi]; 0 for the origin. The angle to the nearer axis is that of t in [0, 1]. It is halved,
/// by tan(a / 2) = t / (1 + sqrt(1 + t^2)), so that the series is short.
template <typename Number>
SEGSERVE_INLINE Number atan2(Number y, Number x) {
  static constexpr Series kSeries = odd_reciprocals<22>(-1.0);
  const Number ax = x < 0.0 ? -x : x;
  const Number ay = y < 0.0 ? -y : y;
  const auto steep = ay > ax;
  const Number t = (steep ? ax : ay) / (steep ? ay : ax);
  const Number h = t / (1.0 + square_root(1.0 + t * t));
  const Number flat_angle = 2.0 * h * horner(kSeries, h * h);
  Number angle = steep ? kPi / 2 - flat_angle : flat_angle;
  angle = x < 0.0 ? kPi - angle : angle;
  angle = y < 0.0 ? -angle : angle;
  return ((ax == 0.0) & (ay == 0.0)) ? Number{} : angle;
}

}  // namespace
}  // namespace segserve::SEGSERVE_SIMD_TARGET
