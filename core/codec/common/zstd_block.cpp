// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/zstd_block.hpp"

#include <fmt/format.h>
#include <zstd.h>

#include "core/base/status_macros.hpp"
#include "core/codec/common/limit_checks.hpp"

namespace segserve::codec {

absl::StatusOr<std::string> zstd_compress(std::string_view bytes, int level) {
  constexpr int kFastest = -100;
  constexpr int kSmallest = 19;
  if (level < kFastest || level > kSmallest) {
    return absl::InvalidArgumentError(fmt::format("zstd level {} is not in {} to {}", level, kFastest, kSmallest));
  }
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), level);
  if (ZSTD_isError(size) != 0U) return absl::InternalError(fmt::format("zstd: {}", ZSTD_getErrorName(size)));
  out.resize(size);
  return out;
}

absl::StatusOr<std::string> zstd_decompress(std::string_view bytes, std::size_t decoded_size,
                                            const DecodeLimits& limits) {
  RETURN_IF_ERROR(check_bytes("zstd: the claimed ", decoded_size, limits));
  const unsigned long long declared = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  if (declared == ZSTD_CONTENTSIZE_ERROR) {
    return absl::InvalidArgumentError(fmt::format("zstd: the {} bytes do not begin with a zstd frame", bytes.size()));
  }
  if (declared != ZSTD_CONTENTSIZE_UNKNOWN && declared != decoded_size) {
    return absl::InvalidArgumentError(
        fmt::format("zstd: the frame declares {} bytes, not the claimed {}", declared, decoded_size));
  }
  // A frame consists of blocks. A block has a header of 3 bytes and holds at most 128 KiB.
  if (decoded_size / (std::size_t{128} << 10U) > bytes.size() / 3) {
    return absl::InvalidArgumentError(
        fmt::format("zstd: {} bytes cannot hold the claimed {} bytes", bytes.size(), decoded_size));
  }
  std::string out(decoded_size, '\0');
  const std::size_t size = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(size) != 0U) {
    return absl::InvalidArgumentError(
        fmt::format("zstd: {} (the claimed size is {} bytes)", ZSTD_getErrorName(size), decoded_size));
  }
  if (size != decoded_size) {
    return absl::InvalidArgumentError(
        fmt::format("zstd: the frame decodes to {} bytes, not the claimed {}", size, decoded_size));
  }
  return out;
}

}  // namespace segserve::codec
