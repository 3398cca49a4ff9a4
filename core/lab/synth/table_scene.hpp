#pragma once

#include "core/lab/synth/lighting.hpp"
#include "core/lab/synth/pinhole_camera.hpp"
#include "core/lab/synth/scene.hpp"
#include "core/lab/synth/solid.hpp"

namespace segserve::synth {

/// Labels of what supports or surrounds the objects.
enum SupportLabel : std::uint32_t {
  kTable = 1,
  kFloor = 2,
  kBackWall = 3,
  kSideWall = 4,
  kOtherWall = 5,
  kCabinet = 6
};

/// A table with objects on it, in a room; z = 0 is the table's top.
struct TableScene {
  World world;
  Camera camera;
  Lighting lighting;
};

TableScene arrange_table(const SceneOptions& options);

}  // namespace segserve::synth
