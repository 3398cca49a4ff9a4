// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/options.hpp"
#include "segserve/segment.hpp"
#include "segserve/stop_token.hpp"
#include "segserve/v1/tracking.pb.h"
#include "segserve/wire/tracks.hpp"

namespace segserve::wire {

v1::TrackRequest to_message(const TrackRequest& request);
v1::TrackResult to_message(const Tracks& tracks);

/// Reads a request, whose options are valid and whose state can be parsed unless there are new faults. Their fields
/// begin with "tracking.".
TrackRequest from_message(const v1::TrackRequest& message, std::vector<FieldViolation>& faults);

/// Reads the ids of so many segments. INVALID_ARGUMENT if they do not fit these, or the message is wrong otherwise. The
/// state is not read: only the next request needs it.
absl::StatusOr<Tracks> from_message(const v1::TrackResult& message, std::uint32_t segments);

/// Gives the segments of a cloud of this view their ids, and the segmentation the cut that they need (segserve::apply).
/// Sets the time that this took. The request must be valid. Errors are those of segserve::track.
absl::StatusOr<Tracks> follow(const TrackRequest& request, const View& view, const StopToken& stop,
                              Segmentation& segmentation);

}  // namespace segserve::wire
