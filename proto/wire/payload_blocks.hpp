// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "segserve/v1/cloud.pb.h"

// A stream sends a payload as a header without bytes, followed by the bytes of its blocks. These functions list the
// blocks.
namespace segserve::wire {

/// The data of the blocks that the payload has, in the order in which a stream sends them. That is the order of their
/// fields in cloud.proto. Empty if there is no payload. The pointers are valid while the message lives and keeps its
/// payload.
std::vector<std::string*> payload_blocks(v1::Cloud& message);

/// Whether any block of the payload holds data.
bool payload_has_data(const v1::Cloud& message);

/// Block.encoded_bytes of the same blocks in the same order, as the message claims them.
std::vector<std::uint64_t> payload_block_sizes(const v1::Cloud& message);

/// The sum of payload_block_sizes, or UINT64_MAX if it overflows.
std::uint64_t payload_bytes(const v1::Cloud& message);

}  // namespace segserve::wire
