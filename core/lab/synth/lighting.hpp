#pragma once

#include <vector>

#include "core/lab/synth/ray_caster.hpp"

namespace segserve::synth {

/// Soft shadows: the depths a light sees, compared over a neighbourhood.
class ShadowMap {
 public:
  /// The light at `from` covers a cone about `to`; what lies outside is lit.
  /// The world is not needed afterwards.
  ShadowMap(const World& world, const Vec3& from, const Vec3& to, double radius);

  /// Share of the light that reaches a point of a surface with this normal, [0, 1].
  double lit(const Vec3& point, const Vec3& normal) const;

 private:
  Camera camera_;
  std::vector<float> depth_;
};

/// Diffuse light of a room: a lamp, a window from the side, and what the walls give back.
struct Lighting {
  Vec3 lamp{-0.3, -0.4, 0.85};  ///< unit direction to the lamp
  Vec3 window{0.8, 0.3, 0.5};   ///< unit direction to the window
  double ambient = 0.45, key = 0.5, fill = 0.22;

  /// What the camera records of a surface colour (sRGB): light goes in linearly, and sRGB is taken
  /// as the square root of it.
  Vec3 shade(const Vec3& color, const Vec3& normal, double lit) const;
};

}  // namespace segserve::synth
