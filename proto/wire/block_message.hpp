// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/v1/block.pb.h"

namespace segserve::wire {

/// The block that holds these bytes, with both sizes set. COMPRESSION_ZSTD compresses them if that makes them smaller;
/// any other value leaves them as they are. INTERNAL if Zstandard fails.
absl::StatusOr<v1::Block> to_block(std::string bytes, v1::Compression compression);

/// The block that holds these bytes as they are, with both sizes set.
v1::Block to_raw_block(std::string bytes);

/// The bytes of a block that must hold exactly `expected_bytes` after decompression. The caller has compared that
/// number with its limits. The result points into the block's own data, or into `buffer` if the data had to be
/// decompressed. INVALID_ARGUMENT, MALFORMED_PAYLOAD if a size differs, the compression is unknown or the data are
/// damaged; the message begins with `name`.
absl::StatusOr<std::string_view> block_bytes(const v1::Block& block, std::uint64_t expected_bytes,
                                             std::string_view name, std::string& buffer);

/// The bytes of a block of any size up to `max_bytes`, such as a file, whose size only the block itself tells. Errors
/// are those of block_bytes, and LIMIT_EXCEEDED (max_decoded_bytes) for a larger block.
absl::StatusOr<std::string_view> block_bytes_up_to(const v1::Block& block, std::uint64_t max_bytes,
                                                   std::string_view name, std::string& buffer);

}  // namespace segserve::wire
