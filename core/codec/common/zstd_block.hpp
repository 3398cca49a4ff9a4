// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// Compresses bytes to one zstd frame (RFC 8878) that declares the size of its content. `level` is 1 (fast) to 19
/// (small), or negative down to -100 (faster still). INVALID_ARGUMENT for other levels.
absl::StatusOr<std::string> zstd_compress(std::string_view bytes, int level);

/// Decompresses untrusted bytes. `decoded_size` is the exact size that the sender claims. Before memory is allocated
/// for it, it is compared with `limits.max_bytes`, with the size that the frame declares, and with the most that so
/// many bytes can decode to. INVALID_ARGUMENT if a comparison fails, if the bytes are not zstd, or if they decode to
/// another size.
absl::StatusOr<std::string> zstd_decompress(std::string_view bytes, std::size_t decoded_size,
                                            const DecodeLimits& limits = {});

}  // namespace segserve::codec
