// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/placement.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::codec {
namespace {

/// 1 or -1 for each axis.
Eigen::Vector3d signs_of(const Placement& placement) { return placement.scale / placement.meters_per_unit(); }

/// Where the cloud's origin is, in meters along the axes of the file.
Eigen::Vector3d origin_in_meters(const Placement& placement) { return placement.offset * placement.meters_per_unit(); }

/// The view with the sensor, or all cameras, at other places; they are moved in double.
template <typename Move>
View with_moved_sensors(View view, Move&& move) {
  if (view.sensor) view.sensor = move(view.sensor->cast<double>()).template cast<float>();
  for (CameraPoints& camera : view.cameras) {
    camera.sensor = move(camera.sensor.cast<double>()).template cast<float>();
  }
  return view;
}

/// The limits of one axis of a crop box for the cloud.
void move_limits(double origin, double sign, std::optional<double>& low, std::optional<double>& high) {
  if (low) *low = sign * (*low - origin);
  if (high) *high = sign * (*high - origin);
  if (sign < 0) std::swap(low, high);
}

}  // namespace

Options to_cloud(const Placement& placement, Options options) {
  const Eigen::Vector3d origin = origin_in_meters(placement), signs = signs_of(placement);
  move_limits(origin.x(), signs.x(), options.crop_min_x, options.crop_max_x);
  move_limits(origin.y(), signs.y(), options.crop_min_y, options.crop_max_y);
  move_limits(origin.z(), signs.z(), options.crop_min_z, options.crop_max_z);
  return options;
}

View to_cloud(const Placement& placement, View view) {
  return with_moved_sensors(std::move(view), [&](const Eigen::Vector3d& position) -> Eigen::Vector3d {
    return signs_of(placement).cwiseProduct(position - origin_in_meters(placement));
  });
}

View to_file(const Placement& placement, View view) {
  return with_moved_sensors(std::move(view), [&](const Eigen::Vector3d& position) -> Eigen::Vector3d {
    return signs_of(placement).cwiseProduct(position) + origin_in_meters(placement);
  });
}

void to_file(const Placement& placement, SegmentStatistics& segment) {
  const Eigen::Vector3d signs = signs_of(placement);
  segment.centroid = placement.to_file(segment.centroid);
  segment.box.center = placement.to_file(segment.box.center);
  segment.box.half_extents /= placement.meters_per_unit();
  segment.box.axes = (signs.asDiagonal() * segment.box.axes).eval();
  if (segment.normal) segment.normal = signs.cwiseProduct(*segment.normal).eval();
}

void to_file(const Placement& placement, Segmentation& segmentation) {
  if (placement.is_identity()) return;
  for (SegmentStatistics& segment : segmentation.statistics) to_file(placement, segment);
  const Eigen::Vector3d signs = signs_of(placement);
  for (Eigen::Vector3d& normal : segmentation.supervoxel_normals) normal = signs.cwiseProduct(normal).eval();
  if (!segmentation.support_plane) return;
  SupportPlane& plane = *segmentation.support_plane;
  plane.normal = signs.cwiseProduct(plane.normal).eval();
  plane.offset = plane.offset / placement.meters_per_unit() + plane.normal.dot(placement.offset);
}

Prompts to_cloud(const Placement& placement, Prompts prompts) {
  for (std::vector<Prompt>* places : {&prompts.include, &prompts.exclude}) {
    for (Prompt& place : *places) {
      if (auto* position = std::get_if<Eigen::Vector3d>(&place)) *position = placement.to_cloud(*position);
    }
  }
  return prompts;
}

void to_file(const Placement& placement, PromptedSelection& selected) {
  for (std::vector<PromptedPoint>* points : {&selected.include, &selected.exclude}) {
    for (PromptedPoint& point : *points) point.distance /= placement.meters_per_unit();
  }
  if (selected.statistics) to_file(placement, *selected.statistics);
}

FileContent content_of(const LabeledCloud& file, std::span<const std::uint32_t> label) {
  FileContent content{.cloud = file.cloud,
                      .label = label,
                      .attributes = file.attributes,
                      .has_standard_gps_time = file.has_standard_gps_time,
                      .viewpoint = file.viewpoint,
                      .reference_records = file.reference_records};
  content.cloud.view = to_file(file.placement, file.cloud.view);
  // Everything in the file is in its unit.
  content.cloud.view = with_moved_sensors(
      std::move(content.cloud.view),
      [&](const Eigen::Vector3d& position) -> Eigen::Vector3d { return position / file.placement.meters_per_unit(); });
  if (!file.file_position[0].empty()) {
    content.position = &file.file_position;
    content.unit = length_unit_of(file.placement.meters_per_unit()).value_or(LengthUnit::kMeter);
  }
  return content;
}

}  // namespace segserve::codec
