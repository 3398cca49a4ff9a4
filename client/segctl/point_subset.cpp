// SPDX-License-Identifier: Apache-2.0
#include "client/segctl/point_subset.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace segserve::segctl {
namespace {

/// The entries of the points, `per_point` values each; empty if there are no values.
template <typename T>
std::vector<T> entries(const std::vector<T>& values, std::size_t per_point, std::span<const std::size_t> points) {
  std::vector<T> kept;
  if (values.empty()) return kept;
  kept.reserve(points.size() * per_point);
  for (const std::size_t i : points) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(i * per_point);
    kept.insert(kept.end(), first, first + static_cast<std::ptrdiff_t>(per_point));
  }
  return kept;
}

}  // namespace

codec::LabeledCloud subset_of(const codec::LabeledCloud& scene, std::span<const std::size_t> points) {
  codec::LabeledCloud subset;
  subset.cloud.x = entries(scene.cloud.x, 1, points);
  subset.cloud.y = entries(scene.cloud.y, 1, points);
  subset.cloud.z = entries(scene.cloud.z, 1, points);
  subset.cloud.rgb = entries(scene.cloud.rgb, 1, points);
  subset.cloud.width = static_cast<std::uint32_t>(points.size());
  subset.cloud.height = 1;
  subset.cloud.view = scene.cloud.view;
  subset.cloud.view.cameras.clear();  // which tell the numbers of all points
  subset.placement = scene.placement;
  subset.has_standard_gps_time = scene.has_standard_gps_time;
  subset.viewpoint = scene.viewpoint;
  subset.reference_records = scene.reference_records;
  std::ranges::transform(scene.file_position, subset.file_position.begin(),
                         [&](const std::vector<double>& axis) { return entries(axis, 1, points); });
  for (const codec::Attribute& attribute : scene.attributes) {
    subset.attributes.push_back({attribute.name, attribute.type, attribute.count,
                                 entries(attribute.values, attribute.bytes_per_point(), points)});
  }
  return subset;
}

}  // namespace segserve::segctl
