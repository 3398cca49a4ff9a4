#pragma once

#include <cstdint>

namespace segserve::codec {

/// What a decoder may be asked for. A claimed size is compared with these, and with the bytes at
/// hand, before anything is allocated; a larger one is INVALID_ARGUMENT naming limit and claim.
struct DecodeLimits {
  /// Points of one cloud.
  std::uint64_t max_points = 64'000'000;
  /// Bytes of one encoded cloud, and of anything decompressed from it.
  std::uint64_t max_bytes = std::uint64_t{4} << 30U;
};

}  // namespace segserve::codec
