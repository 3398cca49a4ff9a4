// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/lab/synth/lighting.hpp"
#include "core/lab/synth/pinhole_camera.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

/// Labels of the surfaces that support or surround the objects.
enum SupportLabel : std::uint32_t {
  kTable = 1,
  kFloor = 2,
  kBackWall = 3,
  kSideWall = 4,
  kOtherWall = 5,
  kCabinet = 6
};

/// A table with objects on it, in a room. The top of the table is at z = 0.
struct TableScene {
  World world;
  Camera camera;
  Lighting lighting;
};

TableScene arrange_table(const SceneOptions& options);

}  // namespace segserve::synth
