// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "core/tracking/predicted_track.hpp"
#include "core/tracking/scene_tree.hpp"
#include "segserve/tracking.hpp"

namespace segserve::tracking {

/// A track as these leaves of the frame show it. Its id, age, trust and velocity are those of a track that was never
/// seen before, with id 0.
TrackState::Track describe_track(const SceneTree& scene, std::span<const std::uint32_t> leaves);

/// The track of the frame before that is out of sight in this one.
TrackState::Track carry_on(const TrackState::Track& before, const PredictedTrack& predicted);

/// The velocity of a track that was seen `seconds` ago and is now at `center`: the mean of what it was and of what it
/// seems to be.
std::array<float, 3> new_velocity(const PredictedTrack& predicted, const std::array<float, 3>& center, double seconds);

}  // namespace segserve::tracking
