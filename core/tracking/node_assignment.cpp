// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/node_assignment.hpp"

#include <algorithm>
#include <numeric>

#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"
#include "core/tracking/leaf_claims.hpp"

namespace segserve::tracking {
namespace {

constexpr double kUnseenWeight = 0.3;  // of area that no track claims
constexpr double kHiddenWeight = 0.3;  // of area of the track that is nowhere, because it may be hidden
constexpr double kCutBonus = 0.05;     // for segments of the cut
constexpr double kBonusLeaves = 40;    // the area of so many supervoxels at most, of which kCutBonus is taken
constexpr double kLeastFit = 0.3;
constexpr std::size_t kMostCandidates = 6;
constexpr std::uint32_t kMostSteps = 4096;

void keep_best(std::vector<NodeCandidate>& candidates) {
  std::ranges::stable_sort(candidates, std::ranges::greater{}, &NodeCandidate::score);
  if (candidates.size() > kMostCandidates) candidates.resize(kMostCandidates);
}

class BranchAndBound {
 public:
  BranchAndBound(const SceneTree& scene, const std::vector<std::vector<NodeCandidate>>& candidates)
      : scene_(scene), candidates_(candidates), order_(candidates.size()), chosen_(candidates.size(), kNoNode) {
    std::iota(order_.begin(), order_.end(), 0U);
    std::ranges::stable_sort(order_, std::ranges::greater{}, [&](std::uint32_t t) { return best_score(t); });
    bound_.assign(order_.size() + 1, 0);
    for (std::size_t i = order_.size(); i-- > 0;) bound_[i] = bound_[i + 1] + best_score(order_[i]);
  }

  std::vector<std::uint32_t> run() {
    descend(0, 0);
    return best_;
  }

 private:
  double best_score(std::uint32_t t) const { return candidates_[t].empty() ? 0 : candidates_[t].front().score; }

  /// Chooses for the tracks order_[i] and later; those before have chosen nodes with the sum `score`.
  void descend(std::size_t i, double score) {
    if (!best_.empty() && (score + bound_[i] <= best_sum_ || steps_ >= kMostSteps)) return;
    ++steps_;
    if (i == order_.size()) {
      best_ = chosen_, best_sum_ = score;
      return;
    }
    const std::uint32_t t = order_[i];
    for (const NodeCandidate& candidate : candidates_[t]) {
      if (!is_free(candidate.node, i)) continue;
      chosen_[t] = candidate.node;
      descend(i + 1, score + candidate.score);
    }
    chosen_[t] = kNoNode;
    descend(i + 1, score);
  }

  bool is_free(std::uint32_t node, std::size_t i) const {
    return std::none_of(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(i),
                        [&](std::uint32_t t) { return chosen_[t] != kNoNode && scene_.nest(chosen_[t], node); });
  }

  const SceneTree& scene_;
  const std::vector<std::vector<NodeCandidate>>& candidates_;
  std::vector<std::uint32_t> order_, chosen_, best_;
  std::vector<double> bound_;  // the most that the tracks from order_[i] on can add
  double best_sum_ = 0;
  std::uint32_t steps_ = 0;
};

}  // namespace

absl::StatusOr<std::vector<std::vector<NodeCandidate>>> find_candidates(const SceneTree& scene,
                                                                        std::span<const PredictedTrack> tracks,
                                                                        std::span<const std::uint32_t> track_of_leaf,
                                                                        const StopToken& stop) {
  StopCheck check(stop);
  const std::size_t m = scene.leaf_count();
  std::vector<double> claimed(scene.node_count(), 0);  // area below each node that any track claims
  for (std::size_t leaf = 0; leaf < m; ++leaf)
    claimed[leaf] = track_of_leaf[leaf] == kNoTrack ? 0 : scene.leaf_area(leaf);
  for (std::size_t n = m; n < scene.node_count(); ++n) claimed[n] = claimed[scene.left(n)] + claimed[scene.right(n)];
  std::vector<std::vector<std::uint32_t>> leaves(tracks.size());
  for (std::uint32_t leaf = 0; leaf < m; ++leaf) {
    if (track_of_leaf[leaf] != kNoTrack) leaves[track_of_leaf[leaf]].push_back(leaf);
  }

  const double most_bonus = kBonusLeaves * math::kPi * scene.leaf_radius() * scene.leaf_radius();
  std::vector<std::vector<NodeCandidate>> candidates(tracks.size());
  std::vector<double> own(scene.node_count());  // area below each node that the track at hand claims
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (leaves[t].empty()) continue;
    double all = 0;
    for (const std::uint32_t leaf : leaves[t]) all += scene.leaf_area(leaf);
    // If a track claims more than its area, the rest is mostly neighbors of which no track remembers a supervoxel
    // nearby.
    const double found = std::min(all, tracks[t].area), hidden = tracks[t].area - found;
    const double bonus = kCutBonus * std::min(tracks[t].area, most_bonus);
    std::fill(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(m), 0);
    for (const std::uint32_t leaf : leaves[t]) own[leaf] = scene.leaf_area(leaf);
    if (check.after(scene.node_count())) break;
    for (std::size_t n = m; n < scene.node_count(); ++n) own[n] = own[scene.left(n)] + own[scene.right(n)];
    for (std::size_t n = 0; n < scene.node_count(); ++n) {
      if (own[n] <= kLeastFit * kUnseenWeight * scene.area(n)) continue;
      const bool is_segment = scene.is_segment(n);
      if (!is_segment && !(tracks[t].is_trusted && n < scene.connected_nodes())) continue;
      const double others = claimed[n] - own[n], unseen = scene.area(n) - claimed[n];
      const double wrong = others + kUnseenWeight * unseen,
                   missed = std::max(0.0, found - own[n]) + kHiddenWeight * hidden;
      const double fit = own[n] / (own[n] + wrong + missed);
      if (fit < kLeastFit) continue;
      candidates[t].push_back({static_cast<std::uint32_t>(n), tracks[t].area * fit + (is_segment ? bonus : 0)});
    }
    if (check.stopped()) break;
    keep_best(candidates[t]);
  }
  if (const absl::Status status = check.status(); !status.ok()) return status;
  return candidates;
}

std::vector<std::uint32_t> assign_nodes(const SceneTree& scene,
                                        const std::vector<std::vector<NodeCandidate>>& candidates) {
  return BranchAndBound(scene, candidates).run();
}

}  // namespace segserve::tracking
