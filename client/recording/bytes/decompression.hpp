// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "segserve/stop_token.hpp"

// The compressions of chunks in recordings. All bytes are untrusted.
namespace segserve::recording {

/// The outcome of decompression.
struct Decompressed {
  std::string bytes;
  bool complete = false;  ///< false: the input ends early, or is damaged behind what `bytes` came from
};

/// Decompresses a chunk. `compression` is the name of MCAP or of ROS 1 bags: "" or "none", "lz4" (frames), "zstd",
/// "bz2". `claimed` is the size that the chunk claims; the caller has compared it with a limit. Memory is allocated as
/// bytes come out, and more bytes than claimed never do. INVALID_ARGUMENT for a compression of another name;
/// CANCELLED and DEADLINE_EXCEEDED as `stop` says.
absl::StatusOr<Decompressed> decompress(std::string_view compression, std::string_view bytes, std::uint64_t claimed,
                                        const StopToken& stop);

}  // namespace segserve::recording
