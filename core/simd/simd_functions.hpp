// The elementary functions of math/elementary.hpp with a number in each lane: the same operations in the same order,
// so the same bits. For kernels only; see core/simd/simd_vectors.hpp.
#pragma once

#include "core/simd/simd_vectors.hpp"

namespace segserve::SEGSERVE_KERNELS {
namespace {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180;

SEGSERVE_INLINE Real broadcast(double value) { return value - Real{}; }

SEGSERVE_INLINE Real absolute(Real x) {
  return reinterpret_cast<Real>(reinterpret_cast<RealMask>(x) & 0x7fffffffffffffffLL);
}

/// A series and its number of terms, for horner.
template <std::size_t N>
struct Series {
  double of[N];
};

/// The sum of a series from its term `n - 1` down to its first one; a term may be another one in each lane.
template <std::size_t n, typename Term>
SEGSERVE_INLINE Real horner(const Term& term, Real x, Real sum = Real{}) {
  if constexpr (n == 0) {
    return sum;
  } else {
    return horner<n - 1>(term, x, sum * x + term(n - 1));
  }
}

template <std::size_t N>
SEGSERVE_INLINE Real horner(const Series<N>& series, Real x) {
  return horner<N>([&](std::size_t i) SEGSERVE_INLINE_LAMBDA { return broadcast(series.of[i]); }, x);
}

/// 1, -1/3, 1/5, ..
template <std::size_t N>
constexpr Series<N> arctangent_series() {
  Series<N> series{};
  double s = 1;
  for (std::size_t i = 0; i < N; ++i, s *= -1.0) series.of[i] = s / static_cast<double>(2 * i + 1);
  return series;
}

/// 1/k!, with steps of `step` from k = `first` on, alternating if `sign` is -1.
template <std::size_t N>
constexpr Series<N> reciprocal_factorials(int first, int step, double sign) {
  Series<N> series{};
  double factorial = 1;
  for (int k = 2; k <= first; ++k) factorial *= k;
  double s = 1;
  int k = first;
  for (std::size_t i = 0; i < N; ++i, s *= sign) {
    series.of[i] = s / factorial;
    for (int next = k + step; k < next;) factorial *= ++k;
  }
  return series;
}

/// 1, 1/3, 1/5, ..
template <std::size_t N>
constexpr Series<N> artanh_series() {
  Series<N> series{};
  for (std::size_t i = 0; i < N; ++i) series.of[i] = 1 / static_cast<double>(2 * i + 1);
  return series;
}

/// A whole number, as such and in the low bits of integers.
struct Whole {
  Real value;
  RealMask bits;
};

/// x rounded to a whole number, halves away from zero; |x| < 2^50. Adding and taking off a large number rounds, and
/// leaves the integer in the lowest bits: all CPUs can do that with two doubles at once, unlike conversions.
SEGSERVE_INLINE Whole rounded(Real x) {
  const Real large = broadcast(6755399441055744.0);  // 1.5 * 2^52
  const Real y = x < 0.0 ? x - 0.5 : x + 0.5;
  const Real near = (y + large) - large;
  const Real beyond = x < 0.0 ? (near < y ? near + 1.0 : near) : (near > y ? near - 1.0 : near);  // towards zero
  return {beyond, reinterpret_cast<RealMask>(beyond + large) - reinterpret_cast<RealMask>(large)};
}

/// Of positive numbers.
SEGSERVE_INLINE Real logarithm(Real x) {
  static constexpr Series kSeries = artanh_series<12>();
  constexpr double kLn2High = 6.93147180369123816490e-01, kLn2Low = 1.90821492927058770002e-10;
  constexpr std::int64_t kSqrtHalf = 0x3fe6a09e667f3bcdLL;
  const RealMask shifted = reinterpret_cast<RealMask>(x) - kSqrtHalf;
  // In the low bits of 2^52, from where it becomes a number by a subtraction; 1024 more, so that it is not negative.
  using Words = std::uint64_t __attribute__((vector_size(kLaneBytes)));
  const Words biased = reinterpret_cast<Words>(shifted + (1024LL << 52)) >> 52;
  const Real exponent = reinterpret_cast<Real>(biased | 0x4330000000000000ULL) - (4503599627370496.0 + 1024);
  const Real m = reinterpret_cast<Real>((shifted & 0x000fffffffffffffLL) + kSqrtHalf);
  const Real s = (m - 1.0) / (m + 1.0);
  return exponent * kLn2High + (2.0 * s * horner(kSeries, s * s) + exponent * kLn2Low);
}

SEGSERVE_INLINE Real exponential(Real x) {
  static constexpr Series kSeries = reciprocal_factorials<15>(0, 1, 1.0);
  constexpr double kLn2High = 6.93147180369123816490e-01, kLn2Low = 1.90821492927058770002e-10;
  const Whole n = rounded(x / (kLn2High + kLn2Low));
  const Real r = (x - n.value * kLn2High) - n.value * kLn2Low;
  return horner(kSeries, r) * reinterpret_cast<Real>((n.bits + 1023) << 52);
}

/// x^y of positive x.
SEGSERVE_INLINE Real power(Real x, double y) { return exponential(y * logarithm(x)); }

/// Of positive numbers.
SEGSERVE_INLINE Real cube_root(Real x) {
  RealMask bits = reinterpret_cast<RealMask>(x);
  for (std::size_t i = 0; i < kReals; ++i) bits[i] /= 3;
  Real root = reinterpret_cast<Real>(bits + 0x2a9f7893782da1ceLL);
  for (int step = 0; step < 4; ++step) {
    const Real cube = root * root * root;
    root *= (cube + 2.0 * x) / (2.0 * cube + x);
  }
  return root;
}

/// Sine, or cosine if `quarters` is 1.
template <int quarters>
SEGSERVE_INLINE Real sine(Real x) {
  static constexpr Series kSine = reciprocal_factorials<10>(1, 2, -1.0);
  static constexpr Series kCosine = reciprocal_factorials<10>(0, 2, -1.0);
  constexpr double kHalfPiHigh = 1.57079632673412561417e+00, kHalfPiLow = 6.07710050650619224932e-11;
  const Whole n = rounded(x * (2 / kPi));
  const Real r = (x - n.value * kHalfPiHigh) - n.value * kHalfPiLow;
  const RealMask quadrant = n.bits + quarters;
  const RealMask odd = (quadrant & 1) != 0;
  const auto term = [&](std::size_t i)
                        SEGSERVE_INLINE_LAMBDA { return odd ? broadcast(kCosine.of[i]) : broadcast(kSine.of[i]); };
  const Real sum = horner<10>(term, r * r);
  const Real unsigned_sine = (odd ? broadcast(1.0) : r) * sum;
  return reinterpret_cast<Real>(reinterpret_cast<RealMask>(unsigned_sine) ^ ((quadrant & 2) << 62));
}
SEGSERVE_INLINE Real sin(Real x) { return sine<0>(x); }
SEGSERVE_INLINE Real cos(Real x) { return sine<1>(x); }

SEGSERVE_INLINE Real atan2(Real y, Real x) {
  static constexpr Series kSeries = arctangent_series<22>();
  const Real ax = x < 0.0 ? -x : x;
  const Real ay = y < 0.0 ? -y : y;
  const RealMask steep = ay > ax;
  const Real t = (steep ? ax : ay) / (steep ? ay : ax);
  const Real h = t / (1.0 + square_root(1.0 + t * t));
  const Real unsteep = 2.0 * h * horner(kSeries, h * h);
  Real angle = steep ? kPi / 2 - unsteep : unsteep;
  angle = x < 0.0 ? kPi - angle : angle;
  angle = y < 0.0 ? -angle : angle;
  return ((ax == 0.0) & (ay == 0.0)) ? Real{} : angle;
}

}  // namespace
}  // namespace segserve::SEGSERVE_KERNELS
