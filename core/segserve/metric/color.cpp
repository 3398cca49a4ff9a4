#include "segserve/metric/color.hpp"

#include "segserve/math/elementary.hpp"
#include "segserve/metric/kernels/kernels.hpp"

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

}  // namespace

Lab srgb_to_lab(const Vec3& rgb) {
  const double r = linear(rgb.x), g = linear(rgb.y), b = linear(rgb.z);
  const double fx = lab_curve((0.4124564 * r + 0.3575761 * g + 0.1804375 * b) / 0.95047);
  const double fy = lab_curve(0.2126729 * r + 0.7151522 * g + 0.0721750 * b);
  const double fz = lab_curve((0.0193339 * r + 0.1191920 * g + 0.9503041 * b) / 1.08883);
  return {116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)};
}

double ciede2000(const Lab& p, const Lab& q) {
  const Lab colors[] = {p, q};
  const RegionEdge pair{0, 1};
  double difference = 0;
  metric_kernels().color_differences(colors, &pair, 1, &difference);
  return difference;
}

}  // namespace segserve
