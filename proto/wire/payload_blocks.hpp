// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "segserve/v1/cloud.pb.h"

// What a stream needs to send a payload as a header without bytes, and the bytes afterward.
namespace segserve::wire {

/// The data of the blocks that the payload has, in the order in which a stream sends them (the order of the
/// fields in their message: x, y, z, rgb; depth, color). Empty without a payload. Valid while the message lives
/// and keeps its payload.
std::vector<std::string*> payload_blocks(v1::Cloud& message);

/// Block.encoded_bytes of the same blocks, as claimed.
std::vector<std::uint64_t> payload_block_sizes(const v1::Cloud& message);

/// Their sum; the largest number there is if it overflows.
std::uint64_t payload_bytes(const v1::Cloud& message);

}  // namespace segserve::wire
