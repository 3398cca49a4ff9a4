// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/segment_message.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

constexpr double kUnitTolerance = 1e-6;

v1::Vector3 to_message(const Eigen::Vector3d& v) {
  v1::Vector3 message;
  message.set_x(v.x());
  message.set_y(v.y());
  message.set_z(v.z());
  return message;
}

Eigen::Vector3d from_message(const v1::Vector3& message) { return {message.x(), message.y(), message.z()}; }

bool is_between(const Eigen::Vector3d& v, double low, double high) {
  return v.allFinite() && v.minCoeff() >= low && v.maxCoeff() <= high;
}

bool is_near(double value, double expected) { return std::fabs(value - expected) <= kUnitTolerance; }  // not for NaN

/// Whether the columns are unit vectors at right angles, right-handed.
bool is_rotation(const Eigen::Matrix3d& axes) {
  return is_near(axes.col(0).norm(), 1) && is_near(axes.col(1).norm(), 1) && is_near(axes.col(2).norm(), 1) &&
         is_near(axes.col(0).dot(axes.col(1)), 0) && is_near(axes.col(0).cross(axes.col(1)).dot(axes.col(2)), 1);
}

v1::Segment to_message(const SegmentStatistics& segment) {
  v1::Segment message;
  message.set_points(segment.points);
  *message.mutable_centroid() = to_message(segment.centroid);
  v1::OrientedBox& box = *message.mutable_box();
  *box.mutable_center() = to_message(segment.box.center);
  for (int k = 0; k < 3; ++k) *box.add_axes() = to_message(segment.box.axes.col(k));
  *box.mutable_half_extents() = to_message(segment.box.half_extents);
  if (segment.color) {
    message.mutable_color()->set_red(segment.color->x());
    message.mutable_color()->set_green(segment.color->y());
    message.mutable_color()->set_blue(segment.color->z());
  }
  if (segment.normal) *message.mutable_normal() = to_message(*segment.normal);
  return message;
}

SegmentStatistics read(const v1::Segment& message) {
  SegmentStatistics segment;
  segment.points = message.points();
  segment.centroid = from_message(message.centroid());
  segment.box.center = from_message(message.box().center());
  for (int k = 0; k < 3; ++k) segment.box.axes.col(k) = from_message(message.box().axes(k));
  segment.box.half_extents = from_message(message.box().half_extents());
  if (message.has_color()) segment.color = {message.color().red(), message.color().green(), message.color().blue()};
  if (message.has_normal()) segment.normal = from_message(message.normal());
  return segment;
}

/// What is wrong with a segment; empty: nothing.
std::string_view fault(const SegmentStatistics& segment) {
  if (segment.points == 0) return "points: 0";
  if (!segment.centroid.allFinite()) return "centroid: not finite";
  if (!segment.box.center.allFinite()) return "box.center: not finite";
  if (!is_rotation(segment.box.axes)) return "box.axes: not three unit vectors at right angles, right-handed";
  if (!is_between(segment.box.half_extents, 0, INFINITY)) return "box.half_extents: not finite and at least 0";
  if (segment.color && !is_between(*segment.color, 0, 255)) return "color: not in [0, 255]";
  if (segment.normal && !is_near(segment.normal->norm(), 1)) return "normal: not a unit vector";
  return {};
}

}  // namespace

SegmentMessages to_message(std::span<const SegmentStatistics> statistics) {
  SegmentMessages messages;
  messages.Reserve(static_cast<int>(statistics.size()));
  for (const SegmentStatistics& segment : statistics) *messages.Add() = to_message(segment);
  return messages;
}

absl::StatusOr<std::vector<SegmentStatistics>> from_message(const SegmentMessages& messages, std::uint32_t segments,
                                                            std::uint64_t segmented_points) {
  const auto count = static_cast<std::size_t>(messages.size());
  if (count != std::min(segments, kMostDescribedSegments)) {
    return malformed(fmt::format("segments: {} entries for {} segments", count, segments));
  }
  std::vector<SegmentStatistics> statistics;
  statistics.reserve(count);
  std::uint64_t points = 0;
  for (const v1::Segment& message : messages) {
    const std::size_t label = statistics.size() + 1;
    if (message.box().axes_size() != 3) {
      return malformed(fmt::format("segment {}: box.axes: {}, not 3", label, message.box().axes_size()));
    }
    SegmentStatistics segment = read(message);
    if (const std::string_view what = fault(segment); !what.empty()) {
      return malformed(fmt::format("segment {}: {}", label, what));
    }
    if (label > 1 && segment.points > statistics.back().points) {
      return malformed(fmt::format("segment {}: points: {}, more than of the one before", label, segment.points));
    }
    points += segment.points;
    statistics.push_back(segment);
  }
  const std::uint64_t left = segments - count;  // at least a point each, if they are not described
  if (points + left > segmented_points || (left == 0 && points != segmented_points)) {
    return malformed(fmt::format("segments: {} points in {} segments, but {} points of {} segments in the summary",
                                 points, count, segmented_points, segments));
  }
  return statistics;
}

}  // namespace segserve::wire
