// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "core/lab/synth/pinhole_camera.hpp"
#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

/// The first surface that a ray meets.
struct Hit {
  static constexpr std::uint32_t kNothing = 0xFFFFFFFFU;
  std::uint32_t solid = kNothing;  ///< Index in the world.
  double depth = 0;                ///< Along the optical axis, in meters.
  int face = 0;

  bool exists() const { return solid != kNothing; }
};

/// Casts rays of one camera. The image is divided into tiles, each with a list of the solids that can appear in it,
/// nearest first, so that a ray tests few solids.
class RayCaster {
 public:
  /// The world must outlive the caster. Surfaces beyond a depth of `range` meters are not seen.
  RayCaster(const World& world, const Camera& camera, double range = 1e30);

  /// The first hit of the ray through the pixel (u, v), which must be within the image.
  Hit cast(double u, double v) const;

  Vec3 world_point(double u, double v, double depth) const;
  /// The surface at a hit; its normal is in world coordinates.
  Surface surface(double u, double v, const Hit& hit) const;
  const Camera& camera() const { return camera_; }

 private:
  // A solid in the camera's terms, so that a ray is transformed into its frame by a sum of three vectors.
  struct Candidate {
    Vec3 origin;                 // position of the camera in the solid's frame
    Vec3 right, down, ahead;     // the camera's axes in the solid's frame
    Vec3 center;                 // center of the bounding sphere in the camera's frame
    double squared_tangent = 0;  // squared length of the tangents from the camera to the sphere
    double nearest = 0;          // least depth of the sphere
  };
  /// Adds a solid to the lists of the tiles in which it can appear.
  void add_to_tiles(std::uint32_t solid);

  const World& world_;
  Camera camera_;
  double range_;
  std::uint32_t tiles_across_;
  std::vector<Candidate> candidates_;
  std::vector<std::vector<std::uint32_t>> tiles_;
};

}  // namespace segserve::synth
