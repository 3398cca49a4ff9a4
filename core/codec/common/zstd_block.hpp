// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// One zstd frame that declares its content size. `level` is 1 (fast) to 19 (small), or negative
/// down to -100 (faster still); others are INVALID_ARGUMENT.
absl::StatusOr<std::string> zstd_compress(std::string_view bytes, int level);

/// The inverse for untrusted bytes. `decoded_size` is the exact size claimed by the sender; before
/// it is allocated it is checked against `limits.max_bytes`, against the size the frame declares,
/// and against what so many bytes can hold at most. INVALID_ARGUMENT if a check fails, the bytes
/// are not zstd, or they decode to another size.
absl::StatusOr<std::string> zstd_decompress(std::string_view bytes, std::size_t decoded_size,
                                            const DecodeLimits& limits = {});

}  // namespace segserve::codec
