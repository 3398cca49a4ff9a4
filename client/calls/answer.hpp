// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "segserve/v1/result.pb.h"
#include "segserve/wire/outputs.hpp"
#include "segserve/wire/result.hpp"

namespace segserve::client {

/// The result that a server sent. `points` is the size of the cloud; unset if only the server knows it, whose claim is
/// then accepted up to DecodeLimits::max_points. INTERNAL if the message is broken or lacks arrays of `wanted`, because
/// a bad answer is the fault of the server and not of the caller. It is UNIMPLEMENTED if `wants_tracks` and the server
/// is too old to give them.
absl::StatusOr<wire::Result> decode_answer(const v1::SegmentationResult& message, std::optional<std::uint64_t> points,
                                           const wire::Outputs& wanted, bool wants_tracks = false);

}  // namespace segserve::client
