// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "core/lab/synth/shape.hpp"
#include "core/math/random.hpp"
#include "core/math/vec3.hpp"

namespace segserve::synth {

enum class TextureKind {
  kPlain,    ///< One color with a little dirt.
  kStripes,  ///< Around or along the patch.
  kChecks,
  kSpeckle,  ///< Stone, cork, patterned porcelain.
  kWood,
  kPrint,  ///< A printed package: bands, a picture, a title, lines of text.
};

/// A procedural texture. Colors are sRGB, 0 to 1 in each channel (x red, y green, z blue).
struct Texture {
  TextureKind kind = TextureKind::kPlain;
  Vec3 base{}, second{}, third{};
  double scale = 0.02;  ///< Width of stripes, checks and grain, in meters.
  bool across = false;  ///< Stripes and grain run along v instead of u.
  std::uint64_t seed = 0;
};

/// The color of a point of the surface.
Vec3 color_at(const Texture& texture, const Surface& surface);

/// A random color of household things: saturated, pastel, white, gray or brown.
Vec3 random_color(Random& random);

/// A random texture of this kind. Its second and third color differ from its first.
Texture random_texture(TextureKind kind, Random& random);

/// A random texture of a kind that fits manufactured objects.
Texture random_texture(Random& random);

}  // namespace segserve::synth
