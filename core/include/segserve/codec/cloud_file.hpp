// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::codec {

/// How save_cloud writes: text, or the smallest lossless form of the format (binary_compressed
/// for PCD, binary_little_endian for PLY).
enum class FileEncoding : std::uint8_t { kBinary, kText };

/// PLY if the bytes begin with PLY's magic line, else PCD.
absl::StatusOr<LabelledCloud> decode_cloud(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                           std::optional<View> view = std::nullopt);

/// Reads a file, or standard input if the path is "-"; the content tells the format (decode_cloud).
/// NOT_FOUND or PERMISSION_DENIED if it cannot be opened, UNAVAILABLE if reading fails,
/// INVALID_ARGUMENT if it is not a good cloud; messages begin with the path.
absl::StatusOr<LabelledCloud> load_cloud(const std::string& path, std::optional<View> view = std::nullopt,
                                         const DecodeLimits& limits = {});

/// Writes by extension, .pcd or .ply in any case; "-" is PCD to standard output. `label` is empty
/// or has an entry per point. INVALID_ARGUMENT for another extension; otherwise as load_cloud.
absl::Status save_cloud(const std::string& path, const CloudView& cloud, std::span<const std::uint32_t> label,
                        FileEncoding encoding = FileEncoding::kBinary);

}  // namespace segserve::codec
