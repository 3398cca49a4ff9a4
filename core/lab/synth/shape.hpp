// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/lab/synth/geometry.hpp"

namespace segserve::synth {

/// Analytic solids in their own frame, in meters. All but box and ellipsoid stand on z = 0.
enum class ShapeKind {
  kBox,        ///< Half edges a, b, c around the origin.
  kEllipsoid,  ///< Semi-axes a, b, c around the origin.
  kFrustum,    ///< Radius a at z = 0 and b at z = c, closed (a = b: cylinder, b = 0: cone).
  kCup,        ///< Like a frustum, but open above; wall and floor are d thick.
  kTube,       ///< Like a cup, but open below, too.
  kBowl,       ///< Cap of a sphere of radius a up to the height b < 2 a, open above; its wall is d thick.
};

struct Shape {
  ShapeKind kind = ShapeKind::kBox;
  double a = 0, b = 0, c = 0, d = 0;
};

/// The point origin + t * direction, where a ray meets the surface patch `face` of a shape.
struct Crossing {
  double t = 0;
  int face = 0;
};

/// A point of a surface, as textures and lights need it.
struct Surface {
  Vec3 normal;          ///< Unit normal, outwards, in the frame of the shape.
  double u = 0, v = 0;  ///< Position on the patch, in meters.
  double width = 1;     ///< Extent of the patch along u, in meters.
  double height = 1;    ///< Extent of the patch along v, in meters.
  int face = 0;
};

/// Finds the first crossing with t_min < t < hit.t and stores it in `hit`; returns false if there is none. The ray is
/// in the frame of the shape; its direction may have any length.
bool intersect(const Shape& shape, const Vec3& origin, const Vec3& direction, double t_min, Crossing& hit);

/// The surface at a point of the given patch.
Surface surface_at(const Shape& shape, const Vec3& point, int face);

/// A sphere around the shape, in its frame.
struct Sphere {
  Vec3 center;
  double radius = 0;
};
Sphere bounding_sphere(const Shape& shape);

}  // namespace segserve::synth
