// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/scene_tree.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/math/eigen_conversion.hpp"
#include "core/math/elementary.hpp"

namespace segserve::tracking {
namespace {

/// The depth in meters with which voxels grow at `position`; 1 where they are the same everywhere.
double depth_of(const Vec3& position, const Resolution& resolution, const View& view) {
  if (view.kind == ViewKind::kCamera) return position.z;
  const bool is_sweep = resolution.reason == ResolutionReason::kSweep && view.sensor;
  return is_sweep ? norm(position - to_vec3(view.sensor->cast<double>())) : 1;
}

}  // namespace

absl::StatusOr<SceneTree> SceneTree::make(const Segmentation& segmentation, const View& view, const StopToken& stop) {
  StopCheck check(stop);
  const MergeTree& tree = segmentation.tree;
  const std::size_t m = tree.leaf_count(), all = m + tree.row_count();
  SceneTree scene;
  scene.tree_ = &tree;
  scene.cut_nodes_ = m + (m - segmentation.segments);
  const auto joined = std::ranges::find(tree.kind, MergeKind::kJoined);
  scene.connected_nodes_ = m + static_cast<std::size_t>(joined - tree.kind.begin());

  scene.nodes_.resize(all);
  scene.leaf_centers_.resize(m), scene.leaf_colors_.resize(m), scene.leaf_normals_.resize(m);
  check.for_each(0, m, [&](std::size_t leaf) {
    const SupervoxelFeatures& features = segmentation.supervoxel_features[leaf];
    const Vec3 center = to_vec3(features.centroid), color = to_vec3(features.color);
    const double edge = segmentation.resolution.voxel * depth_of(center, segmentation.resolution, view);
    const double area = features.voxels * edge * edge;
    scene.leaf_centers_[leaf] = center;
    scene.leaf_colors_[leaf] = color;
    scene.leaf_normals_[leaf] = unit(to_vec3(segmentation.supervoxel_normals[leaf]));
    scene.nodes_[leaf] = {area, tree.leaf_points[leaf], area * center, area * color};
  });
  check.for_each(0, tree.row_count(), [&](std::size_t row) {
    scene.nodes_[m + row] = scene.nodes_[tree.left[row]];
    scene.nodes_[m + row].add(scene.nodes_[tree.right[row]]);
  });
  scene.areas_.resize(all);
  check.for_each(0, all, [&](std::size_t n) { scene.areas_[n] = scene.nodes_[n].area; });
  if (m > 0) scene.leaf_radius_ = std::sqrt(scene.nodes_.back().area / (math::kPi * static_cast<double>(m)));

  // From the root down, the leaves of the left child come before those of the right one.
  scene.begin_.assign(all, 0);
  scene.is_segment_.assign(all, false);
  check.for_each(0, tree.row_count(), [&](std::size_t i) {
    const std::size_t n = all - 1 - i;
    const std::uint32_t left = scene.left(n), right = scene.right(n);
    scene.begin_[left] = scene.begin_[n];
    scene.begin_[right] = static_cast<std::uint32_t>(scene.end(left));
    if (n < scene.cut_nodes_) return;
    for (const std::uint32_t child : {left, right}) scene.is_segment_[child] = child < scene.cut_nodes_;
  });
  if (all > 0 && scene.cut_nodes_ == all) scene.is_segment_[all - 1] = true;
  scene.leaf_order_.resize(m);
  check.for_each(0, m,
                 [&](std::size_t leaf) { scene.leaf_order_[scene.begin_[leaf]] = static_cast<std::uint32_t>(leaf); });
  for (std::uint32_t n = 0; n < all; ++n) {
    if (scene.is_segment_[n]) scene.segments_.push_back(n);
  }
  RETURN_IF_ERROR(check.status());
  return scene;
}

}  // namespace segserve::tracking
