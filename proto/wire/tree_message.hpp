// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "segserve/merge_tree.hpp"
#include "segserve/v1/result.pb.h"

namespace segserve::wire {

/// The message of a merge tree, each of whose columns may be compressed. INTERNAL if Zstandard fails.
absl::StatusOr<v1::MergeTree> to_message(const MergeTree& tree, v1::Compression compression);

/// Reads a tree that must have exactly `supervoxels` leaves, which have `points` points together. INVALID_ARGUMENT,
/// MALFORMED_PAYLOAD if the message holds anything else.
absl::StatusOr<MergeTree> from_message(const v1::MergeTree& message, std::uint32_t supervoxels, std::uint64_t points);

}  // namespace segserve::wire
