#include "core/math/elementary.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace segserve::math {
namespace {

constexpr double kLn2High = 6.93147180369123816490e-01;  // the upper 32 bits of ln 2, and the rest
constexpr double kLn2Low = 1.90821492927058770002e-10;
constexpr double kHalfPiHigh = 1.57079632673412561417e+00;  // likewise of pi / 2
constexpr double kHalfPiLow = 6.07710050650619224932e-11;

std::int64_t round_to_int(double x) { return static_cast<std::int64_t>(x + std::copysign(0.5, x)); }

template <std::size_t N>
double horner(const std::array<double, N>& coefficients, double x) {
  double sum = 0;
  for (std::size_t i = N; i-- > 0;) sum = sum * x + coefficients[i];
  return sum;
}

/// 1, 1/3, 1/5, .. (alternating if `sign` is -1): the series of artanh and arctan in x^2.
template <std::size_t N>
constexpr std::array<double, N> odd_reciprocals(double sign) {
  std::array<double, N> series{};
  double s = 1;
  for (std::size_t i = 0; i < N; ++i, s *= sign) series[i] = s / static_cast<double>(2 * i + 1);
  return series;
}

/// 1/k!, with steps of `step` from k = `first` on, alternating if `sign` is -1.
template <std::size_t N>
constexpr std::array<double, N> reciprocal_factorials(int first, int step, double sign) {
  std::array<double, N> series{};
  double factorial = 1;
  for (int k = 2; k <= first; ++k) factorial *= k;
  double s = 1;
  int k = first;
  for (std::size_t i = 0; i < N; ++i, s *= sign) {
    series[i] = s / factorial;
    for (int next = k + step; k < next;) factorial *= ++k;
  }
  return series;
}

struct Quadrant {
  int index;         // multiple of pi / 2 that was taken off, modulo 4
  double remainder;  // in [-pi/4, pi/4]
};

Quadrant reduce(double x) {
  const std::int64_t n = round_to_int(x * (2 / kPi));
  const auto d = static_cast<double>(n);
  return {static_cast<int>(n & 3), (x - d * kHalfPiHigh) - d * kHalfPiLow};
}

/// Sine of r plus `quarters` times pi / 2, for r in [-pi/4, pi/4]. Which series, and which sign, is looked up: branches
/// would be mispredicted for every other angle.
double sin_quarters(int quarters, double r) {
  static constexpr std::array kSeries = {reciprocal_factorials<10>(1, 2, -1.0),   // sine
                                         reciprocal_factorials<10>(0, 2, -1.0)};  // cosine
  static constexpr std::array kSign = {1.0, -1.0};
  const auto odd = static_cast<std::size_t>(quarters & 1);
  const std::array factor = {r, 1.0};
  return kSign[static_cast<std::size_t>(quarters >> 1 & 1)] * (factor[odd] * horner(kSeries[odd], r * r));
}

/// arctan on [0, 1]: halved once (tan(t/2) = t / (1 + sqrt(1 + t^2))) so that the series is short.
double atan_unit(double t) {
  static constexpr auto kSeries = odd_reciprocals<22>(-1.0);
  const double h = t / (1.0 + std::sqrt(1.0 + t * t));
  return 2.0 * h * horner(kSeries, h * h);
}

}  // namespace

double ln(double x) {
  static constexpr auto kSeries = odd_reciprocals<12>(1.0);
  constexpr std::uint64_t kSqrtHalf = 0x3fe6a09e667f3bcdULL;
  const std::uint64_t shifted = std::bit_cast<std::uint64_t>(x) - kSqrtHalf;
  const auto exponent = static_cast<double>(static_cast<std::int64_t>(shifted) >> 52);
  const auto m = std::bit_cast<double>((shifted & 0x000fffffffffffffULL) + kSqrtHalf);
  const double s = (m - 1) / (m + 1);
  return exponent * kLn2High + (2 * s * horner(kSeries, s * s) + exponent * kLn2Low);
}

double exp(double x) {
  static constexpr auto kSeries = reciprocal_factorials<15>(0, 1, 1.0);
  const std::int64_t n = round_to_int(x / (kLn2High + kLn2Low));
  const auto d = static_cast<double>(n);
  const double r = (x - d * kLn2High) - d * kLn2Low;
  return horner(kSeries, r) * std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52U);
}

double pow(double x, double y) { return exp(y * ln(x)); }

double cbrt(double x) {
  // A third of the exponent is right to 5 %; each Halley step triples the number of right digits.
  double root = std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) / 3 + 0x2a9f7893782da1ceULL);
  for (int step = 0; step < 4; ++step) {
    const double cube = root * root * root;
    root *= (cube + 2 * x) / (2 * cube + x);
  }
  return root;
}

double sin(double x) {
  const auto [index, r] = reduce(x);
  return sin_quarters(index, r);
}

double cos(double x) {
  const auto [index, r] = reduce(x);
  return sin_quarters(index + 1, r);
}

double atan2(double y, double x) {
  const double ax = x < 0 ? -x : x;
  const double ay = y < 0 ? -y : y;
  if (ax == 0 && ay == 0) return 0;
  const bool steep = ay > ax;
  const double unsteep = atan_unit((steep ? ax : ay) / (steep ? ay : ax));
  double angle = steep ? kPi / 2 - unsteep : unsteep;
  if (x < 0) angle = kPi - angle;
  return y < 0 ? -angle : angle;
}

}  // namespace segserve::math
