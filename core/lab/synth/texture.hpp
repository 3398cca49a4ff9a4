#pragma once

#include <cstdint>

#include "core/lab/synth/shape.hpp"
#include "core/math/random.hpp"
#include "core/math/vec3.hpp"

namespace segserve::synth {

enum class TextureKind {
  kPlain,    ///< one colour with a hint of dirt
  kStripes,  ///< around or along the patch
  kChecks,
  kSpeckle,  ///< stone, cork, patterned porcelain
  kWood,
  kPrint,  ///< a printed package: bands, a picture, a title, lines of text
};

/// A procedural colour of surfaces. Colours are sRGB, 0 to 1 a channel (x red, y green, z blue).
struct Texture {
  TextureKind kind = TextureKind::kPlain;
  Vec3 base{}, second{}, third{};
  double scale = 0.02;  ///< metres: width of stripes, checks, grain
  bool across = false;  ///< stripes and grain run along v instead of u
  std::uint64_t seed = 0;
};

/// The colour of a point of the surface.
Vec3 color_at(const Texture& texture, const Surface& surface);

/// A colour of household things: saturated prints, pastel porcelain, white, grey, brown.
Vec3 random_color(Random& random);

/// A texture of the kind with colours that differ from one another.
Texture random_texture(TextureKind kind, Random& random);

/// One of the kinds that fit manufactured objects.
Texture random_texture(Random& random);

}  // namespace segserve::synth
