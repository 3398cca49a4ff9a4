// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/frame_context.hpp"
#include "core/region_graph/region_graph.hpp"
#include "core/weights/color_geometry_weight.hpp"
#include "core/weights/lab_color.hpp"
#include "segserve/cloud.hpp"

namespace segserve {

/// The geometric dissimilarity delta_G of eq. 5, between 0 for coplanar regions and 1, of regions with centroids x and
/// unit normals n. Where the centroids coincide, c_ij is taken as 0. With `halve_convex` it is delta'_G of eq. 7: half
/// of delta_G where the normals open away from each other.
double geometric_term(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj, bool halve_convex = false);

/// The paper's metric delta of eq. 3 in all its variants (a BatchRegionMetric).
class PaperMetric {
 public:
  /// The paper's weights depend on the regions alone: nothing is kept of an edge.
  struct Evidence {
    Evidence& operator+=(const Evidence&) { return *this; }
  };

  /// Learns the transformations T_C and T_G that the method asks for from the edges of the graph.
  /// CANCELLED, DEADLINE_EXCEEDED.
  static absl::StatusOr<PaperMetric> create(const FrameContext& frame, const RegionGraph& graph);

  std::size_t region_count() const { return regions_.size(); }
  std::uint32_t points(std::uint32_t r) const { return regions_[r].points; }
  Evidence evidence(std::size_t) const { return {}; }

  /// delta(r_i, r_j) in [0, 1].
  double dissimilarity(std::uint32_t i, std::uint32_t j, const Evidence& = {}) const;
  void dissimilarities(std::span<const RegionEdge> pairs, double* result) const;
  /// The dissimilarities of the edges of the graph, which are known from learning.
  std::span<const double> initial_dissimilarities() const { return initial_; }
  double weight(double dissimilarity) const { return dissimilarity; }
  bool too_small(std::uint32_t r) const { return regions_[r].points < min_points_; }
  void merge(std::uint32_t into, std::uint32_t from, const Evidence& = {});

  /// The weight of color against geometry; 1/2 for Equalization.
  double lambda() const { return weight_.lambda(); }

 private:
  PaperMetric(const FrameContext& frame, const RegionGraph& graph);
  absl::Status learn(const FrameContext& frame, std::span<const RegionEdge> edges);
  void update_surface(std::size_t r);
  void color_distances(std::span<const RegionEdge> pairs, double* result) const;     // delta_C
  void geometry_distances(std::span<const RegionEdge> pairs, double* result) const;  // delta_G or delta'_G

  View view_;
  bool convex_;
  std::uint32_t min_points_;
  std::vector<Region> regions_;
  std::vector<Vec3> centroid_, normal_;  // of the regions, for eq. 5
  std::vector<Lab> color_;               // of the regions, for eq. 4
  ColorGeometryWeight weight_;
  std::vector<double> initial_;
};

}  // namespace segserve
