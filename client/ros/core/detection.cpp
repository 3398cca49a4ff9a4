// SPDX-License-Identifier: Apache-2.0
#include "client/ros/core/detection.hpp"

#include <cmath>
#include <cstddef>

#include "segserve/segment_statistics.hpp"

namespace segserve::ros {
namespace {

std::uint32_t published_label(const wire::Result& result, std::uint32_t segment) {
  if (!result.tracks || segment == 0) return segment;
  return static_cast<std::uint32_t>(result.tracks->track_of_segment[segment - 1]);
}

/// A saturated color whose hue goes around by the golden ratio from label to label.
std::array<float, 3> color_of_label(std::uint32_t label) {
  constexpr double kGoldenRatio = 0.6180339887498949;
  const double turns = kGoldenRatio * label;
  const double hue = 6 * (turns - std::floor(turns));
  const auto channel = [hue](double offset) {
    const double k = std::fmod(offset + hue, 6.0);
    return static_cast<float>(0.95 * (1 - 0.7 * std::fmax(0.0, std::fmin(std::fmin(k, 4 - k), 1.0))));
  };
  return {channel(5), channel(3), channel(1)};  // the channels of HSV
}

}  // namespace

std::vector<std::uint32_t> published_labels(const wire::Result& result) {
  std::vector<std::uint32_t> labels = result.segmentation.labels;
  if (!result.tracks) return labels;
  for (std::uint32_t& label : labels) label = published_label(result, label);
  return labels;
}

std::vector<Detection> detections_of(const wire::Result& result, std::uint32_t min_points) {
  std::vector<Detection> detections;
  std::uint32_t segment = 0;
  for (const SegmentStatistics& statistics : result.segmentation.statistics) {
    const std::uint32_t label = published_label(result, ++segment);
    if (label == 0 || statistics.points < min_points) continue;
    Detection& detection = detections.emplace_back();
    detection.id = label;
    detection.points = statistics.points;
    detection.center = statistics.box.center;
    detection.orientation = Eigen::Quaterniond(statistics.box.axes);
    detection.size = 2 * statistics.box.half_extents;
    detection.color = color_of_label(label);
    if (statistics.color) {
      for (std::size_t c = 0; c < 3; ++c) {
        detection.color[c] = static_cast<float>((*statistics.color)[static_cast<Eigen::Index>(c)] / 255);
      }
    }
  }
  return detections;
}

}  // namespace segserve::ros
