// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
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

/// Bytes that were decompressed, in memory that has grown where it was: they were never there twice.
class DecompressedBytes {
 public:
  struct Free {
    void operator()(std::byte* data) const { std::free(data); }  // NOLINT(*-no-malloc, *-owning-memory)
  };
  using Memory = std::unique_ptr<std::byte, Free>;

  DecompressedBytes(Memory memory, std::size_t size) : memory_(std::move(memory)), size_(size) {}
  std::span<const std::byte> bytes() const { return {memory_.get(), size_}; }

 private:
  Memory memory_;
  std::size_t size_;
};

/// Decompresses all members of a gzip file (RFC 1952), or all frames of a zstd file (RFC 8878), piece by piece, so that
/// nothing is believed that the file says of its size. What follows the last member and is none is not used, with a
/// warning unless it is zeros. INVALID_ARGUMENT if the file is damaged or cut off, or the result is larger than
/// `limits.max_bytes`; RESOURCE_EXHAUSTED if there is no memory; CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<DecompressedBytes> decompress(std::span<const std::byte> file, Compression compression,
                                             const DecodeLimits& limits, StopCheck& check,
                                             std::vector<Warning>& warnings);

/// Decompresses one raw deflate stream (RFC 1951) that fills `size` bytes exactly. `name` is for messages. The caller
/// has compared the size with the limits.
absl::StatusOr<std::vector<std::byte>> inflate_exactly(std::span<const std::byte> stream, std::size_t size,
                                                       std::string_view name, StopCheck& check);

}  // namespace segserve::codec
