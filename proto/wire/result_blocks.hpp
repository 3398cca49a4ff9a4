// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "segserve/v1/result.pb.h"

// What a stream needs to send a result as a message without bytes, and the bytes afterward.
namespace segserve::wire {

/// The data of the blocks that the result has, in the order in which a stream sends them (the order in which
/// result.proto declares them: labels, supervoxels, leaf_points, left, right and weight of the tree). Valid while the
/// message lives and keeps these fields.
std::vector<std::string*> result_blocks(v1::SegmentationResult& message);

/// Block.encoded_bytes of the same blocks, as claimed.
std::vector<std::uint64_t> result_block_sizes(const v1::SegmentationResult& message);

}  // namespace segserve::wire
