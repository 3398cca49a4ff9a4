// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "core/tracking/predicted_track.hpp"
#include "core/tracking/scene_tree.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::tracking {

inline constexpr std::uint32_t kNoTrack = std::numeric_limits<std::uint32_t>::max();

/// Finds the leaves near a place. They lie in rows along x, each a few supervoxels high and deep, wherever others are.
class LeafIndex {
 public:
  explicit LeafIndex(const SceneTree& scene);

  /// Calls each(leaf, squared distance) for the leaves within `radius` meters of a place, in any order.
  template <typename Each>
  void for_each_near(const Vec3& place, double radius, Each&& each) const {
    const auto [low_y, high_y] = rows_around(place.y, radius);
    const auto [low_z, high_z] = rows_around(place.z, radius);
    for (std::int64_t z = low_z; z <= high_z; ++z) {
      for (auto row = std::ranges::lower_bound(rows_, Row{z, low_y, 0}); row < rows_.end() - 1 && row->is_at(z, high_y);
           ++row) {
        for (std::uint32_t i = first_from(place.x - radius, row[0].begin, row[1].begin); i < row[1].begin; ++i) {
          const Vec3 d = centers_[i] - place;
          if (d.x > radius) break;
          const double squared = dot(d, d);
          if (squared <= radius * radius) each(leaves_[i], squared);
        }
      }
    }
  }

 private:
  /// The leaves from `begin` on, up to that of the next row.
  struct Row {
    std::int64_t z, y;
    std::uint32_t begin;
    /// Whether the row is in this layer, and not behind the last row.
    bool is_at(std::int64_t layer, std::int64_t last) const { return z == layer && y <= last; }
    auto operator<=>(const Row&) const = default;
  };

  std::int64_t row_of(double v) const;
  std::pair<std::int64_t, std::int64_t> rows_around(double v, double radius) const {
    return {row_of(v - radius), row_of(v + radius)};
  }
  /// The first of the leaves of a row, [begin, end), whose x is not below the limit; `end` if there is none.
  std::uint32_t first_from(double limit, std::uint32_t begin, std::uint32_t end) const;

  double rows_per_meter_ = 0;
  std::vector<Row> rows_;              // by z, then y; the last one is behind all leaves
  std::vector<std::uint32_t> leaves_;  // by row, then x
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
