// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/lab/synth/scene.hpp"
#include "segserve/rigid_transform.hpp"

namespace segserve::synth {

/// A table that several cameras see at the same time.
struct RigView {
  /// As make_tabletop makes it, but that all visible parts of an object have the same label in all views, and that
  /// there is no room around the table.
  SyntheticScene scene;
  RigidTransform pose;  ///< From the frame of the camera to that of the table, in which z is up.
};

/// The views of `cameras` cameras, which stand around the table at equal angles, at the height and distance of that of
/// make_tabletop: two of them are opposite each other. The first of them stands where that one does. INVALID_ARGUMENT
/// that names every option out of its range; there may be 1 to 16 cameras, and the option all_finite is not possible.
absl::StatusOr<std::vector<RigView>> make_tabletop_rig(const SceneOptions& options, std::uint32_t cameras);

}  // namespace segserve::synth
