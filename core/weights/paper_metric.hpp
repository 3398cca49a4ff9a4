#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/region_graph/region_graph.hpp"
#include "core/weights/color_difference.hpp"
#include "core/weights/color_geometry_weight.hpp"
#include "segserve/cloud.hpp"
#include "segserve/options.hpp"

namespace segserve {

/// eq. 5: 0 for coplanar regions, up to 1. Where the centroids coincide, c_ij is taken as 0. `halve_convex`: eq. 7,
/// half of it where the normals open away from each other.
double geometric_term(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj, bool halve_convex = false);

/// delta of eq. 3 between regions that merge: the paper's metric in all its variants. The
/// transformations T_C and T_G are learnt once, over the edges of the initial graph.
class PaperMetric {
 public:
  /// The paper's weights follow from the regions alone: nothing is kept of an edge.
  struct Evidence {
    Evidence& operator+=(const Evidence&) { return *this; }
  };

  /// If stopped, it is useless.
  PaperMetric(const RegionGraph& graph, const View& view, const Options& options, const StopToken& stop = {});

  std::size_t region_count() const { return regions_.size(); }
  std::uint32_t points(std::uint32_t r) const { return regions_[r].points; }

  /// delta(r_i, r_j) in [0, 1].
  double dissimilarity(std::uint32_t i, std::uint32_t j, const Evidence& = {}) const;
  /// Of all pairs: a sixth of the time that one after the other takes.
  void dissimilarities(std::span<const RegionEdge> pairs, double* result) const;
  /// Of the edges of the graph, before any merge: a tenth of merging is that they are not computed twice.
  std::span<const double> initial_dissimilarities() const { return initial_; }
  double weight(double dissimilarity) const { return dissimilarity; }
  bool too_small(std::uint32_t r) const { return regions_[r].points < min_points_; }

  /// Region `from` joins region `into`.
  void merge(std::uint32_t into, std::uint32_t from);

  /// Weight of colour against geometry.
  double lambda() const { return unification_.lambda(); }

 private:
  void find_surface(std::size_t r);
  void color_distances(std::span<const RegionEdge> pairs, double* result) const;     // delta_C
  void geometry_distances(std::span<const RegionEdge> pairs, double* result) const;  // delta_G or delta'_G

  View view_;
  bool convex_;
  std::uint32_t min_points_;
  std::vector<Region> regions_;
  // What eq. 4 and 5 look at.
  std::vector<Vec3> centroid_, normal_;
  std::vector<Lab> color_;
  Unification unification_;
  std::vector<double> initial_;
};

}  // namespace segserve
