// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/stop_check.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/warning.hpp"

// Files that were compressed as a whole.
namespace segserve::codec {

enum class Compression : std::uint8_t { kGzip, kZstd };

/// How the file is compressed, which its first bytes tell; nullopt if it is not, or in another way.
std::optional<Compression> compression_of(std::string_view file);

/// Decompresses all members of a gzip file (RFC 1952), or all frames of a zstd file (RFC 8878), piece by piece, so that
/// nothing is believed that the file says of its size. What follows the last member and is none is not used, with a
/// warning unless it is zeros. INVALID_ARGUMENT if the file is damaged or cut off, or the result is larger than
/// `limits.max_bytes`; CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<std::vector<std::byte>> decompress(std::span<const std::byte> file, Compression compression,
                                                  const DecodeLimits& limits, StopCheck& check,
                                                  std::vector<Warning>& warnings);

/// Decompresses one raw deflate stream (RFC 1951) that fills `size` bytes exactly. `name` is for messages. The caller
/// has compared the size with the limits.
absl::StatusOr<std::vector<std::byte>> inflate_exactly(std::span<const std::byte> stream, std::size_t size,
                                                       std::string_view name, StopCheck& check);

}  // namespace segserve::codec
