#pragma once

#include <cstdint>
#include <vector>

#include "core/region_graph/borders.hpp"
#include "core/region_graph/region_graph.hpp"

namespace segserve {

/// Constants of the border evidence (METHOD: logistic regression on OSD's learn set, noisy and thinned copies).
struct BorderOptions {
  double cut_weight = 6.7;        ///< of c, LCCP's decision that the two supervoxels are not one convex surface
  double concavity_weight = 0.5;  ///< of k, a degree of concavity along the border
  double color_weight = 0.07;     ///< of E, a unit of CIEDE2000
  double dead_zone = 4;           ///< degrees of concavity that count as none
  double bias = 14.5;             ///< evidence at which two small regions are as likely one as not
  double size_weight = 0.6;       ///< for each doubling of the smaller region's area beyond `size_area`
  double size_area = 8e-4;        ///< m^2
  double smallest_area = 12e-4;   ///< m^2; a smaller region with a neighbour does not stay on its own
  double size_limit = 4e-2;       ///< m^2; larger areas count as this, so that far scenes fare like near ones
};

/// The border method: how much the border between two regions looks like one between objects, as the mean over
/// all edges between their supervoxels; large regions need less to stay apart. Both only grow with merging, so the
/// merge tree is monotone: delta(A u B, C) >= min(delta(A, C), delta(B, C)).
class BorderMetric {
 public:
  /// Sums over the voxel pairs of a border: their number and the evidence z times it.
  struct Evidence {
    double pairs = 0, weighted = 0;
    Evidence& operator+=(const Evidence& o) { return pairs += o.pairs, weighted += o.weighted, *this; }
  };

  /// `min_points`: a region of fewer input points does not stay on its own either.
  BorderMetric(const RegionGraph& graph, std::uint32_t min_points, const BorderOptions& options);

  std::size_t region_count() const { return area_.size(); }
  std::uint32_t points(std::uint32_t r) const { return points_[r]; }

  /// The argument of the sigmoid, which is unbounded and has fewer ties.
  double dissimilarity(std::uint32_t a, std::uint32_t b, const Evidence& evidence) const;
  /// The sigmoid: delta in [0, 1].
  double weight(double dissimilarity) const;
  bool too_small(std::uint32_t r) const { return area_[r] < options_.smallest_area || points_[r] < min_points_; }
  void merge(std::uint32_t into, std::uint32_t from);

 private:
  BorderOptions options_;
  std::uint32_t min_points_;
  std::vector<double> area_;
  std::vector<double> size_evidence_;  // that its area adds to the dissimilarity to a larger region
  std::vector<std::uint32_t> points_;

  double size_evidence(double area) const;
};

/// The evidence of every edge: cut_weight c + concavity_weight k + color_weight E. `voxel` and `seed`: the
/// resolutions, metres.
std::vector<BorderMetric::Evidence> border_evidence(const RegionGraph& graph, const std::vector<Border>& borders,
                                                    double voxel, double seed, const BorderOptions& options,
                                                    const StopToken& stop = {});

/// The decision of LCCP (Stein et al. 2014) that two supervoxels do not belong to one convex or smooth surface:
/// c of the evidence. Centroids, unit normals; metres.
bool is_cut(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj, double voxel, double seed);

}  // namespace segserve
