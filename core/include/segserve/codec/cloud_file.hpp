// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// Point clouds in PCD and PLY files, the two formats of segserve/codec/pcd.hpp and segserve/codec/ply.hpp.
namespace segserve::codec {

/// How save_cloud writes the numbers of a cloud. Both ways keep every float, color and label.
enum class FileEncoding : std::uint8_t {
  kBinary,  ///< the smallest binary form of the format: binary_compressed for PCD, binary_little_endian for PLY
  kText,    ///< ascii
};

/// Decodes the bytes of a file: as PLY if they begin with PLY's magic line (is_ply), otherwise as PCD. The errors are
/// those of decode_ply and decode_pcd; INVALID_ARGUMENT names other formats that are known, and says what to do with
/// such a file.
absl::StatusOr<LabeledCloud> decode_cloud(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                          const ReadOptions& options = {}, const StopToken& stop = {});

/// Reads the file `path`, or standard input if the path is "-", and decodes its content with decode_cloud. The name of
/// the file does not matter. NOT_FOUND or PERMISSION_DENIED if the file cannot be opened, UNAVAILABLE if reading it
/// fails, INVALID_ARGUMENT if decode_cloud refuses its content or it is larger than a limit. Messages begin with the
/// path.
absl::StatusOr<LabeledCloud> load_cloud(const std::string& path, const ReadOptions& options = {},
                                        const DecodeLimits& limits = {});

/// Writes a cloud to the file `path` as PCD or PLY, which its extension (.pcd or .ply, in any case) chooses. The path
/// "-" writes PCD to standard output. INVALID_ARGUMENT for another extension, NOT_FOUND or PERMISSION_DENIED if the
/// file cannot be opened, UNAVAILABLE if writing it fails; the file may then be incomplete. Messages begin with the
/// path.
absl::Status save_cloud(const std::string& path, const FileContent& content,
                        FileEncoding encoding = FileEncoding::kBinary);
/// The same for a cloud and its labels: one entry per point, or none.
absl::Status save_cloud(const std::string& path, const CloudView& cloud, std::span<const std::uint32_t> label,
                        FileEncoding encoding = FileEncoding::kBinary);

}  // namespace segserve::codec
