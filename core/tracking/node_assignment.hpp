// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/tracking/predicted_track.hpp"
#include "core/tracking/scene_tree.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::tracking {

inline constexpr std::uint32_t kNoNode = ~std::uint32_t{0};

/// A node that may be a track, and how much of the track it is: area times fit, above 0, square meters. So the sum of
/// scores is the area that is explained, and a fragment does not count as much as the object that it came off.
struct NodeCandidate {
  std::uint32_t node = 0;
  double score = 0;
};

/// The nodes that fit each track best, best first: those that consist of the leaves that it claims (Tversky 1977).
/// Segments of the cut are preferred. A track that is out of sight, or not trusted, is a segment of the cut.
absl::StatusOr<std::vector<std::vector<NodeCandidate>>> find_candidates(const SceneTree& scene,
                                                                        std::span<const PredictedTrack> tracks,
                                                                        std::span<const std::uint32_t> track_of_leaf,
                                                                        const StopToken& stop);

/// The node of each track, or kNoNode: of all choices in which no two nodes nest, the one with the greatest sum of
/// scores, by branch and bound. After a fixed number of steps it is the best one that was found, which is at least as
/// good as to let the best fits choose first.
std::vector<std::uint32_t> assign_nodes(const SceneTree& scene,
                                        const std::vector<std::vector<NodeCandidate>>& candidates);

}  // namespace segserve::tracking
