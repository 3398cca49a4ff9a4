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

SegmentMessages to_message(std::span<const SegmentStatistics> statistics);

/// The statistics of a result of `segments` segments and `segmented_points` points. MALFORMED_PAYLOAD, naming segment
/// and field, unless they are of all segments (of the largest kMostDescribedSegments if there are more), by descending
/// points that add up, all numbers are finite and in their ranges, and boxes and normals have unit vectors.
absl::StatusOr<std::vector<SegmentStatistics>> from_message(const SegmentMessages& messages, std::uint32_t segments,
                                                            std::uint64_t segmented_points);

}  // namespace segserve::wire
