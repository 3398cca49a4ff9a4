#include "proto/wire/segment_message.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>

#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

constexpr double kUnitTolerance = 1e-6;

v1::Vector3 to_message(const Vec3& v) {
  v1::Vector3 message;
  message.set_x(v.x);
  message.set_y(v.y);
  message.set_z(v.z);
  return message;
}

Vec3 to_vec3(const v1::Vector3& message) { return {message.x(), message.y(), message.z()}; }

bool is_between(const Vec3& v, double low, double high) {
  return std::ranges::all_of(std::array{v.x, v.y, v.z},
                             [&](double c) { return std::isfinite(c) && c >= low && c <= high; });
}

bool is_finite_vector(const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

bool is_near(double value, double expected) { return std::fabs(value - expected) <= kUnitTolerance; }  // not for NaN

/// Orthogonal unit vectors, right-handed.
bool is_frame(const std::array<Vec3, 3>& axes) {
  return std::ranges::all_of(axes, [](const Vec3& axis) { return is_near(norm(axis), 1); }) &&
         is_near(dot(axes[0], axes[1]), 0) && is_near(dot(cross(axes[0], axes[1]), axes[2]), 1);
}

v1::Segment to_message(const SegmentStatistics& segment) {
  v1::Segment message;
  message.set_points(segment.points);
  *message.mutable_centroid() = to_message(segment.centroid);
  v1::OrientedBox& box = *message.mutable_box();
  *box.mutable_center() = to_message(segment.box.center);
  for (const Vec3& axis : segment.box.axes) *box.add_axes() = to_message(axis);
  *box.mutable_half_extents() = to_message(segment.box.half_extents);
  if (segment.color) {
    message.mutable_color()->set_red(segment.color->x);
    message.mutable_color()->set_green(segment.color->y);
    message.mutable_color()->set_blue(segment.color->z);
  }
  if (segment.normal) *message.mutable_normal() = to_message(*segment.normal);
  return message;
}

SegmentStatistics read(const v1::Segment& message) {
  SegmentStatistics segment;
  segment.points = message.points();
  segment.centroid = to_vec3(message.centroid());
  segment.box.center = to_vec3(message.box().center());
  std::ranges::transform(message.box().axes(), segment.box.axes.begin(), to_vec3);
  segment.box.half_extents = to_vec3(message.box().half_extents());
  if (message.has_color()) segment.color = {message.color().red(), message.color().green(), message.color().blue()};
  if (message.has_normal()) segment.normal = to_vec3(message.normal());
  return segment;
}

/// What is wrong with a segment; empty: nothing.
std::string_view fault(const SegmentStatistics& segment) {
  if (segment.points == 0) return "points: 0";
  if (!is_finite_vector(segment.centroid)) return "centroid: not finite";
  if (!is_finite_vector(segment.box.center)) return "box.center: not finite";
  if (!is_frame(segment.box.axes)) return "box.axes: not three unit vectors at right angles, right-handed";
  if (!is_between(segment.box.half_extents, 0, INFINITY)) return "box.half_extents: not finite and at least 0";
  if (segment.color && !is_between(*segment.color, 0, 255)) return "color: not in [0, 255]";
  if (segment.normal && !is_near(norm(*segment.normal), 1)) return "normal: not a unit vector";
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
