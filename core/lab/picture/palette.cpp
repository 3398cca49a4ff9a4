// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/lab/picture/picture.hpp"

namespace segserve::picture {
namespace {

using Rgb = std::array<double, 3>;

/// Converts Oklab (B. Ottosson, 2020) to linear light. Equal steps in Oklab look equal.
Rgb linear_from_oklab(double lightness, double a, double b) {
  const auto cube = [](double v) { return v * v * v; };
  const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
  const double m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
  const double s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
  return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
          -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
          -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

std::uint8_t srgb_byte(double linear) {
  const double v = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(v, 0.0, 1.0)));
}

/// The most colorful sRGB color of this lightness and hue, up to `chroma`.
std::uint32_t color_of(double lightness, double chroma, double hue) {
  constexpr int kSteps = 20;
  Rgb rgb{};
  for (int step = kSteps; step > 0; --step) {
    const double c = chroma * step / kSteps;
    rgb = linear_from_oklab(lightness, c * std::cos(hue), c * std::sin(hue));
    if (std::all_of(rgb.begin(), rgb.end(), [](double v) { return v >= 0.0 && v <= 1.0; })) break;
  }
  return pack_rgb(srgb_byte(rgb[0]), srgb_byte(rgb[1]), srgb_byte(rgb[2]));
}

double fraction(double v) { return v - std::floor(v); }

}  // namespace

std::uint32_t segment_color(std::uint32_t label) {
  if (label == 0) return 0x2E2E33;
  // Multiples of the golden ratio (for hues) and of the inverse of the plastic number (for lightness) fill their range
  // evenly for any run of labels, and never repeat together.
  constexpr double kPlastic = 0.5698402909980532;
  constexpr std::array<double, 3> kLightness{0.56, 0.70, 0.83};
  const double hue = fraction((std::numbers::phi - 1.0) * label + 0.05);
  const auto level = static_cast<std::size_t>(fraction(kPlastic * label) * kLightness.size());
  return color_of(kLightness[level], 0.17, 2.0 * std::numbers::pi * hue);
}

}  // namespace segserve::picture
