// SPDX-License-Identifier: Apache-2.0
#include "segserve/tracking.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <ranges>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/tracking/leaf_claims.hpp"
#include "core/tracking/node_assignment.hpp"
#include "core/tracking/predicted_track.hpp"
#include "core/tracking/rigid_check.hpp"
#include "core/tracking/rigid_motion.hpp"
#include "core/tracking/scene_tree.hpp"
#include "core/tracking/support_frame.hpp"
#include "core/tracking/track_update.hpp"
#include "core/tracking/tracked_partition.hpp"
#include "core/tracking/view_motion.hpp"
#include "fmt/format.h"

namespace segserve {
namespace tracking {
namespace {

constexpr double kUsualSeconds = 0.1;  // between two frames, if that is not known
constexpr double kLeastSeconds = 1e-3, kMostSeconds = 10;
constexpr double kLandmarkShare = 0.25;  // of the largest segment, if there is a plane: what is larger is no landmark
constexpr double kLandmarkTolerance = 1.5;                // in radii of supervoxels
constexpr double kMajority = 0.5;                         // of an area
constexpr int kMostTrust = 120, kBelief = 2, kDoubt = 1;  // so that one frame in three is enough to keep a track
constexpr std::uint32_t kKeptPerSeen = 2;                 // frames out of sight that each frame in sight is worth

double seconds_between(const std::optional<double>& before, const std::optional<double>& now) {
  return before && now ? std::clamp(*now - *before, kLeastSeconds, kMostSeconds) : kUsualSeconds;
}

std::optional<Plane> to_plane(const std::optional<TrackState::Plane>& plane) {
  if (!plane) return std::nullopt;
  return Plane{{plane->normal[0], plane->normal[1], plane->normal[2]}, plane->offset};
}

std::optional<TrackState::Plane> to_state(const std::optional<Plane>& plane) {
  if (!plane) return std::nullopt;
  const Vec3& n = plane->normal;
  return TrackState::Plane{{static_cast<float>(n.x), static_cast<float>(n.y), static_cast<float>(n.z)},
                           static_cast<float>(plane->offset)};
}

/// The largest landmarks that are not too large, in the frame of the support plane.
std::vector<Landmark> largest(std::vector<Landmark> all, const RigidMotion& support, double area) {
  std::erase_if(all, [area](const Landmark& landmark) { return landmark.area > area; });
  std::ranges::stable_sort(all, std::ranges::greater{}, &Landmark::area);
  all.resize(std::min(all.size(), kMostLandmarks));
  const RigidMotion to_support = support.inverse();
  for (Landmark& landmark : all) landmark.place = to_support(landmark.place);
  return all;
}

/// The motion from the frame before to this one, by the support plane and what stands on it.
RigidMotion estimate_motion(const TrackState& previous, const SceneTree& scene, const View& view,
                            const std::optional<Plane>& plane) {
  std::vector<Landmark> before, now;
  double largest_area = 0;
  for (const std::uint32_t node : scene.segments()) {
    const NodeFeatures& features = scene.node(node);
    now.push_back({features.center(), features.color(), features.area});
    largest_area = std::max(largest_area, features.area);
  }
  for (const PredictedTrack& track : predict(previous, {})) {
    if (!track.is_lost) before.push_back({track.center, track.color, track.area});
  }
  std::optional<Plane> plane_before = to_plane(previous.plane), plane_now = plane;
  if (!plane_before || !plane_now) plane_before = plane_now = std::nullopt;
  const RigidMotion support_before = support_frame(plane_before, view), support_now = support_frame(plane_now, view);
  const double area = plane_now ? kLandmarkShare * largest_area : largest_area;
  const RigidMotion along =
      match_landmarks(largest(std::move(before), support_before, area), largest(std::move(now), support_now, area),
                      kLandmarkTolerance * scene.leaf_radius());
  return support_now.after(along.after(support_before.inverse()));
}

/// The work of one call of `track`.
class Tracker {
 public:
  Tracker(const SceneTree& scene, const TrackState& previous, const TrackOptions& options, const StopToken& stop)
      : scene_(scene), previous_(previous), options_(options), stop_(stop) {}

  absl::StatusOr<Tracking> run(const RigidMotion& motion, std::optional<TrackState::Plane> plane) {
    seconds_ = seconds_between(previous_.time, options_.time);
    predicted_ = predict(previous_, motion);
    const LeafIndex index(scene_);
    RETURN_IF_ERROR(find_shifts(scene_, index, seconds_, options_.max_speed, stop_, predicted_));
    RETURN_IF_ERROR(claim_leaves(scene_, index, predicted_, stop_, track_of_leaf_));
    ASSIGN_OR_RETURN(const auto candidates, find_candidates(scene_, predicted_, track_of_leaf_, stop_));
    node_of_track_ = assign_nodes(scene_, candidates);
    ASSIGN_OR_RETURN(partition_, make_partition(scene_, predicted_, track_of_leaf_, node_of_track_, stop_));

    result_.motion = to_transform(motion);
    result_.state.time = options_.time;
    result_.state.pose = options_.pose;
    result_.state.plane = plane;
    result_.state.next_id = previous_.next_id;
    result_.track_of_segment.assign(partition_.cut.segments, 0);
    follow();
    find_births();
    find_losses();
    std::ranges::sort(result_.state.tracks, {}, &TrackState::Track::id);
    std::ranges::sort(result_.events, {}, [](const TrackEvent& e) { return std::pair(e.track, e.kind); });
    result_.differs =
        partition_.cut.segments != scene_.segments().size() || std::ranges::count(partition_.differs, true) > 0;
    result_.cut = std::move(partition_.cut);
    RETURN_IF_ERROR(stop_.check());
    return std::move(result_);
  }

 private:
  void add_event(TrackEventKind kind, std::uint64_t track, std::uint64_t other = 0) {
    result_.events.push_back({kind, track, other});
  }

  /// The tracks that have a segment in this frame.
  void follow() {
    for (std::size_t s = 0; s < partition_.track_of_segment.size(); ++s) {
      const std::uint32_t t = partition_.track_of_segment[s];
      if (t == kNoTrack) continue;
      const TrackState::Track& before = previous_.tracks[t];
      TrackState::Track track = describe_track(scene_, partition_.leaves[s]);
      track.id = before.id;
      track.age = before.age < ~std::uint32_t{0} ? before.age + 1 : before.age;
      const int trust = before.trust + (partition_.differs[s] ? -kDoubt : kBelief);
      track.trust = static_cast<std::uint16_t>(std::clamp<int>(trust, 0, kMostTrust));
      track.velocity = new_velocity(predicted_[t], track.center, seconds_ * predicted_[t].frames_unseen);
      if (before.lost > 0) add_event(TrackEventKind::kRecovered, track.id);
      result_.track_of_segment[s] = track.id;
      result_.state.tracks.push_back(std::move(track));
    }
  }

  /// The track of the frame before to which most of the segment belonged; kNoTrack if there is none.
  std::uint32_t origin(std::span<const std::uint32_t> leaves) const {
    std::vector<double> area(predicted_.size(), 0);
    double total = 0;
    for (const std::uint32_t leaf : leaves) {
      total += scene_.leaf_area(leaf);
      if (track_of_leaf_[leaf] != kNoTrack) area[track_of_leaf_[leaf]] += scene_.leaf_area(leaf);
    }
    const auto most = std::ranges::max_element(area);
    return most != area.end() && *most >= kMajority * total ? static_cast<std::uint32_t>(most - area.begin())
                                                            : kNoTrack;
  }

  void find_births() {
    for (std::size_t s = 0; s < partition_.track_of_segment.size(); ++s) {
      if (partition_.track_of_segment[s] != kNoTrack || partition_.points[s] < options_.min_points) continue;
      const bool has_ids = result_.state.next_id < std::numeric_limits<std::uint64_t>::max();
      if (result_.state.tracks.size() == TrackState::kMostTracks || !has_ids) return;
      TrackState::Track track = describe_track(scene_, partition_.leaves[s]);
      track.id = result_.state.next_id++;
      const std::uint32_t t = origin(partition_.leaves[s]);
      const bool came_off = t != kNoTrack && node_of_track_[t] != kNoNode;
      if (came_off)
        add_event(TrackEventKind::kSplit, track.id, previous_.tracks[t].id);
      else
        add_event(TrackEventKind::kBorn, track.id);
      result_.track_of_segment[s] = track.id;
      result_.state.tracks.push_back(std::move(track));
    }
  }

  /// The tracks without a segment. Of too many, those are kept that were seen last.
  void find_losses() {
    std::vector<std::uint32_t> lost;
    for (std::uint32_t t = 0; t < node_of_track_.size(); ++t) {
      if (node_of_track_[t] == kNoNode) lost.push_back(t);
    }
    if (lost.empty()) return;
    const std::vector<std::uint32_t> heirs = find_heirs(scene_, track_of_leaf_, partition_, previous_.tracks.size());
    std::ranges::stable_sort(lost, {}, [&](std::uint32_t t) { return previous_.tracks[t].lost; });
    for (const std::uint32_t t : lost) {
      const TrackState::Track& track = previous_.tracks[t];
      const bool is_over = track.lost >= options_.keep_lost || track.lost >= kKeptPerSeen * std::uint64_t{track.age};
      if (is_over || result_.state.tracks.size() == TrackState::kMostTracks) {
        add_event(TrackEventKind::kEnded, track.id);
        continue;
      }
      if (track.lost == 0) {
        const std::uint32_t other = heirs[t];
        if (other == kNoTrack)
          add_event(TrackEventKind::kLost, track.id);
        else
          add_event(TrackEventKind::kMerged, track.id, previous_.tracks[other].id);
      }
      result_.state.tracks.push_back(carry_on(track, predicted_[t]));
    }
  }

  const SceneTree& scene_;
  const TrackState& previous_;
  const TrackOptions& options_;
  const StopToken& stop_;
  double seconds_ = kUsualSeconds;
  std::vector<PredictedTrack> predicted_;     // of the tracks of the frame before
  std::vector<std::uint32_t> track_of_leaf_;  // to which of these each leaf belonged, or kNoTrack
  std::vector<std::uint32_t> node_of_track_;  // of these, or kNoNode
  TrackedPartition partition_;
  Tracking result_;
};

absl::Status check_input(const Segmentation& segmentation, const TrackOptions& options) {
  if (const std::vector<FieldViolation> faults = violations(options); !faults.empty()) {
    std::string text;
    for (const FieldViolation& fault : faults) {
      text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", fault.field, fault.description);
    }
    return absl::InvalidArgumentError(text);
  }
  const std::size_t m = segmentation.tree.leaf_count();
  if (segmentation.supervoxel_features.size() == m && segmentation.segments <= m) return absl::OkStatus();
  return absl::InvalidArgumentError(
      fmt::format("a segmentation with the features of its {} supervoxels is needed; it has {}", m,
                  segmentation.supervoxel_features.size()));
}

}  // namespace
}  // namespace tracking

std::vector<FieldViolation> violations(const TrackOptions& options) {
  std::vector<FieldViolation> faults;
  const auto require = [&](bool holds, std::string_view field, std::string fault) {
    if (!holds) faults.push_back({std::string(field), std::move(fault)});
  };
  constexpr std::uint32_t kMostPoints = 0x7FFFFFFF, kMostLost = 1000;
  constexpr double kHighestSpeed = 100;
  require(!options.pose || tracking::is_rigid(*options.pose), "pose", "is no rigid motion");
  require(!options.time || (*options.time >= -tracking::kLatest && *options.time <= tracking::kLatest), "time",
          "is not in [-1e12, 1e12] s");
  require(options.max_speed >= 0 && options.max_speed <= kHighestSpeed, "max_speed",
          fmt::format("{} is not in [0, 100] m/s", options.max_speed));
  require(options.keep_lost <= kMostLost, "keep_lost", fmt::format("{} is not in [0, 1000]", options.keep_lost));
  require(options.min_points >= 1 && options.min_points <= kMostPoints, "min_points",
          fmt::format("{} is not in [1, 2147483647]", options.min_points));
  return faults;
}

absl::Status apply(const Tracking& tracking, const StopToken& stop, Segmentation& segmentation) {
  if (!tracking.differs) return absl::OkStatus();
  StopCheck check(stop);
  check.for_each(0, segmentation.supervoxels.size(), [&](std::size_t i) {
    const std::uint32_t supervoxel = segmentation.supervoxels[i];
    segmentation.labels[i] = supervoxel == 0 ? 0 : tracking.cut.segment_of_leaf[supervoxel - 1];
  });
  RETURN_IF_ERROR(check.status());
  segmentation.segments = tracking.cut.segments;
  segmentation.is_cut = false;
  segmentation.statistics.clear();
  return absl::OkStatus();
}

std::string_view name(TrackEventKind kind) {
  static constexpr std::string_view kNames[] = {"born", "split", "lost", "merged", "recovered", "ended"};
  return kNames[static_cast<std::size_t>(kind)];
}

absl::StatusOr<Tracking> track(const Segmentation& segmentation, const View& view, const TrackState& previous,
                               const TrackOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(tracking::check_input(segmentation, options));
  ASSIGN_OR_RETURN(const auto scene, tracking::SceneTree::make(segmentation, view, stop));
  const auto plane = tracking::find_plane(scene, segmentation, view, tracking::to_plane(previous.plane));
  const bool is_posed = previous.pose && options.pose;
  const tracking::RigidMotion motion =
      is_posed ? tracking::to_motion(*options.pose).inverse().after(tracking::to_motion(*previous.pose))
               : tracking::estimate_motion(previous, scene, view, plane);
  return tracking::Tracker(scene, previous, options, stop).run(motion, tracking::to_state(plane));
}

}  // namespace segserve
