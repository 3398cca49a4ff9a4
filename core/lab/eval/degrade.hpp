#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/status.h"
#include "segserve/codec/labelled_cloud.hpp"

namespace segserve::eval {

/// What is done to a scene before it is segmented, in this order. The same bytes on every machine.
struct Degradation {
  /// All coordinates times this, (0, 1000]: the same scene of another size, as far away as it is larger.
  double scale = 1;
  /// Standard deviation of depth noise at 1 m, millimetres, [0, 1000]. It grows with the square of the depth, as that
  /// of a structured-light camera does, and moves a point along its ray: depth is z in a CAMERA view, the distance in a
  /// WORLD view. A point that would end behind the sensor is lost.
  double noise_mm = 0;
  /// Share of the points that stay, (0, 1], each with this probability; the others become not finite.
  double keep = 1;
  /// Whether colour stays.
  bool color = true;
  /// Everything random follows from it and from the scene's name.
  std::uint64_t seed = 1;
};

/// INVALID_ARGUMENT naming every value out of its range.
absl::Status check(const Degradation& degradation);

/// Degrades a scene; points that are lost lose their ground truth (label 0), too. INVALID_ARGUMENT for noise in a WORLD
/// view without a sensor, which has no rays.
absl::Status degrade(codec::LabelledCloud& scene, const Degradation& degradation, std::string_view scene_name);

}  // namespace segserve::eval
