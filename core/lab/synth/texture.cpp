// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/lab/synth/value_noise.hpp"

namespace segserve::synth {
namespace {

Vec3 wood(const Texture& t, double u, double v) {
  const double along = t.across ? v : u;
  const double over = t.across ? u : v;
  const double grain = fractal_noise(along / (22 * t.scale), over / t.scale, t.seed);
  const double fiber = value_noise(along / (8 * t.scale), over / (0.12 * t.scale), t.seed + 7);
  const double broad = value_noise(along / (60 * t.scale), over / (9 * t.scale), t.seed + 9);
  return lerp(t.base, t.second, std::clamp(0.55 * grain + 0.2 * fiber + 0.25 * broad, 0.0, 1.0));
}

/// Rows of words: the hash of a cell decides whether it is ink or a gap.
bool text(double u, double v, double row, std::uint64_t seed) {
  const double line = std::floor(v / row);
  if (v / row - line > 0.55) return false;
  const auto j = static_cast<std::int64_t>(line);
  const auto cell = static_cast<std::int64_t>(std::floor(u / (0.8 * row)));
  return lattice_hash(cell, j, seed) % 5 != 0 && lattice_hash(0, j, seed + 1) % 6 != 0;
}

/// All sides of a package share colors and bands. Title, picture and text differ from side to side.
Vec3 print(const Texture& t, const Surface& s) {
  const std::uint64_t side = mix(t.seed + static_cast<std::uint64_t>(s.face) * 101);
  const double u = s.u / s.width;
  const double v = s.v / s.height;
  const bool large = s.width > 0.09 && s.height > 0.07;
  const double band = 0.55 + 0.25 * unit_interval(mix(t.seed + 3));
  const double tilt = 0.25 * (unit_interval(mix(t.seed + 4)) - 0.5);
  const double height = v + tilt * (u - 0.5);
  Vec3 color = height > band && height < band + 0.17 ? t.second : t.base;
  if (height > band + 0.03 && height < band + 0.14 && u > 0.12 && u < 0.88) {
    if (text(s.u, (height - band - 0.03) * s.height, 0.11 * s.height, side)) color = {0.95, 0.94, 0.9};
  }
  const double cu = 0.3 + 0.4 * unit_interval(side);
  const double du = (u - cu) / 0.26;
  const double dv = (v - 0.33) / 0.19;
  if (large && du * du + dv * dv < 1) {
    const double picture = fractal_noise(s.u / 0.018, s.v / 0.018, side);
    return lerp(t.third, {0.9, 0.82, 0.6}, std::clamp(2.2 * picture - 0.6, 0.0, 1.0));
  }
  if (v > 0.06 && v < band - 0.12 && u > 0.08 && u < 0.92 && text(s.u, s.v, 0.0085, side)) {
    return lerp(color, dot(color, {1, 1, 1}) > 1.4 ? Vec3{0.12, 0.1, 0.14} : Vec3{0.92, 0.92, 0.9}, 0.75);
  }
  return color;
}

bool odd(double value) { return static_cast<std::int64_t>(std::floor(value)) % 2 != 0; }

Vec3 pattern(const Texture& t, const Surface& s) {
  const double along = t.across ? s.u : s.v;
  switch (t.kind) {
    case TextureKind::kPlain:
      return t.base;
    case TextureKind::kStripes:
      return odd(along / t.scale) ? t.second : t.base;
    case TextureKind::kChecks:
      return odd(s.u / t.scale) != odd(s.v / t.scale) ? t.second : t.base;
    case TextureKind::kSpeckle: {
      const double n = value_noise(s.u / (0.35 * t.scale), s.v / (0.35 * t.scale), t.seed);
      return lerp(t.base, n > 0.72 ? t.second : t.third, std::clamp(5 * std::abs(n - 0.62) - 0.4, 0.0, 1.0));
    }
    case TextureKind::kWood:
      return wood(t, s.u, s.v);
    case TextureKind::kPrint:
      return print(t, s);
  }
  return t.base;
}

double jitter(double value, double amount, Random& random) {
  return std::clamp(value + random.uniform(-amount, amount), 0.02, 0.98);
}

}  // namespace

Vec3 color_at(const Texture& texture, const Surface& surface) {
  // Large surfaces have less dirt, in broader patches.
  const bool large = surface.width > 0.4 || surface.height > 0.4;
  const double extent = large ? 0.35 : 0.05;
  const double depth = large ? 0.05 : 0.1;
  const double dirt = 1 + depth * (value_noise(surface.u / extent, surface.v / extent, texture.seed + 11) - 0.5);
  return dirt * pattern(texture, surface);
}

Vec3 random_color(Random& random) {
  static constexpr std::array<Vec3, 18> kPalette{{
      {0.78, 0.13, 0.12},
      {0.86, 0.46, 0.11},
      {0.90, 0.76, 0.22},
      {0.23, 0.50, 0.22},
      {0.55, 0.68, 0.28},
      {0.12, 0.32, 0.62},
      {0.33, 0.60, 0.80},
      {0.18, 0.20, 0.40},
      {0.45, 0.20, 0.46},
      {0.84, 0.52, 0.58},
      {0.90, 0.89, 0.86},
      {0.84, 0.80, 0.68},
      {0.62, 0.62, 0.62},
      {0.24, 0.24, 0.26},
      {0.45, 0.29, 0.17},
      {0.72, 0.55, 0.37},
      {0.16, 0.45, 0.44},
      {0.55, 0.10, 0.17},
  }};
  const Vec3& color = kPalette[random.below(kPalette.size())];
  const double light = random.uniform(-0.06, 0.06);
  return {jitter(color.x + light, 0.04, random), jitter(color.y + light, 0.04, random),
          jitter(color.z + light, 0.04, random)};
}

Texture random_texture(TextureKind kind, Random& random) {
  Texture texture{.kind = kind, .base = random_color(random)};
  const auto differs = [](const Vec3& a, const Vec3& b) { return norm(a - b) > 0.35; };
  do texture.second = random_color(random);
  while (!differs(texture.base, texture.second));
  do texture.third = random_color(random);
  while (!differs(texture.base, texture.third));
  texture.scale = random.uniform(0.008, 0.03);
  texture.across = random.chance(0.5);
  texture.seed = random.bits();
  return texture;
}

Texture random_texture(Random& random) {
  static constexpr std::array<TextureKind, 8> kKinds{TextureKind::kPlain,  TextureKind::kPlain,   TextureKind::kStripes,
                                                     TextureKind::kChecks, TextureKind::kSpeckle, TextureKind::kPrint,
                                                     TextureKind::kPrint,  TextureKind::kPlain};
  return random_texture(kKinds[random.below(kKinds.size())], random);
}

}  // namespace segserve::synth
