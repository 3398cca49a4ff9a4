// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "segserve/tracking.hpp"

namespace segserve::wire {

/// Asks for ids that objects keep from cloud to cloud.
struct TrackRequest {
  TrackOptions options;
  std::string state;  ///< Tracks::state of the cloud before; empty: ids begin with 1
  bool operator==(const TrackRequest&) const = default;
};

/// The ids of the segments of one cloud over time.
struct Tracks {
  std::string state;                            ///< for the next cloud: TrackState::bytes
  std::vector<std::uint64_t> track_of_segment;  ///< the id of segment k + 1; 0 if it is not followed
  std::vector<TrackEvent> events;               ///< what became of the objects, by ascending id
  bool operator==(const Tracks&) const = default;
};

}  // namespace segserve::wire
