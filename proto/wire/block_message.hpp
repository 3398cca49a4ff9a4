// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/v1/block.pb.h"

namespace segserve::wire {

/// Bytes as a message, both its sizes set; compressed only if that makes them smaller. ZSTD at level 1 is what pays off
/// on a link of 100 Mbit/s and below.
absl::StatusOr<v1::Block> to_block(std::string bytes, v1::Compression compression);

/// The same without compression, which cannot fail.
v1::Block to_raw_block(std::string bytes);

/// The bytes of a block that must hold exactly `expected_bytes` of them after decompression; the
/// caller has checked that number against its limits. Returns a view of the block's own data, or of
/// `buffer` if it had to be decompressed. MALFORMED_PAYLOAD, naming the block by `name`, if a size
/// differs, the compression is unknown or the data are broken.
absl::StatusOr<std::string_view> block_bytes(const v1::Block& block, std::uint64_t expected_bytes,
                                             std::string_view name, std::string& buffer);

/// The same for a block that holds what nobody but itself knows the size of, a file: any size up to `max_bytes`, more
/// is LIMIT_EXCEEDED (max_decoded_bytes).
absl::StatusOr<std::string_view> block_bytes_up_to(const v1::Block& block, std::uint64_t max_bytes,
                                                   std::string_view name, std::string& buffer);

}  // namespace segserve::wire
