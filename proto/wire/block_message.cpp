// SPDX-License-Identifier: Apache-2.0
#include "proto/wire/block_message.hpp"

#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/zstd_block.hpp"
#include "fmt/format.h"
#include "proto/wire/status_message.hpp"

namespace segserve::wire {
namespace {

// This level saves time on links of 100 Mbit/s and below.
constexpr int kZstdLevel = 1;

}  // namespace

absl::StatusOr<v1::Block> to_block(std::string bytes, v1::Compression compression) {
  if (compression != v1::COMPRESSION_ZSTD) return to_raw_block(std::move(bytes));
  ASSIGN_OR_RETURN(std::string compressed, codec::zstd_compress(bytes, kZstdLevel));
  if (compressed.size() >= bytes.size()) return to_raw_block(std::move(bytes));
  v1::Block block;
  block.set_compression(v1::COMPRESSION_ZSTD);
  block.set_decoded_bytes(bytes.size());
  block.set_encoded_bytes(compressed.size());
  block.set_data(std::move(compressed));
  return block;
}

v1::Block to_raw_block(std::string bytes) {
  v1::Block block;
  block.set_compression(v1::COMPRESSION_NONE);
  block.set_decoded_bytes(bytes.size());
  block.set_encoded_bytes(bytes.size());
  block.set_data(std::move(bytes));
  return block;
}

absl::StatusOr<std::string_view> block_bytes(const v1::Block& block, std::uint64_t expected_bytes,
                                             std::string_view name, std::string& buffer) {
  const bool compressed = block.compression() == v1::COMPRESSION_ZSTD;
  if (!compressed && block.compression() != v1::COMPRESSION_NONE &&
      block.compression() != v1::COMPRESSION_UNSPECIFIED) {
    return malformed(fmt::format("{}: compression {} is unknown", name, static_cast<int>(block.compression())));
  }
  if (block.encoded_bytes() != 0 && block.encoded_bytes() != block.data().size()) {
    return malformed(
        fmt::format("{}: claims {} encoded bytes, but has {}", name, block.encoded_bytes(), block.data().size()));
  }
  const bool size_is_claimed = compressed || block.decoded_bytes() != 0;
  if (size_is_claimed && block.decoded_bytes() != expected_bytes) {
    return malformed(fmt::format("{}: claims {} bytes, but must have {}", name, block.decoded_bytes(), expected_bytes));
  }
  if (!compressed) {
    if (block.data().size() == expected_bytes) return std::string_view(block.data());
    return malformed(fmt::format("{}: has {} bytes, but must have {}", name, block.data().size(), expected_bytes));
  }
  absl::StatusOr<std::string> bytes =
      codec::zstd_decompress(block.data(), expected_bytes, {.max_bytes = expected_bytes});
  if (!bytes.ok()) return malformed(name, bytes.status());
  buffer = *std::move(bytes);
  return std::string_view(buffer);
}

absl::StatusOr<std::string_view> block_bytes_up_to(const v1::Block& block, std::uint64_t max_bytes,
                                                   std::string_view name, std::string& buffer) {
  const bool compressed = block.compression() == v1::COMPRESSION_ZSTD;
  const std::uint64_t bytes = compressed ? block.decoded_bytes() : block.data().size();
  if (bytes > max_bytes) {
    return limit_exceeded(fmt::format("{} has", name), bytes, "bytes", "max_decoded_bytes", max_bytes);
  }
  return block_bytes(block, bytes, name, buffer);
}

}  // namespace segserve::wire
