// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "segserve/cloud.hpp"
#include "segserve/merge_tree.hpp"
#include "segserve/segment_statistics.hpp"

namespace segserve::wire {

/// A cloud of six points in two rows. One point is not finite, and all colors differ.
inline Cloud small_cloud() {
  Cloud cloud;
  cloud.x = {0.0F, 0.1F, 0.2F, -0.0F, 1e-30F, NAN};
  cloud.y = {1.0F, 1.1F, 1.2F, 1.3F, 1.4F, 1.5F};
  cloud.z = {2.0F, 2.1F, 2.2F, 2.3F, 2.4F, 2.5F};
  cloud.rgb = {0x000000, 0xff0000, 0x00ff00, 0x0000ff, 0x123456, 0xffffff};
  cloud.width = 3;
  cloud.height = 2;
  cloud.view = View::camera();
  return cloud;
}

/// A cloud of twelve points in three rows, as a pinhole camera sees them, so that every codec can encode it. One point
/// is not finite.
inline Cloud small_camera_cloud() {
  Cloud cloud;
  cloud.width = 4;
  cloud.height = 3;
  cloud.view = View::camera();
  for (std::uint32_t i = 0; i < 12; ++i) {
    const float z = i == 6 ? NAN : 1.0F + 0.01F * static_cast<float>(i);
    cloud.x.push_back((static_cast<float>(i % 4) - 1.5F) / 10 * z);
    cloud.y.push_back((static_cast<float>(i) / 4 - static_cast<float>(i % 4) / 4 - 1.0F) / 10 * z);
    cloud.z.push_back(z);
    cloud.rgb.push_back(0x102030 + i);
  }
  return cloud;
}

/// The tree of three supervoxels. An edge merges 1 and 2, and their region is then joined with 3.
inline MergeTree small_tree() {
  return {.leaf_points = {2, 2, 1},
          .left = {0, 2},
          .right = {1, 3},
          .weight = {0.25, 1.0},
          .height = {0.25, 1.0},
          .leaves = {2, 3},
          .points = {4, 5},
          .kind = {MergeKind::kMerged, MergeKind::kJoined}};
}

/// A tree that compresses well. It merges `leaves` supervoxels of one point each, one after the other.
inline MergeTree chain_tree(std::uint32_t leaves) {
  TreeColumns columns;
  columns.leaf_points.assign(leaves, 1);
  for (std::uint32_t row = 0; row + 1 < leaves; ++row) {
    columns.left.push_back(row == 0 ? 0 : row + 1);
    columns.right.push_back(row == 0 ? 1 : leaves + row - 1);
    columns.weight.push_back(row < leaves / 2 ? 0.5 : 1);
  }
  columns.merged_rows = leaves / 2;
  return complete(std::move(columns)).value();
}

/// The statistics of two segments with 4 points and 1 point. Only the first has a color and a normal.
inline std::vector<SegmentStatistics> small_statistics() {
  SegmentStatistics first, second;
  first.points = 4;
  first.centroid = {0.1, -2, 1e-3};
  first.box.center = {0.2, -2.5, 0};
  first.box.axes << 0, 0.6, 0.8, 1, 0, 0, 0, 0.8, -0.6;
  first.box.half_extents = {3, 2, 0};
  first.color = {12.5, 0, 255};
  first.normal = {0, -0.6, 0.8};
  second.points = 1;
  second.centroid = second.box.center = {1.0 / 3, 7, -1e9};
  return {first, second};
}

}  // namespace segserve::wire
