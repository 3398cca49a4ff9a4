// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math/vec3.hpp"
#include "core/tracking/rigid_motion.hpp"
#include "segserve/tracking.hpp"

namespace segserve::tracking {

/// A track where it is expected in the frame at hand, if it rests in the world.
struct PredictedTrack {
  struct Signature {
    Vec3 place, color;
  };

  Vec3 center, color;
  std::array<Vec3, 3> axes;            ///< of its box
  std::array<double, 3> half_extents;  ///< of its box, meters
  Vec3 velocity;                       ///< m/s
  double area = 0;                     ///< square meters
  bool is_lost = false;
  bool is_trusted = false;          ///< whether it may differ from the cut
  bool is_established = false;      ///< whether it was seen long enough to compete while it is out of sight
  std::uint32_t frames_unseen = 1;  ///< since it was seen last
  std::vector<Signature> signatures;
  Vec3 shift;  ///< from the places above to where it was found (find_shifts)

  double volume() const { return half_extents[0] * half_extents[1] * half_extents[2]; }
};

std::vector<PredictedTrack> predict(const TrackState& state, const RigidMotion& motion);

}  // namespace segserve::tracking
