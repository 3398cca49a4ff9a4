// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/track_message.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/base/stopwatch.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

constexpr int kRotationNumbers = 9;

v1::RigidTransform to_message(const RigidTransform& transform) {
  v1::RigidTransform message;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) message.add_rotation(transform.rotation(row, column));
  }
  message.mutable_translation()->set_x(transform.translation.x());
  message.mutable_translation()->set_y(transform.translation.y());
  message.mutable_translation()->set_z(transform.translation.z());
  return message;
}

/// nullopt if the rotation has another number of numbers.
std::optional<RigidTransform> from_message(const v1::RigidTransform& message) {
  if (message.rotation_size() != kRotationNumbers) return std::nullopt;
  RigidTransform transform;
  for (int i = 0; i < kRotationNumbers; ++i) transform.rotation(i / 3, i % 3) = message.rotation(i);
  transform.translation = {message.translation().x(), message.translation().y(), message.translation().z()};
  return transform;
}

v1::TrackEventKind to_message(TrackEventKind kind) {
  switch (kind) {
    case TrackEventKind::kBorn:
      return v1::TRACK_EVENT_KIND_BORN;
    case TrackEventKind::kSplit:
      return v1::TRACK_EVENT_KIND_SPLIT;
    case TrackEventKind::kLost:
      return v1::TRACK_EVENT_KIND_LOST;
    case TrackEventKind::kMerged:
      return v1::TRACK_EVENT_KIND_MERGED;
    case TrackEventKind::kRecovered:
      return v1::TRACK_EVENT_KIND_RECOVERED;
    case TrackEventKind::kEnded:
      return v1::TRACK_EVENT_KIND_ENDED;
  }
  return v1::TRACK_EVENT_KIND_UNSPECIFIED;
}

/// nullopt if this version does not know the kind.
std::optional<TrackEventKind> from_message(v1::TrackEventKind message) {
  for (const TrackEventKind kind : {TrackEventKind::kBorn, TrackEventKind::kSplit, TrackEventKind::kLost,
                                    TrackEventKind::kMerged, TrackEventKind::kRecovered, TrackEventKind::kEnded}) {
    if (to_message(kind) == message) return kind;
  }
  return std::nullopt;
}

}  // namespace

v1::TrackRequest to_message(const TrackRequest& request) {
  v1::TrackRequest message;
  const TrackOptions& options = request.options;
  message.set_state(request.state);
  if (options.pose) *message.mutable_pose() = to_message(*options.pose);
  if (options.time) message.set_time(*options.time);
  message.set_max_speed(options.max_speed);
  message.set_keep_lost(options.keep_lost);
  message.set_min_points(options.min_points);
  return message;
}

v1::TrackResult to_message(const Tracks& tracks) {
  v1::TrackResult message;
  message.set_state(tracks.state);
  message.mutable_track_ids()->Add(tracks.track_of_segment.begin(), tracks.track_of_segment.end());
  for (const TrackEvent& event : tracks.events) {
    v1::TrackEvent& added = *message.add_events();
    added.set_kind(to_message(event.kind));
    added.set_track(event.track);
    added.set_other(event.other);
  }
  return message;
}

TrackRequest from_message(const v1::TrackRequest& message, std::vector<FieldViolation>& faults) {
  TrackRequest request{.options = {}, .state = message.state()};
  TrackOptions& options = request.options;
  const auto fault = [&](std::string_view field, std::string description) {
    faults.push_back({fmt::format("tracking.{}", field), std::move(description)});
  };
  if (const auto state = TrackState::parse(message.state()); !state.ok()) fault("state", message_of(state.status()));
  if (message.has_pose()) {
    options.pose = from_message(message.pose());
    if (!options.pose) fault("pose.rotation", fmt::format("has {} numbers, not 9", message.pose().rotation_size()));
  }
  if (message.has_time()) options.time = message.time();
  if (message.has_max_speed()) options.max_speed = message.max_speed();
  if (message.has_keep_lost()) options.keep_lost = message.keep_lost();
  if (message.has_min_points()) options.min_points = message.min_points();
  for (FieldViolation& violation : violations(options)) fault(violation.field, std::move(violation.description));
  return request;
}

absl::StatusOr<Tracks> from_message(const v1::TrackResult& message, std::uint32_t segments) {
  if (message.state().size() > TrackState::kMostBytes) return malformed("the track state of the result is too large");
  if (static_cast<std::size_t>(message.track_ids_size()) != segments) {
    return malformed(
        fmt::format("the result has ids of {} segments, but {} segments", message.track_ids_size(), segments));
  }
  Tracks tracks{.state = message.state(),
                .track_of_segment = {message.track_ids().begin(), message.track_ids().end()},
                .events = {}};
  std::vector<std::uint64_t> ids = tracks.track_of_segment;
  std::erase(ids, 0U);
  std::ranges::sort(ids);
  if (std::ranges::adjacent_find(ids) != ids.end()) return malformed("two segments of the result have the same id");
  for (const v1::TrackEvent& event : message.events()) {
    // A later server may tell of more.
    if (const auto kind = from_message(event.kind())) tracks.events.push_back({*kind, event.track(), event.other()});
  }
  return tracks;
}

absl::StatusOr<Tracks> follow(const TrackRequest& request, const View& view, const StopToken& stop,
                              Segmentation& segmentation) {
  Stopwatch watch;
  ASSIGN_OR_RETURN(const TrackState state, TrackState::parse(request.state));
  ASSIGN_OR_RETURN(const Tracking tracking, track(segmentation, view, state, request.options, stop));
  RETURN_IF_ERROR(apply(tracking, stop, segmentation));
  Tracks tracks{
      .state = tracking.state.bytes(), .track_of_segment = tracking.track_of_segment, .events = tracking.events};
  segmentation.timings.tracking = watch.lap();
  segmentation.timings.total += segmentation.timings.tracking;
  return tracks;
}

}  // namespace segserve::wire
