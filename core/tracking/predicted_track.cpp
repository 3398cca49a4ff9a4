// SPDX-License-Identifier: Apache-2.0
#include "core/tracking/predicted_track.hpp"

#include <algorithm>
#include <iterator>

namespace segserve::tracking {
namespace {

constexpr std::uint32_t kEstablished = 8;  // frames

Vec3 vector_of(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }
Vec3 color_of(const std::array<std::uint8_t, 3>& c) {
  return {static_cast<double>(c[0]), static_cast<double>(c[1]), static_cast<double>(c[2])};
}

PredictedTrack predict_one(const TrackState::Track& track, const RigidMotion& motion) {
  const Vec3 center = vector_of(track.center);
  const Vec3 first{track.axes[0], track.axes[1], track.axes[2]}, second{track.axes[3], track.axes[4], track.axes[5]};
  PredictedTrack result;
  result.center = motion(center);
  result.color = color_of(track.rgb);
  result.axes = {motion.rotate(first), motion.rotate(second), motion.rotate(cross(first, second))};
  result.half_extents = {track.half_extents[0], track.half_extents[1], track.half_extents[2]};
  result.velocity = motion.rotate(vector_of(track.velocity));
  result.area = track.area;
  result.is_lost = track.lost > 0;
  result.is_trusted = track.trust > 0 && track.lost == 0;
  result.is_established = track.age >= kEstablished;
  result.frames_unseen = track.lost + 1U;
  result.signatures.reserve(track.signatures.size());
  for (const TrackState::Signature& s : track.signatures) {
    const Vec3 offset{static_cast<double>(s.place[0]), static_cast<double>(s.place[1]),
                      static_cast<double>(s.place[2])};
    result.signatures.push_back({motion(center + track.step * offset), color_of(s.rgb)});
  }
  return result;
}

}  // namespace

std::vector<PredictedTrack> predict(const TrackState& state, const RigidMotion& motion) {
  std::vector<PredictedTrack> tracks;
  tracks.reserve(state.tracks.size());
  std::ranges::transform(state.tracks, std::back_inserter(tracks),
                         [&](const TrackState::Track& track) { return predict_one(track, motion); });
  return tracks;
}

}  // namespace segserve::tracking
