// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::eval {

/// Changes that make a scene harder to segment, applied in this order. Degraded scenes are the same bytes on every
/// machine.
struct Degradation {
  /// Factor on all coordinates, (0, 1000]. A larger scene is farther away in proportion.
  double scale = 1;
  /// Standard deviation of depth noise at 1 m in millimeters, [0, 1000]. As for a structured-light camera, it grows
  /// with the square of the depth. Noise moves a point along its ray; depth is z in a CAMERA view and the distance in a
  /// WORLD view. A point that would end behind the sensor is lost.
  double noise_mm = 0;
  /// The probability with which each point stays, (0, 1]. The other points become not finite.
  double keep = 1;
  /// Whether the color stays.
  bool color = true;
  /// Seed of everything that is random, together with the name of the scene.
  std::uint64_t seed = 1;
};

/// INVALID_ARGUMENT that names every value out of its range.
absl::Status check(const Degradation& degradation);

/// Degrades a scene. Points that are lost get the label 0, too. INVALID_ARGUMENT for noise in a WORLD
/// view without a sensor, because it has no rays.
absl::Status degrade(codec::LabeledCloud& scene, const Degradation& degradation, std::string_view scene_name);

}  // namespace segserve::eval
