// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "segserve/cloud.hpp"
#include "segserve/codec/warning.hpp"

// Where the sensor of a file's cloud is. Formats hardly tell, and what they tell is often a default value. So the
// points have a say.
namespace segserve::codec {

/// The facts that a file, or its reader, tells about the sensor. Positions are in meters along the axes of the file;
/// read_positions takes those of the file in the file's unit.
struct ViewEvidence {
  std::optional<View> given = std::nullopt;   ///< by the reader of the file, who is believed
  std::optional<View> stated = std::nullopt;  ///< by the file, in the words of view_statement
  /// The position of the sensor as an entry of the format has it, such as VIEWPOINT of PCD. (0, 0, 0) is what programs
  /// write that know no position.
  std::optional<Eigen::Vector3d> position = std::nullopt;
  std::string_view entry = {};  ///< what messages call that entry, e.g. "VIEWPOINT"
  /// Whether the format has an entry for the position of the sensor. If it is missing or (0, 0, 0), a sensor at the
  /// origin is believed if it could have seen the points.
  bool has_entry = false;

  /// Whether the entry has a position that is not a default.
  bool has_position() const { return position && *position != Eigen::Vector3d::Zero(); }
};

struct ViewChoice {
  ViewKind kind = ViewKind::kWorld;
  std::optional<Eigen::Vector3d> sensor = std::nullopt;  ///< in meters along the axes of the file; WORLD only
  std::vector<CameraPoints> cameras = {};                ///< View::cameras, in meters along the axes of the file
  bool y_and_z_are_reversed = false;  ///< a camera's frame with y up and z backward, as OpenGL has it
  std::string rule = {};              ///< LabeledCloud::view_rule
};

/// Chooses the view of a cloud, whose own view is ignored and whose coordinates are in meters along the axes of the
/// file:
///
///  1. The view that the reader gives, or else the one that the file states in segserve's own words.
///  2. An organized cloud is a camera's frame, CAMERA, if (nearly) all points have z > 0, or all have z < 0, and x/z is
///     the same along each column, and y/z along each row, as those of pixels are.
///  3. An organized cloud whose rows or columns have a constant elevation from the origin is the sweep of a spinning
///     LiDAR: WORLD with the sensor at the origin.
///  4. A cloud that is not organized is a camera's frame, CAMERA, if all points have z > 0, or all have z < 0, and both
///     x/z and y/z take few values, as those of pixels do. It is the sweep of a LiDAR if the elevations from the origin
///     take few values.
///  5. A position that the file gives, and that is not (0, 0, 0), is that of the sensor: WORLD.
///  6. A sensor at the origin, if the format has an entry for it, is believed unless the cloud is organized, or the
///     origin lies inside the points' bounding box, below them, or below and beside a floor, or many points lie behind
///     others as seen from there, as those of a closed surface do: WORLD.
///  7. Else WORLD without a sensor.
///
/// Points at (0, 0, 0) are ignored. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<ViewChoice> choose_view(const CloudView& cloud, const ViewEvidence& evidence, StopCheck& check);

/// How files of segserve state the view in a comment: "segserve view world 0 0 1.5", "segserve view world" (no sensor),
/// "segserve view camera".
std::string view_statement(const View& view);
/// The view of such a comment, or nullopt for another one.
std::optional<View> stated_view(std::string_view comment);

}  // namespace segserve::codec
