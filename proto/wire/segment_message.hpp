// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "google/protobuf/repeated_ptr_field.h"
#include "segserve/segment_statistics.hpp"
#include "segserve/v1/segment.pb.h"

namespace segserve::wire {

using SegmentMessages = google::protobuf::RepeatedPtrField<v1::Segment>;

/// The message of thresholds, and the thresholds of a message; nullopt unless they ascend in [0, 1].
v1::ThresholdRange to_message(const ThresholdRange& range);
std::optional<ThresholdRange> from_message(const v1::ThresholdRange& message);

/// The message of one segment, and the statistics of a message, checked by themselves as those of a result are. `name`
/// is that of the segment in errors.
v1::Segment to_message(const SegmentStatistics& segment);
absl::StatusOr<SegmentStatistics> from_message(const v1::Segment& message, std::string_view name);

/// The messages of segment statistics, in the same order.
SegmentMessages to_message(std::span<const SegmentStatistics> statistics);

/// Reads the statistics of a result with `segments` segments, which hold `segmented_points` points together.
/// INVALID_ARGUMENT, MALFORMED_PAYLOAD, with a message that names the segment and the field, unless
/// - there is an entry for each of the largest kMostDescribedSegments segments, by descending number of points,
/// - the numbers of points add up,
/// - all numbers, and the thresholds if there are any, are finite and in their ranges,
/// - the axes of each box are a rotation, and each normal is a unit vector.
absl::StatusOr<std::vector<SegmentStatistics>> from_message(const SegmentMessages& messages, std::uint32_t segments,
                                                            std::uint64_t segmented_points);

}  // namespace segserve::wire
