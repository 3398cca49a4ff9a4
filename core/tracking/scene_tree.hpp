// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/math/vec3.hpp"
#include "segserve/cloud.hpp"
#include "segserve/segment.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::tracking {

/// Sums over the supervoxels of a node, weighted by area, so that two nodes add up.
struct NodeFeatures {
  double area = 0;  ///< square meters
  std::uint64_t points = 0;
  Vec3 center_sum, color_sum;

  void add(const NodeFeatures& other) {
    area += other.area, points += other.points;
    center_sum += other.center_sum, color_sum += other.color_sum;
  }
  Vec3 center() const { return area > 0 ? (1 / area) * center_sum : Vec3{}; }
  Vec3 color() const { return area > 0 ? (1 / area) * color_sum : Vec3{}; }
};

/// The merge tree of a frame of m supervoxels, with what its nodes look like and how they nest.
class SceneTree {
 public:
  /// The segmentation must outlive the tree. CANCELLED, DEADLINE_EXCEEDED.
  static absl::StatusOr<SceneTree> make(const Segmentation& segmentation, const View& view, const StopToken& stop);

  const MergeTree& tree() const { return *tree_; }
  std::size_t leaf_count() const { return tree_->leaf_count(); }
  std::size_t node_count() const { return nodes_.size(); }
  const NodeFeatures& node(std::size_t n) const { return nodes_[n]; }
  const Vec3& leaf_center(std::size_t leaf) const { return leaf_centers_[leaf]; }
  const Vec3& leaf_color(std::size_t leaf) const { return leaf_colors_[leaf]; }
  const Vec3& leaf_normal(std::size_t leaf) const { return leaf_normals_[leaf]; }
  double leaf_area(std::size_t leaf) const { return areas_[leaf]; }
  double area(std::size_t n) const { return areas_[n]; }
  /// Radius of a disk with the mean area of a supervoxel, meters.
  double leaf_radius() const { return leaf_radius_; }
  bool is_leaf(std::size_t n) const { return n < leaf_count(); }
  std::uint32_t left(std::size_t n) const { return tree_->left[n - leaf_count()]; }
  std::uint32_t right(std::size_t n) const { return tree_->right[n - leaf_count()]; }

  /// The nodes that the cut of the segmentation has made are those below this number.
  std::size_t cut_nodes() const { return cut_nodes_; }
  /// The nodes whose supervoxels are connected are those below this number.
  std::size_t connected_nodes() const { return connected_nodes_; }
  /// The segments of the cut, by ascending node.
  const std::vector<std::uint32_t>& segments() const { return segments_; }
  bool is_segment(std::size_t n) const { return is_segment_[n]; }

  /// The leaves below node n are leaf_order()[begin(n)] to leaf_order()[end(n) - 1].
  std::size_t begin(std::size_t n) const { return begin_[n]; }
  std::size_t end(std::size_t n) const { return begin_[n] + (is_leaf(n) ? 1 : tree_->leaves[n - leaf_count()]); }
  const std::vector<std::uint32_t>& leaf_order() const { return leaf_order_; }
  /// Whether one of the nodes is the other or below it.
  bool nest(std::size_t a, std::size_t b) const { return begin(a) < end(b) && begin(b) < end(a); }

 private:
  const MergeTree* tree_ = nullptr;
  std::vector<NodeFeatures> nodes_;
  std::vector<double> areas_;  // of the nodes: one by one, for loops over all of them
  std::vector<Vec3> leaf_centers_, leaf_colors_, leaf_normals_;
  std::vector<std::uint32_t> segments_, leaf_order_, begin_;
  std::vector<bool> is_segment_;
  std::size_t cut_nodes_ = 0, connected_nodes_ = 0;
  double leaf_radius_ = 0;
};

}  // namespace segserve::tracking
