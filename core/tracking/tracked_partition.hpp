// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/tracking/predicted_track.hpp"
#include "core/tracking/scene_tree.hpp"
#include "segserve/merge_tree.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::tracking {

/// The cut of a frame, changed so that the nodes of the tracks are segments.
struct TrackedPartition {
  Cut cut;
  std::vector<bool> differs;                       ///< of segment k + 1: whether it is none of the cut's segments
  std::vector<std::uint32_t> track_of_segment;     ///< of segment k + 1: index of a track, or kNoTrack
  std::vector<std::vector<std::uint32_t>> leaves;  ///< of segment k + 1, ascending
  std::vector<std::uint64_t> points;               ///< of segment k + 1
};

/// `node_of_track` has nodes that do not nest, or kNoNode. What the cut merges with a track's node without being part
/// of it becomes part of the track beside it in the tree, or a segment of its own if it is larger than that. A smaller
/// segment that consists of what belonged to a trusted track becomes part of it, too. `track_of_leaf` is that of
/// claim_leaves. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<TrackedPartition> make_partition(const SceneTree& scene, std::span<const PredictedTrack> tracks,
                                                std::span<const std::uint32_t> track_of_leaf,
                                                std::span<const std::uint32_t> node_of_track, const StopToken& stop);

/// For each track, the one whose segment holds most of the area that belonged to it; kNoTrack if there is none.
std::vector<std::uint32_t> find_heirs(const SceneTree& scene, std::span<const std::uint32_t> track_of_leaf,
                                      const TrackedPartition& partition, std::size_t tracks);

}  // namespace segserve::tracking
