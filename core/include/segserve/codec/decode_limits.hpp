// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace segserve::codec {

/// What a decoder may be asked for. (Beside it decoders take a StopToken: once it says stop, they return its status
/// within StopToken::kMostWorkAfterStop points. What a library does in one call, such as a PNG, is done to its end.) A
/// claimed size is compared with these, and with the bytes at hand, before anything is allocated; a larger one is
/// INVALID_ARGUMENT naming limit and claim.
struct DecodeLimits {
  /// Points of one cloud.
  std::uint64_t max_points = 64'000'000;
  /// Bytes of one encoded cloud, and of anything decompressed from it.
  std::uint64_t max_bytes = std::uint64_t{4} << 30U;
  /// Whether Draco may be decoded: its library has known faults with hostile bytes.
  bool draco = false;
};

/// Which of the limits above a claim exceeded: for callers that answer it differently from damage.
struct LimitExcess {
  std::string limit;  ///< the member's name
  std::uint64_t actual = 0;
  std::uint64_t allowed = 0;
};

/// INVALID_ARGUMENT that carries what `limit_excess` reads.
absl::Status over_limit(std::string_view message, const LimitExcess& excess);
/// Nothing unless the status was made by `over_limit`.
std::optional<LimitExcess> limit_excess(const absl::Status& status);

}  // namespace segserve::codec
