#pragma once

#include "core/lab/synth/geometry.hpp"

namespace segserve::synth {

/// Analytic solids, metres, in their own frame. All but box and ellipsoid stand on z = 0.
enum class ShapeKind {
  kBox,        ///< half edges a, b, c about the origin
  kEllipsoid,  ///< semi-axes a, b, c about the origin
  kFrustum,    ///< radius a at z = 0, b at z = c, closed (a = b: cylinder, b = 0: cone)
  kCup,        ///< the same, open above, wall and floor d thick
  kTube,       ///< the same, open above and below
  kBowl,       ///< cap of a sphere of radius a up to height b < 2 a, wall d thick, open above
};

struct Shape {
  ShapeKind kind = ShapeKind::kBox;
  double a = 0, b = 0, c = 0, d = 0;
};

/// Where a ray meets a shape: origin + t * direction, on the surface patch `face`.
struct Crossing {
  double t = 0;
  int face = 0;
};

/// What a texture and a light need to know about a point of the surface.
struct Surface {
  Vec3 normal;          ///< unit, outwards, in the shape's frame
  double u = 0, v = 0;  ///< position on the patch, metres
  double width = 1;     ///< extent of the patch along u, metres
  double height = 1;    ///< and along v
  int face = 0;
};

/// The first crossing with t_min < t < hit.t, which it stores in `hit`; false if there is none.
/// The ray is in the shape's frame; its direction may have any length.
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
