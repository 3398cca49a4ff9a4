// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/lab/synth/ray_caster.hpp"

namespace segserve::synth {

/// Soft shadows from the depth image that a light sees (percentage-closer filtering).
class ShadowMap {
 public:
  /// The light at `from` covers a cone of `radius` meters around `to`; points outside of it are lit. The world is not
  /// needed afterward.
  ShadowMap(const World& world, const Vec3& from, const Vec3& to, double radius);

  /// The share of the light, [0, 1], that reaches a point of a surface with this unit normal.
  double lit_share(const Vec3& point, const Vec3& normal) const;

 private:
  Camera camera_;
  std::vector<float> depth_;
};

/// Diffuse light of a room: a lamp, a window at the side, and the light that the walls reflect.
struct Lighting {
  Vec3 lamp{-0.3, -0.4, 0.85};                    ///< Unit direction to the lamp.
  Vec3 window{0.8, 0.3, 0.5};                     ///< Unit direction to the window.
  double ambient = 0.45, key = 0.5, fill = 0.22;  ///< Strengths of the walls, the lamp and the window.

  /// The color (sRGB, 0 to 1) that the camera sees of a surface color. Light is added linearly; sRGB is taken as the
  /// square root of linear light.
  Vec3 shade(const Vec3& color, const Vec3& normal, double lit) const;
};

}  // namespace segserve::synth
