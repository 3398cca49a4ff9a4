#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/v1alpha1/block.pb.h"

namespace segserve::wire {

/// Bytes as a message. ZSTD at level 1 is what pays off on a link of 100 Mbit/s and below.
absl::StatusOr<v1alpha1::Block> to_block(std::string bytes, v1alpha1::Compression compression);

/// The bytes of a block that must hold exactly `expected_bytes` of them after decompression; the
/// caller has checked that number against its limits. Returns a view of the block's own data, or of
/// `buffer` if it had to be decompressed. MALFORMED_PAYLOAD, naming the block by `name`, if the size
/// differs, the compression is unknown or the data are broken.
absl::StatusOr<std::string_view> block_bytes(const v1alpha1::Block& block, std::uint64_t expected_bytes,
                                             std::string_view name, std::string& buffer);

}  // namespace segserve::wire
