// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "proto/wire/request_message.hpp"
#include "segserve/segment.hpp"
#include "segserve/v1/result.pb.h"
#include "segserve/wire/result.hpp"

namespace segserve::wire {

/// What there is to tell of the finished segmentation of `cloud`; call timings are left 0.
Result make_result(Segmentation segmentation, const CloudView& cloud, const Options& options, std::string view_rule,
                   std::string version);

/// The message with the arrays that `outputs` asks for. Sets every timing but `encode` and `total`, which are
/// not known before: see set_final_timings.
absl::StatusOr<v1::SegmentationResult> to_message(const Result& result, const Outputs& outputs);

/// Fills in the two timings that end with the message itself.
void set_final_timings(v1::SegmentationResult& message, double encode_ms, double total_ms);

/// A result from a server for a cloud of `points` points. MALFORMED_PAYLOAD unless all its arrays fit the
/// cloud, the summary and each other.
absl::StatusOr<Result> from_message(const v1::SegmentationResult& message, std::size_t points);

}  // namespace segserve::wire
