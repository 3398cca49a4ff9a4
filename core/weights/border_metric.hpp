// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "core/base/frame_context.hpp"
#include "core/region_graph/borders.hpp"
#include "core/region_graph/region_graph.hpp"

namespace segserve {

/// Constants of the border method. They come from a logistic regression on the learn set of OSD and on noisy and
/// thinned copies of it (METHOD).
struct BorderConstants {
  double cut_weight = 6.7;        ///< of c: 1 if LCCP decides that the two supervoxels are not one surface (`is_cut`)
  double concavity_weight = 0.5;  ///< of k: a degree of concavity along the border
  double color_weight = 0.07;     ///< of E: a unit of CIEDE2000
  DeadZone dead_zone{4, 40};      ///< of the concavity
  double noise_angle = 40;        ///< degrees by which two flat supervoxels may differ more where the excess noise is 1
  double noise_step = 10;         ///< by how many times a step may be higher where the excess noise is 1
  double bias = 14.5;             ///< evidence at which two small regions are as likely one object as two
  double size_weight = 0.6;       ///< of each doubling of the smaller region beyond `size`
  double size = 22;               ///< voxels
  double smallest_size = 33;      ///< voxels; a smaller region with a neighbor does not stay on its own
  /// Nor does a chip: a region with more contacts across its borders than this for each of its voxels. A strip between
  /// two other regions has as many if it is one and a half voxels wide.
  double chip_contacts = 4;
  double size_limit = 1100;  ///< voxels; larger regions count as this, so that far scenes are treated like near ones
  /// A floor or a wall is a region of at least this part of the scene's voxels whose mean normal is at least this long.
  double wall_share = 0.07, wall_flatness = 0.9;
  double wall_weight = 1;  ///< of the evidence between a floor or wall and another region
};

/// The evidence of an edge that its regions are two objects, summed up over its contacts.
struct BorderEvidence {
  double contacts = 0;  ///< their number
  double sum = 0;       ///< over the contacts, of cut_weight c + concavity_weight k + color_weight E
  BorderEvidence& operator+=(const BorderEvidence& o) { return contacts += o.contacts, sum += o.sum, *this; }
};

/// Finds the evidence of every edge of the graph from its borders (`measure_borders`). CANCELLED, DEADLINE_EXCEEDED.
absl::Status find_border_evidence(const FrameContext& frame, const RegionGraph& graph,
                                  const std::vector<Border>& borders, const BorderConstants& constants,
                                  std::vector<BorderEvidence>& evidence);

/// The most by which two supervoxels may differ and still be one surface (is_cut).
struct SurfaceTolerance {
  double step = 0;    ///< the highest step between them, meters
  double seed = 0;    ///< the distance of seeds, meters; the step may be higher where the surface folds within it
  double angle = 10;  ///< the largest angle between their normals that is flat, degrees
};

/// The decision of LCCP (Stein et al. 2014) that two supervoxels are not one convex or smooth surface. Takes their
/// centroids x, meters, and unit normals n.
bool is_cut(const Vec3& xi, const Vec3& ni, const Vec3& xj, const Vec3& nj, const SurfaceTolerance& tolerance);

/// The metric of the border method (a PartialRegionMetric): the mean evidence over the border between two regions, less
/// a bias, plus a term that grows with the smaller region. The evidence counts `wall_weight` times if either region
/// is a floor or wall, or has become one by merging. All this only grows with merging, so that the merge tree is
/// monotone: delta(A u B, C) >= min(delta(A, C), delta(B, C)).
class BorderMetric {
 public:
  using Evidence = BorderEvidence;

  /// `evidence` has an entry for each edge. A region of fewer than `min_points` input points does not stay on its own.
  BorderMetric(const RegionGraph& graph, std::vector<BorderEvidence> evidence, std::uint32_t min_points,
               const BorderConstants& constants);

  std::size_t region_count() const { return voxels_.size(); }
  std::uint32_t points(std::uint32_t r) const { return points_[r]; }
  const BorderEvidence& evidence(std::size_t edge) const { return evidence_[edge]; }

  /// The argument of the sigmoid. It is unbounded, so that it has fewer ties than the weight.
  double dissimilarity(std::uint32_t a, std::uint32_t b, const BorderEvidence& evidence) const;
  /// The sigmoid: delta in [0, 1].
  double weight(double dissimilarity) const;
  /// The size term is that of the smaller region.
  bool counts(std::uint32_t r, std::uint32_t neighbor) const { return voxels_[r] < voxels_[neighbor]; }
  /// A region that becomes a wall is one to all of its neighbors.
  bool changes_all(std::uint32_t into, std::uint32_t from) const {
    return is_wall_[into] == 0 && becomes_wall(into, from);
  }
  /// A region that was large and thick enough stays so, whatever chips join it.
  bool too_small(std::uint32_t r) const { return is_chip_[r] != 0 || points_[r] < min_points_; }
  void merge(std::uint32_t into, std::uint32_t from, const BorderEvidence& between);

 private:
  bool is_chip(double voxels, double contacts) const;
  bool is_wall(double voxels, const Vec3& normal_sum) const;
  bool becomes_wall(std::uint32_t into, std::uint32_t from) const;
  double size_term(double voxels) const;

  BorderConstants constants_;
  std::uint32_t min_points_;
  double wall_size_ = 0;  // voxels
  std::vector<BorderEvidence> evidence_;
  std::vector<double> voxels_;
  std::vector<Vec3> normal_sum_;       // over the voxels
  std::vector<std::uint8_t> is_wall_;  // or floor
  std::vector<double> contacts_;       // with all neighbors
  std::vector<std::uint8_t> is_chip_;  // or smaller than smallest_size
  std::vector<double> size_term_;      // which a region adds to the dissimilarity to a larger one
  std::vector<std::uint32_t> points_;
};

}  // namespace segserve
