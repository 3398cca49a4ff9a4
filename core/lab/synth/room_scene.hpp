// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/lab/synth/lighting.hpp"
#include "core/lab/synth/pinhole_camera.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

/// A furnished room; z = 0 is the floor (label 1), its walls have labels 2 to 5, and it has no ceiling.
struct RoomScene {
  World world;
  std::vector<Camera> views;  ///< The cameras that scan the room; the scan sets the size of their images.
  Vec3 lamp;                  ///< Its position.
  double half_x = 0, half_y = 0;
};

RoomScene arrange_room(const RoomOptions& options);

/// Closes the room above, with label 6.
void add_ceiling(RoomScene& room);

}  // namespace segserve::synth
