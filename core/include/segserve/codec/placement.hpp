// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "segserve/cloud.hpp"
#include "segserve/options.hpp"
#include "segserve/prompts.hpp"
#include "segserve/segment.hpp"

namespace segserve::codec {

/// How the coordinates in a file became those of a cloud, which are in meters, near the origin, and in a camera's frame
/// with z forward:
///
///     cloud = scale * (file - offset), axis by axis.
///
/// The functions below carry options to the cloud, and what was found in it back to the file. Lengths such as those of
/// boxes are then in the file's unit.
struct Placement {
  /// Meters a unit of the file. Negative for an axis that is reversed: y and z of a camera whose y points up and whose
  /// z points backward. All have the same magnitude.
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();
  /// The file's position of the cloud's origin, in the file's unit.
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();

  bool operator==(const Placement&) const = default;
  bool is_identity() const { return *this == Placement(); }
  double meters_per_unit() const { return std::abs(scale.x()); }
  Eigen::Vector3d to_cloud(const Eigen::Vector3d& in_file) const { return scale.cwiseProduct(in_file - offset); }
  Eigen::Vector3d to_file(const Eigen::Vector3d& in_cloud) const { return in_cloud.cwiseQuotient(scale) + offset; }
};

/// The options for the cloud. The crop box, whose sides are in meters along the axes of the file, is moved with the
/// points.
Options to_cloud(const Placement& placement, Options options);

/// Moves the sensor of a view, or its cameras, which are in meters along the axes of the file, with the points, and
/// back. A view without a sensor position stays as it is.
View to_cloud(const Placement& placement, View view);
View to_file(const Placement& placement, View view);

/// Moves the positions of prompts, which are in the coordinates of the file, with the points.
Prompts to_cloud(const Placement& placement, Prompts prompts);

/// Expresses what was selected in the file's coordinates.
void to_file(const Placement& placement, PromptedSelection& selected);

/// Expresses the statistics of a segment in the file's coordinates.
void to_file(const Placement& placement, SegmentStatistics& segment);

/// Expresses the statistics of the segments, the support plane, and the supervoxels' normals in the file's coordinates.
void to_file(const Placement& placement, Segmentation& segmentation);

}  // namespace segserve::codec
