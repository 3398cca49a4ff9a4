#pragma once

#include <cstdint>
#include <vector>

#include "core/lab/synth/pinhole_camera.hpp"
#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

/// What a pixel sees first.
struct Hit {
  static constexpr std::uint32_t kNothing = 0xFFFFFFFFU;
  std::uint32_t solid = kNothing;  ///< index in the world
  double depth = 0;                ///< along the optical axis, metres
  int face = 0;

  bool any() const { return solid != kNothing; }
};

/// Casts rays of one camera. The image is divided into tiles that know which solids can appear in
/// them, nearest first, so that a ray tests few solids however many there are.
class RayCaster {
 public:
  /// The world must outlive the caster. Nothing beyond `range` metres of depth is seen.
  RayCaster(const World& world, const Camera& camera, double range = 1e30);

  /// The first hit of the ray through (u, v), which must be within the image.
  Hit cast(double u, double v) const;

  Vec3 world_point(double u, double v, double depth) const;
  /// The surface at a hit, its normal in world coordinates.
  Surface surface(double u, double v, const Hit& hit) const;
  const Camera& camera() const { return camera_; }

 private:
  // A solid as this camera sees it: rays need no transformation but a sum of three vectors.
  struct Candidate {
    Vec3 origin;              // the camera in the solid's frame
    Vec3 right, down, ahead;  // the camera's axes in the solid's frame
    Vec3 center;              // bounding sphere in the camera's frame
    double tangent = 0;       // |center|^2 - radius^2
    double nearest = 0;       // least depth of the sphere
  };
  void enter(std::uint32_t solid);

  const World& world_;
  Camera camera_;
  double range_;
  std::uint32_t tiles_across_;
  std::vector<Candidate> candidates_;
  std::vector<std::vector<std::uint32_t>> tiles_;
};

}  // namespace segserve::synth
