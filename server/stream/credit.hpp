// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace segserve::server {

/// Frames and bytes of payload that a client may have under way.
struct Credit {
  std::uint32_t frames = 0;
  std::uint64_t bytes = 0;
  bool operator==(const Credit&) const = default;
};

/// How much credit a stream gets. Credit is a promise to read so much, and reserves nothing: a frame leases its memory
/// when its header comes. So streams that do nothing cost nothing.
struct CreditLimits {
  Credit most_per_stream;
  std::uint64_t default_bytes_per_stream = 0;  ///< for a stream that asks for nothing

  /// Grants what is wanted (0: the default) within the limits of a stream.
  Credit grant(const Credit& wanted) const {
    const std::uint64_t bytes = wanted.bytes > 0 ? wanted.bytes : default_bytes_per_stream;
    return {.frames = wanted.frames > 0 ? std::min(most_per_stream.frames, wanted.frames) : most_per_stream.frames,
            .bytes = std::min(most_per_stream.bytes, bytes)};
  }
};

}  // namespace segserve::server
