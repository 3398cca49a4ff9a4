// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/lab/synth/arrangement.hpp"
#include "core/lab/synth/depth_raster.hpp"
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
  std::vector<Arrangement::Footprint> footprints;  ///< of the objects, the first of which has label kFirstObject
};

/// The label of the first object; those of the others follow in steps of kObjectStep.
inline constexpr std::uint32_t kFirstObject = 20, kObjectStep = 10;

/// The table and the objects, which cast shadows. Walls cast none, because the lamp may be behind one.
World shadow_casters(const World& world);

/// Removes the depth of everything but the table and the objects, because OSD's scenes have ground truth only there.
void remove_room(DepthImage& image);

TableScene arrange_table(const SceneOptions& options);

}  // namespace segserve::synth
