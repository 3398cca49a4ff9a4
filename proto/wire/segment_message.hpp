// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "google/protobuf/repeated_ptr_field.h"
#include "segserve/segment_statistics.hpp"
#include "segserve/v1/segment.pb.h"

namespace segserve::wire {

using SegmentMessages = google::protobuf::RepeatedPtrField<v1::Segment>;

/// The messages of segment statistics, in the same order.
SegmentMessages to_message(std::span<const SegmentStatistics> statistics);

/// Reads the statistics of a result with `segments` segments, which hold `segmented_points` points together.
/// INVALID_ARGUMENT, MALFORMED_PAYLOAD, with a message that names the segment and the field, unless
/// - there is an entry for each of the largest kMostDescribedSegments segments, by descending number of points,
/// - the numbers of points add up,
/// - all numbers are finite and in their ranges,
/// - the axes of each box are a rotation, and each normal is a unit vector.
absl::StatusOr<std::vector<SegmentStatistics>> from_message(const SegmentMessages& messages, std::uint32_t segments,
                                                            std::uint64_t segmented_points);

}  // namespace segserve::wire
