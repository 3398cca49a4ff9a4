// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/segment_message.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "core/base/status_macros.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

constexpr double kUnitTolerance = 1e-6;

v1::Vector3 vector_message(const Eigen::Vector3d& v) {
  v1::Vector3 message;
  message.set_x(v.x());
  message.set_y(v.y());
  message.set_z(v.z());
  return message;
}

Eigen::Vector3d read_vector(const v1::Vector3& message) { return {message.x(), message.y(), message.z()}; }

bool is_between(const Eigen::Vector3d& v, double low, double high) {
  return v.allFinite() && v.minCoeff() >= low && v.maxCoeff() <= high;
}

/// False if the value is NaN.
bool is_near(double value, double expected) { return std::fabs(value - expected) <= kUnitTolerance; }

/// Whether the columns are right-handed unit vectors at right angles.
bool is_rotation(const Eigen::Matrix3d& axes) {
  return is_near(axes.col(0).norm(), 1) && is_near(axes.col(1).norm(), 1) && is_near(axes.col(2).norm(), 1) &&
         is_near(axes.col(0).dot(axes.col(1)), 0) && is_near(axes.col(0).cross(axes.col(1)).dot(axes.col(2)), 1);
}

SegmentStatistics read(const v1::Segment& message) {
  SegmentStatistics segment;
  segment.points = message.points();
  segment.centroid = read_vector(message.centroid());
  segment.box.center = read_vector(message.box().center());
  for (int k = 0; k < 3; ++k) segment.box.axes.col(k) = read_vector(message.box().axes(k));
  segment.box.half_extents = read_vector(message.box().half_extents());
  if (message.has_color()) segment.color = {message.color().red(), message.color().green(), message.color().blue()};
  if (message.has_normal()) segment.normal = read_vector(message.normal());
  return segment;
}

/// The field of a segment that is wrong, and what it must be; empty if there is none.
std::string_view fault_of(const SegmentStatistics& segment) {
  if (segment.points == 0) return "points: must be at least 1";
  if (!segment.centroid.allFinite()) return "centroid: must be finite";
  if (!segment.box.center.allFinite()) return "box.center: must be finite";
  if (!is_rotation(segment.box.axes)) return "box.axes: must be right-handed unit vectors at right angles";
  if (!is_between(segment.box.half_extents, 0, INFINITY)) return "box.half_extents: must be finite and at least 0";
  if (segment.color && !is_between(*segment.color, 0, 255)) return "color: must be from 0 to 255";
  if (segment.normal && !is_near(segment.normal->norm(), 1)) return "normal: must be a unit vector";
  return {};
}

}  // namespace

v1::ThresholdRange to_message(const ThresholdRange& range) {
  v1::ThresholdRange message;
  message.set_lower(range.from);
  message.set_upper(range.to);
  return message;
}

std::optional<ThresholdRange> from_message(const v1::ThresholdRange& message) {
  const ThresholdRange range{message.lower(), message.upper()};
  const bool is_good = range.from >= 0 && range.from <= range.to && range.to <= 1;  // false for NaN
  return is_good ? std::optional(range) : std::nullopt;
}

v1::Segment to_message(const SegmentStatistics& segment) {
  v1::Segment message;
  message.set_points(segment.points);
  *message.mutable_centroid() = vector_message(segment.centroid);
  v1::OrientedBox& box = *message.mutable_box();
  *box.mutable_center() = vector_message(segment.box.center);
  for (int k = 0; k < 3; ++k) *box.add_axes() = vector_message(segment.box.axes.col(k));
  *box.mutable_half_extents() = vector_message(segment.box.half_extents);
  if (segment.color) {
    message.mutable_color()->set_red(segment.color->x());
    message.mutable_color()->set_green(segment.color->y());
    message.mutable_color()->set_blue(segment.color->z());
  }
  if (segment.normal) *message.mutable_normal() = vector_message(*segment.normal);
  if (segment.thresholds) *message.mutable_thresholds() = to_message(*segment.thresholds);
  return message;
}

absl::StatusOr<SegmentStatistics> from_message(const v1::Segment& message, std::string_view name) {
  if (message.box().axes_size() != 3) {
    return malformed(fmt::format("{}: box.axes: has {} axes, but must have 3", name, message.box().axes_size()));
  }
  SegmentStatistics segment = read(message);
  if (const std::string_view fault = fault_of(segment); !fault.empty()) {
    return malformed(fmt::format("{}: {}", name, fault));
  }
  if (message.has_thresholds()) {
    segment.thresholds = from_message(message.thresholds());
    if (!segment.thresholds) return malformed(fmt::format("{}: thresholds: must be ascending in [0, 1]", name));
  }
  return segment;
}

SegmentMessages to_message(std::span<const SegmentStatistics> statistics) {
  SegmentMessages messages;
  messages.Reserve(static_cast<int>(statistics.size()));
  for (const SegmentStatistics& segment : statistics) *messages.Add() = to_message(segment);
  return messages;
}

absl::StatusOr<std::vector<SegmentStatistics>> from_message(const SegmentMessages& messages, std::uint32_t segments,
                                                            std::uint64_t segmented_points) {
  const auto count = static_cast<std::size_t>(messages.size());
  if (const std::size_t expected = std::min(segments, kMostDescribedSegments); count != expected) {
    return malformed(fmt::format("segments: has {} entries, but must have {}", count, expected));
  }
  std::vector<SegmentStatistics> statistics;
  statistics.reserve(count);
  std::uint64_t points = 0;
  for (const v1::Segment& message : messages) {
    const std::size_t label = statistics.size() + 1;
    ASSIGN_OR_RETURN(const SegmentStatistics segment, from_message(message, fmt::format("segment {}", label)));
    if (label > 1 && segment.points > statistics.back().points) {
      return malformed(
          fmt::format("segment {}: points: is {}, more than in the segment before", label, segment.points));
    }
    points += segment.points;
    statistics.push_back(segment);
  }
  const std::uint64_t not_described = segments - count;  // Each of these segments has at least one point.
  if (points + not_described > segmented_points || (not_described == 0 && points != segmented_points)) {
    return malformed(fmt::format("segments: {} segments have {} points, but by the summary {} segments have {} points",
                                 count, points, segments, segmented_points));
  }
  return statistics;
}

}  // namespace segserve::wire
