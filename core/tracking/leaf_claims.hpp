// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "core/tracking/predicted_track.hpp"
#include "core/tracking/scene_tree.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::tracking {

inline constexpr std::uint32_t kNoTrack = std::numeric_limits<std::uint32_t>::max();

/// Finds the leaves near a place: a grid of cells in x and y, none of which is smaller than a supervoxel.
class LeafIndex {
 public:
  explicit LeafIndex(const SceneTree& scene);

  /// Calls each(leaf, squared distance) for the leaves within `radius` meters of a place.
  template <typename Each>
  void for_each_near(const Vec3& place, double radius, Each&& each) const {
    const std::uint32_t first = x_.cell(place.x - radius), last = x_.cell(place.x + radius);
    for (std::uint32_t row = y_.cell(place.y - radius); row <= y_.cell(place.y + radius); ++row) {
      const std::size_t cells = std::size_t{row} * kCells;
      for (std::uint32_t i = begin_[cells + first]; i < begin_[cells + last + 1]; ++i) {
        const Vec3 d = centers_[i] - place;
        const double squared = dot(d, d);
        if (squared <= radius * radius) each(leaves_[i], squared);
      }
    }
  }

 private:
  static constexpr std::uint32_t kCells = 64;  ///< along each axis

  /// Cells along an axis; the first and the last hold whatever lies beyond them.
  struct Axis {
    double low = 0, cells_per_meter = 0;
    std::uint32_t cell(double v) const {
      const double exact = (v - low) * cells_per_meter;
      return exact >= 1 ? static_cast<std::uint32_t>(std::min(exact, kCells - 1.0)) : 0;  // also for NaN
    }
  };

  Axis x_, y_;
  std::vector<std::uint32_t> begin_;   // kCells^2 + 1: of each cell in the lists below
  std::vector<std::uint32_t> leaves_;  // by cell, row by row
  std::vector<Vec3> centers_;          // of these
};

/// Sets the shift of each track by which most of its supervoxels are found: none, as far as it moves in `seconds`, or
/// onto a segment that looks alike and is not farther away than it can have moved.
absl::Status find_shifts(const SceneTree& scene, const LeafIndex& index, double seconds, double max_speed,
                         const StopToken& stop, std::vector<PredictedTrack>& tracks);

/// The track that each of the m leaves belonged to, or kNoTrack: that of the closest signature, if there is one nearby
/// of a similar color; else the smallest track whose box holds the leaf.
absl::Status claim_leaves(const SceneTree& scene, const LeafIndex& index, std::span<const PredictedTrack> tracks,
                          const StopToken& stop, std::vector<std::uint32_t>& track_of_leaf);

}  // namespace segserve::tracking
