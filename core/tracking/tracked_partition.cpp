// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/tracked_partition.hpp"

#include <algorithm>
#include <compare>
#include <numeric>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/tracking/leaf_claims.hpp"
#include "core/tracking/node_assignment.hpp"

namespace segserve::tracking {
namespace {

constexpr double kLargeRest = 1;  // of the area of the track beside it
constexpr double kMostly = 0.5;   // of the area of a segment that joins a track
constexpr double kHeir = 0.5;     // of the area of a track that ends in the segment of its heir

/// Gives every leaf a group: those below tracks' nodes have the group of the track, others one of their own.
class Grouping {
 public:
  Grouping(const SceneTree& scene, std::span<const std::uint32_t> node_of_track)
      : scene_(scene),
        node_of_track_(node_of_track),
        track_below_(scene.node_count(), kNoTrack),
        group_(scene.node_count(), kNoGroup),
        track_of_group_(node_of_track.size()),
        differs_(node_of_track.size(), false) {
    std::iota(track_of_group_.begin(), track_of_group_.end(), 0U);
  }

  void run(StopCheck& check) {
    for (std::uint32_t t = 0; t < node_of_track_.size(); ++t) {
      if (node_of_track_[t] == kNoNode) continue;
      track_below_[node_of_track_[t]] = t;
      group_[node_of_track_[t]] = t;
    }
    check.for_each(scene_.leaf_count(), scene_.node_count(), [&](std::size_t n) {
      if (track_below_[n] == kNoTrack)
        track_below_[n] = larger(track_below_[scene_.left(n)], track_below_[scene_.right(n)]);
    });
    check.for_each(0, scene_.node_count(), [&](std::size_t i) { visit(scene_.node_count() - 1 - i); });
  }

  /// Lets segments that consist of what belonged to a trusted track have its group.
  void join(std::span<const PredictedTrack> tracks, std::span<const std::uint32_t> track_of_leaf) {
    for (const std::uint32_t segment : scene_.segments()) {
      if (group_[segment] == kNoGroup || track_of_group_[group_[segment]] != kNoTrack) continue;
      const std::uint32_t t = owner(segment, track_of_leaf);
      if (t == kNoTrack || node_of_track_[t] == kNoNode || !tracks[t].is_trusted) continue;
      if (scene_.area(segment) > scene_.area(node_of_track_[t])) continue;
      for (std::size_t i = scene_.begin(segment); i < scene_.end(segment); ++i) group_[scene_.leaf_order()[i]] = t;
      differs_[t] = true;
    }
  }

  std::uint32_t group(std::size_t leaf) const { return group_[leaf]; }
  bool differs(std::uint32_t track) const { return differs_[track] || !scene_.is_segment(node_of_track_[track]); }
  const std::vector<std::uint32_t>& track_of_group() const { return track_of_group_; }

 private:
  static constexpr std::uint32_t kNoGroup = ~std::uint32_t{0};

  std::uint32_t larger(std::uint32_t a, std::uint32_t b) const {
    if (a == kNoTrack || b == kNoTrack) return a == kNoTrack ? b : a;
    return scene_.area(node_of_track_[b]) > scene_.area(node_of_track_[a]) ? b : a;
  }

  /// The track to which most of a segment belonged; kNoTrack if there is none.
  std::uint32_t owner(std::uint32_t segment, std::span<const std::uint32_t> track_of_leaf) const {
    // Whoever has the majority is left over when every two that differ cancel out (Boyer and Moore 1991).
    std::uint32_t candidate = kNoTrack;
    double lead = 0, area = 0;
    for (std::size_t i = scene_.begin(segment); i < scene_.end(segment); ++i) {
      const std::uint32_t leaf = scene_.leaf_order()[i], t = track_of_leaf[leaf];
      if (lead <= 0) candidate = t;
      lead = t == candidate ? lead + scene_.leaf_area(leaf) : lead - scene_.leaf_area(leaf);
      if (lead < 0) candidate = t, lead = -lead;
    }
    for (std::size_t i = scene_.begin(segment); i < scene_.end(segment); ++i) {
      const std::uint32_t leaf = scene_.leaf_order()[i];
      if (track_of_leaf[leaf] == candidate) area += scene_.leaf_area(leaf);
    }
    return area >= kMostly * scene_.area(segment) ? candidate : kNoTrack;
  }

  std::uint32_t new_group() {
    track_of_group_.push_back(kNoTrack);
    return static_cast<std::uint32_t>(track_of_group_.size() - 1);
  }

  /// A node whose parent has been visited. Hands its group down, or lets its children find theirs.
  void visit(std::size_t n) {
    // A segment of the cut, or what JOINED rows leave, in which there is no track.
    if (group_[n] == kNoGroup && track_below_[n] == kNoTrack && n < scene_.cut_nodes()) group_[n] = new_group();
    if (scene_.is_leaf(n)) return;
    const std::uint32_t left = scene_.left(n), right = scene_.right(n);
    if (group_[n] != kNoGroup) {
      group_[left] = group_[right] = group_[n];
    } else if (n < scene_.cut_nodes()) {
      absorb(left, right), absorb(right, left);
    }
  }

  /// Lets the track beside a rest of a segment have it, unless the rest is the larger part.
  void absorb(std::uint32_t rest, std::uint32_t sibling) {
    const std::uint32_t t = track_below_[sibling];
    if (track_below_[rest] != kNoTrack || t == kNoTrack) return;
    if (scene_.area(rest) <= kLargeRest * scene_.area(node_of_track_[t])) group_[rest] = t;
  }

  const SceneTree& scene_;
  std::span<const std::uint32_t> node_of_track_;
  std::vector<std::uint32_t> track_below_;  // the largest track at or below each node
  std::vector<std::uint32_t> group_;        // of each node
  std::vector<std::uint32_t> track_of_group_;
  std::vector<bool> differs_;  // of the tracks: whether segments have joined
};

}  // namespace

absl::StatusOr<TrackedPartition> make_partition(const SceneTree& scene, std::span<const PredictedTrack> tracks,
                                                std::span<const std::uint32_t> track_of_leaf,
                                                std::span<const std::uint32_t> node_of_track, const StopToken& stop) {
  StopCheck check(stop);
  Grouping grouping(scene, node_of_track);
  grouping.run(check);
  grouping.join(tracks, track_of_leaf);
  RETURN_IF_ERROR(check.status());

  const std::size_t m = scene.leaf_count(), groups = grouping.track_of_group().size();
  std::vector<std::uint64_t> points(groups, 0);
  std::vector<std::uint32_t> order;  // of the groups that have leaves, first by their smallest leaf
  std::vector<bool> is_seen(groups, false);
  check.for_each(0, m, [&](std::size_t leaf) {
    const std::uint32_t group = grouping.group(leaf);
    points[group] += scene.node(leaf).points;
    if (!is_seen[group]) order.push_back(group);
    is_seen[group] = true;
  });
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::uint32_t group) { return points[group]; });

  TrackedPartition result;
  std::vector<std::uint32_t> number(groups, 0);
  for (const std::uint32_t group : order) {
    result.track_of_segment.push_back(grouping.track_of_group()[group]);
    result.differs.push_back(group < node_of_track.size() && grouping.differs(group));
    result.points.push_back(points[group]);
    number[group] = static_cast<std::uint32_t>(result.points.size());
  }
  result.leaves.resize(order.size());
  result.cut.segments = static_cast<std::uint32_t>(order.size());
  result.cut.segment_of_leaf.resize(m);
  check.for_each(0, m, [&](std::size_t leaf) {
    const std::uint32_t segment = number[grouping.group(leaf)];
    result.cut.segment_of_leaf[leaf] = segment;
    result.leaves[segment - 1].push_back(static_cast<std::uint32_t>(leaf));
  });
  RETURN_IF_ERROR(check.status());
  return result;
}

std::vector<std::uint32_t> find_heirs(const SceneTree& scene, std::span<const std::uint32_t> track_of_leaf,
                                      const TrackedPartition& partition, std::size_t tracks) {
  struct Claim {
    std::uint32_t track, segment, leaf;
    auto operator<=>(const Claim&) const = default;
  };
  std::vector<Claim> claims;
  for (std::uint32_t leaf = 0; leaf < track_of_leaf.size(); ++leaf) {
    const std::uint32_t t = track_of_leaf[leaf];
    if (t != kNoTrack) claims.push_back({t, partition.cut.segment_of_leaf[leaf] - 1, leaf});
  }
  std::ranges::sort(claims);
  std::vector<double> total(tracks, 0), most(tracks, 0);
  std::vector<std::uint32_t> heirs(tracks, kNoTrack);
  for (std::size_t i = 0; i < claims.size();) {
    const std::uint32_t t = claims[i].track, segment = claims[i].segment;
    double area = 0;
    for (; i < claims.size() && claims[i].track == t && claims[i].segment == segment; ++i) {
      area += scene.leaf_area(claims[i].leaf);
    }
    total[t] += area;
    if (area > most[t]) most[t] = area, heirs[t] = partition.track_of_segment[segment];
  }
  for (std::size_t t = 0; t < tracks; ++t) {
    if (most[t] < kHeir * total[t]) heirs[t] = kNoTrack;
  }
  return heirs;
}

}  // namespace segserve::tracking
