#include "segserve/metric/color.hpp"

#include <cmath>

#include "segserve/math/elementary.hpp"

namespace segserve {
namespace {

/// The inverse of sRGB's transfer curve; channel 0..255, result 0..1.
double linear(double channel) {
  const double c = channel / 255;
  return c <= 0.04045 ? c / 12.92 : math::pow((c + 0.055) / 1.055, 2.4);
}

/// f of CIE 1976 L*a*b*: the cube root, with a straight line near zero.
double lab_curve(double t) {
  constexpr double kDelta = 6.0 / 29;
  return t > kDelta * kDelta * kDelta ? math::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
}

/// sqrt(c^7 / (c^7 + 25^7))
double chroma_seventh(double c) {
  const double c2 = c * c;
  const double c7 = c2 * c2 * c2 * c;
  return std::sqrt(c7 / (c7 + 6103515625.0));
}

/// Hue angle in [0, 2 pi); 0 for grey.
double hue(double a, double b) {
  const double h = math::atan2(b, a);
  return h < 0 ? h + 2 * math::kPi : h;
}

struct HuePair {
  double difference, mean;  // radians; sensible for greys, too
};

HuePair compare_hues(double h1, double h2, bool grey) {
  if (grey) return {0, h1 + h2};
  const double d = h2 - h1;
  const double sum = h1 + h2;
  // Opposite hues are pi apart up to rounding; the formula is discontinuous just beyond.
  if (std::fabs(d) <= math::kPi + 1e-12) return {d, sum / 2};
  return {d > 0 ? d - 2 * math::kPi : d + 2 * math::kPi,
          sum < 2 * math::kPi ? sum / 2 + math::kPi : sum / 2 - math::kPi};
}

double square(double x) { return x * x; }

}  // namespace

Lab srgb_to_lab(const Vec3& rgb) {
  const double r = linear(rgb.x), g = linear(rgb.y), b = linear(rgb.z);
  const double fx = lab_curve((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
  const double fy = lab_curve(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
  const double fz = lab_curve((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
  return {116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)};
}

double ciede2000(const Lab& p, const Lab& q) {
  const double mean_chroma = (std::sqrt(p.a * p.a + p.b * p.b) + std::sqrt(q.a * q.a + q.b * q.b)) / 2;
  const double g = 0.5 * (1 - chroma_seventh(mean_chroma));  // eq. 4: stretches a* near grey
  const double a1 = (1 + g) * p.a, a2 = (1 + g) * q.a;
  const double c1 = std::sqrt(a1 * a1 + p.b * p.b), c2 = std::sqrt(a2 * a2 + q.b * q.b);
  const HuePair h = compare_hues(hue(a1, p.b), hue(a2, q.b), c1 * c2 == 0);

  const double dl = q.l - p.l;
  const double dc = c2 - c1;
  const double dh = 2 * std::sqrt(c1 * c2) * math::sin(h.difference / 2);

  const double l = (p.l + q.l) / 2;
  const double c = (c1 + c2) / 2;
  constexpr double kDegree = math::kDegree;
  const double t = 1 - 0.17 * math::cos(h.mean - 30 * kDegree) + 0.24 * math::cos(2 * h.mean) +
                   0.32 * math::cos(3 * h.mean + 6 * kDegree) - 0.20 * math::cos(4 * h.mean - 63 * kDegree);
  const double sl = 1 + 0.015 * square(l - 50) / std::sqrt(20 + square(l - 50));
  const double sc = 1 + 0.045 * c;
  const double sh = 1 + 0.015 * c * t;
  const double whole = square(dl / sl) + square(dc / sc) + square(dh / sh);
  // The rotation of blue hues: elsewhere it is lost in rounding, and so is its exponential spared.
  const double from_blue = square((h.mean / kDegree - 275) / 25);
  if (from_blue > 40) return std::sqrt(whole);
  const double rotation = 30 * kDegree * math::exp(-from_blue);
  const double rt = -2 * chroma_seventh(c) * math::sin(2 * rotation);
  return std::sqrt(whole + rt * (dc / sc) * (dh / sh));
}

}  // namespace segserve
