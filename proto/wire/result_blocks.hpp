// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "segserve/v1/result.pb.h"

// A stream sends a result as a message without bytes, followed by the bytes of its blocks. These functions list the
// blocks.
namespace segserve::wire {

/// The data of the blocks that the result has, in the order in which a stream sends them: labels, supervoxels, the
/// columns leaf_points, left, right and weight of the tree, and selected. Adds the columns that a tree lacks, so that
/// it always has four blocks. The pointers are valid while the message lives and keeps these fields.
std::vector<std::string*> result_blocks(v1::SegmentationResult& message);

/// Block.encoded_bytes of the same blocks in the same order, as the message claims them.
std::vector<std::uint64_t> result_block_sizes(const v1::SegmentationResult& message);

}  // namespace segserve::wire
