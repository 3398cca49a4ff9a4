// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace segserve::codec {

/// The largest cloud that a decoder accepts. Decoders compare each claimed size with these limits, and with the bytes
/// at hand, before they allocate memory for it. A larger one is INVALID_ARGUMENT with a message that names the claim
/// and the limit (see limit_excess).
///
/// Most decoders take a StopToken as well. Once it says stop, they return its status within
/// StopToken::kMostWorkAfterStop points. Work that a library does in one call, such as decoding a PNG, runs to its end.
struct DecodeLimits {
  /// Points of one cloud.
  std::uint64_t max_points = 64'000'000;
  /// Bytes of one encoded cloud, and of anything that is decompressed from it.
  std::uint64_t max_bytes = std::uint64_t{4} << 30U;
  /// Whether Draco may be decoded. It is off because Draco's library has known faults with hostile bytes.
  bool draco = false;
};

/// The limit that a claim exceeded. It lets callers answer a cloud that is too large differently from a damaged one.
struct LimitExcess {
  std::string limit;          ///< name of the member of DecodeLimits: "max_points" or "max_bytes"
  std::uint64_t actual = 0;   ///< claimed points or bytes; the largest 64-bit number if they are more than that
  std::uint64_t allowed = 0;  ///< value of the limit
};

/// INVALID_ARGUMENT with this message, from which `limit_excess` reads `excess`.
absl::Status over_limit(std::string_view message, const LimitExcess& excess);
/// The excess that a status of `over_limit` carries; nullopt for every other status.
std::optional<LimitExcess> limit_excess(const absl::Status& status);

}  // namespace segserve::codec
