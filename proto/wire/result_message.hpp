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

/// The result of the segmentation of `cloud` with `options`. `view_rule` says for people why the cloud has its view,
/// and `version` is that of this program. It warns of points that were left out as no measurements, and of a resolution
/// that does not fit. The call timings are 0.
Result make_result(Segmentation segmentation, const CloudView& cloud, const Options& options, std::string view_rule,
                   std::string version);

/// Adds what is known of the payload or file that the cloud was read from: the result, which must be that of the cloud
/// itself, is expressed in the payload's coordinates, and the warnings come before its own.
void take_payload_facts(const codec::Placement& placement, const std::vector<codec::Warning>& warnings, Result& result);

/// The message with the arrays that `outputs` asks for. The timings `encode` and `total` stay unset, because the
/// message must be finished before they are known; set_final_timings sets them. INTERNAL if Zstandard fails.
absl::StatusOr<v1::SegmentationResult> to_message(const Result& result, const Outputs& outputs);

/// Sets the two timings that end when the message is finished, milliseconds.
void set_final_timings(v1::SegmentationResult& message, double encode_ms, double total_ms);

/// Reads the result of a cloud of `points` points. Arrays that the message does not have stay empty, whether they were
/// asked for or not. INVALID_ARGUMENT, MALFORMED_PAYLOAD unless the arrays and the summary agree with the cloud and
/// with each other.
absl::StatusOr<Result> from_message(const v1::SegmentationResult& message, std::size_t points);

}  // namespace segserve::wire
