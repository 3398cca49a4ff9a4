// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/leaf_claims.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/stop_check.hpp"
#include "core/math/elementary.hpp"

namespace segserve::tracking {
namespace {

constexpr double kColor = 40;         // deviation of the color of a place between frames, in RGB
constexpr double kOtherColor = 100;   // colors that differ by more are not those of one place
constexpr double kReach = 2;          // of a signature, in radii of the supervoxels that it stands for
constexpr double kLongestReach = 4;   // the same, in radii of the supervoxels of the frame
constexpr double kCertain = 0.75;     // share of a track's signatures with which it rests
constexpr double kFound = 0.6;        // share of a track's signatures with which the search ends
constexpr double kLostPenalty = 1.5;  // on the distance to tracks that are out of sight
constexpr double kBoxMargin = 1.5;    // in radii of supervoxels
constexpr double kSameSize = 3;       // ratio of areas
constexpr double kSlack = 0.05;       // meters that anything may seem to have moved
constexpr std::size_t kMostPlaces = 8;
constexpr double kSpeedDecay = 10;  // frames out of sight after which a track is expected to rest

/// How far from its signatures the supervoxels of a track may be.
double reach(const SceneTree& scene, const PredictedTrack& track) {
  const double count = std::max<double>(1, static_cast<double>(track.signatures.size()));
  const double radius = std::sqrt(track.area / (math::kPi * count));
  return std::clamp(kReach * radius, kReach * scene.leaf_radius(), kLongestReach * scene.leaf_radius());
}

double squared_color_distance(const Vec3& a, const Vec3& b) {
  const Vec3 d = a - b;
  return dot(d, d);
}

class ShiftSearch {
 public:
  ShiftSearch(const SceneTree& scene, const LeafIndex& index, double seconds, double max_speed, StopCheck& check)
      : scene_(scene), index_(index), seconds_(seconds), max_speed_(max_speed), check_(check) {}

  Vec3 shift_of(const PredictedTrack& track) {
    Vec3 best;
    double most = found(track, best);
    const auto consider = [&](const Vec3& shift) {
      const double share = found(track, shift);
      if (share > most) most = share, best = shift;
    };
    if (most >= kCertain) return best;
    if (track.frames_unseen <= kSpeedDecay) consider(seconds_ * track.frames_unseen * track.velocity);
    if (most >= kFound) return best;
    for (const std::uint32_t node : similar_segments(track)) consider(scene_.node(node).center() - track.center);
    return best;
  }

 private:
  /// The share of the signatures that have a supervoxel close by, each counted by how close.
  double found(const PredictedTrack& track, const Vec3& shift) {
    if (track.signatures.empty() || check_.stopped()) return 0;
    const double radius = reach(scene_, track);
    double sum = 0;
    std::uint64_t work = 1;
    for (const PredictedTrack::Signature& signature : track.signatures) {
      double closest = radius * radius;
      index_.for_each_near(signature.place + shift, radius, [&](std::uint32_t leaf, double squared) {
        ++work;
        if (squared_color_distance(scene_.leaf_color(leaf), signature.color) > kOtherColor * kOtherColor) return;
        closest = std::min(closest, squared);
      });
      sum += 1 - closest / (radius * radius);
    }
    check_.after(work);
    return sum / static_cast<double>(track.signatures.size());
  }

  /// The closest segments of about the size and color of the track that it can have reached, kMostPlaces at most.
  std::vector<std::uint32_t> similar_segments(const PredictedTrack& track) {
    struct Place {
      double distance;
      std::uint32_t node;
    };
    const double farthest = kSlack + max_speed_ * seconds_ * track.frames_unseen;
    std::vector<Place> closest;  // by distance, and by the order of the segments
    check_.for_each(0, scene_.segments().size(), [&](std::size_t i) {
      const std::uint32_t node = scene_.segments()[i];
      const double area = scene_.area(node);
      if (std::max(area, track.area) > kSameSize * std::min(area, track.area)) return;
      if (squared_color_distance(scene_.node(node).color(), track.color) > kOtherColor * kOtherColor) return;
      const double distance = norm(scene_.node(node).center() - track.center);
      const double limit = closest.size() < kMostPlaces ? farthest : closest.back().distance;
      if (distance > limit || (closest.size() == kMostPlaces && distance == limit)) return;
      closest.insert(std::ranges::upper_bound(closest, distance, {}, &Place::distance), {distance, node});
      if (closest.size() > kMostPlaces) closest.pop_back();
    });
    std::vector<std::uint32_t> nodes;
    nodes.reserve(closest.size());
    for (const Place& place : closest) nodes.push_back(place.node);
    return nodes;
  }

  const SceneTree& scene_;
  const LeafIndex& index_;
  double seconds_, max_speed_;
  StopCheck& check_;
};

bool box_holds(const PredictedTrack& track, const Vec3& place, double margin) {
  const Vec3 d = place - track.center - track.shift;
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::fabs(dot(d, track.axes[k])) > track.half_extents[k] + margin) return false;
  }
  return true;
}

/// The smallest track whose box holds a leaf.
std::uint32_t box_around(const SceneTree& scene, std::span<const PredictedTrack> tracks, std::uint32_t leaf) {
  std::uint32_t best = kNoTrack;
  for (std::uint32_t t = 0; t < tracks.size(); ++t) {
    if (best != kNoTrack && tracks[t].volume() >= tracks[best].volume()) continue;
    if (tracks[t].is_lost || !box_holds(tracks[t], scene.leaf_center(leaf), kBoxMargin * scene.leaf_radius())) continue;
    const double color = squared_color_distance(scene.leaf_color(leaf), tracks[t].color);
    if (color <= kOtherColor * kOtherColor) best = t;
  }
  return best;
}

}  // namespace

LeafIndex::LeafIndex(const SceneTree& scene) {
  const double height = kLongestReach * scene.leaf_radius();
  rows_per_meter_ = height > 0 ? 1 / height : 0;
  const auto m = static_cast<std::uint32_t>(scene.leaf_count());
  std::vector<Row> row_of_leaf(m);
  for (std::uint32_t leaf = 0; leaf < m; ++leaf) {
    const Vec3& p = scene.leaf_center(leaf);
    row_of_leaf[leaf] = {row_of(p.z), row_of(p.y), 0};
  }
  leaves_.resize(m);
  std::iota(leaves_.begin(), leaves_.end(), 0U);
  std::ranges::sort(leaves_, [&](std::uint32_t a, std::uint32_t b) {
    if (row_of_leaf[a] != row_of_leaf[b]) return row_of_leaf[a] < row_of_leaf[b];
    return scene.leaf_center(a).x < scene.leaf_center(b).x;
  });
  centers_.reserve(m);
  for (const std::uint32_t leaf : leaves_) {
    Row row = row_of_leaf[leaf];
    const bool is_new = rows_.empty() || rows_.back().z != row.z || rows_.back().y != row.y;
    row.begin = static_cast<std::uint32_t>(centers_.size());
    if (is_new) rows_.push_back(row);
    centers_.push_back(scene.leaf_center(leaf));
  }
  rows_.push_back({std::numeric_limits<std::int64_t>::max(), 0, m});
}

std::int64_t LeafIndex::row_of(double v) const {
  constexpr double kMost = 1e15;  // beyond which doubles do not tell rows apart
  const double row = std::floor(v * rows_per_meter_);
  return row >= -kMost ? static_cast<std::int64_t>(std::min(row, kMost)) : static_cast<std::int64_t>(-kMost);
}

std::uint32_t LeafIndex::first_from(double limit, std::uint32_t begin, std::uint32_t end) const {
  const auto found = std::ranges::lower_bound(centers_.begin() + begin, centers_.begin() + end, limit, {}, &Vec3::x);
  return static_cast<std::uint32_t>(found - centers_.begin());
}

absl::Status find_shifts(const SceneTree& scene, const LeafIndex& index, double seconds, double max_speed,
                         const StopToken& stop, std::vector<PredictedTrack>& tracks) {
  StopCheck check(stop);
  ShiftSearch search(scene, index, seconds, max_speed, check);
  for (PredictedTrack& track : tracks) track.shift = search.shift_of(track);
  return check.status();
}

absl::Status claim_leaves(const SceneTree& scene, const LeafIndex& index, std::span<const PredictedTrack> tracks,
                          const StopToken& stop, std::vector<std::uint32_t>& track_of_leaf) {
  StopCheck check(stop);
  track_of_leaf.assign(scene.leaf_count(), kNoTrack);
  std::vector<double> cost(scene.leaf_count(), std::numeric_limits<double>::infinity());
  const auto claim = [&](std::uint32_t t) {
    const double radius = reach(scene, tracks[t]);
    const double scale = (tracks[t].is_lost ? kLostPenalty : 1) / (radius * scene.leaf_radius());
    for (const PredictedTrack::Signature& signature : tracks[t].signatures) {
      std::uint64_t work = 1;
      index.for_each_near(signature.place + tracks[t].shift, radius, [&](std::uint32_t leaf, double squared) {
        ++work;
        const double color = squared_color_distance(scene.leaf_color(leaf), signature.color);
        if (color > kOtherColor * kOtherColor) return;
        const double distance = scale * squared + color / (kColor * kColor);
        if (distance < cost[leaf]) cost[leaf] = distance, track_of_leaf[leaf] = t;
      });
      if (check.after(work)) return;
    }
  };
  const auto competes = [](const PredictedTrack& track) { return !track.is_lost || track.is_established; };
  for (std::uint32_t t = 0; t < tracks.size(); ++t) {
    if (competes(tracks[t])) claim(t);
  }
  // Others take what is left.
  for (std::size_t leaf = 0; leaf < scene.leaf_count(); ++leaf) {
    if (track_of_leaf[leaf] != kNoTrack) cost[leaf] = 0;
  }
  for (std::uint32_t t = 0; t < tracks.size(); ++t) {
    if (!competes(tracks[t])) claim(t);
  }
  check.for_each(0, scene.leaf_count(), [&](std::size_t leaf) -> std::uint64_t {
    if (track_of_leaf[leaf] != kNoTrack) return 1;
    track_of_leaf[leaf] = box_around(scene, tracks, static_cast<std::uint32_t>(leaf));
    return 1 + tracks.size();
  });
  return check.status();
}

}  // namespace segserve::tracking
