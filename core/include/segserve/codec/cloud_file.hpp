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
#include "segserve/codec/file_format.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// Point clouds in files of every format that can be read or written.
namespace segserve::codec {

/// Decodes the bytes of a file, whose format they tell themselves:
///
///  - PCD (segserve/codec/pcd.hpp), PLY (segserve/codec/ply.hpp)
///  - LAS 1.0 to 1.4 with points of any format, not compressed
///  - tables of numbers in text: XYZ, PTS, CSV and their like, with or without the names of the columns
///  - the vertices of OBJ
///  - arrays of NumPy: NPY, and NPZ with members that are stored or deflated
///  - sweeps of a LiDAR without a header, as KITTI and nuScenes have them
///  - each of these compressed with gzip or zstd
///
/// INVALID_ARGUMENT names what is wrong with the file. It also names other formats that are known, and says what to do
/// with such a file. CANCELLED, DEADLINE_EXCEEDED.
absl::StatusOr<LabeledCloud> decode_cloud(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                          const ReadOptions& options = {}, const StopToken& stop = {});

/// Whether decode_cloud takes bytes as a PCD file that is not compressed.
bool is_taken_as_pcd(std::span<const std::byte> bytes);

/// Whether a file in a folder is one of a cloud, by the end of its name (has_readable_extension). A file .txt must also
/// begin as a table of points does, because most such files are notes.
bool is_cloud_file(const std::string& path);

/// Reads the file or pipe `path`, or standard input if the path is "-", and decodes its content with decode_cloud. The
/// name of the file does not matter. NOT_FOUND or PERMISSION_DENIED if the file cannot be opened, UNAVAILABLE if
/// reading it fails, INVALID_ARGUMENT if it is a folder, a device or a socket, if decode_cloud refuses its content, or
/// if it is larger than a limit. A pipe is waited for until `stop` says CANCELLED or DEADLINE_EXCEEDED. Messages begin
/// with the path.
absl::StatusOr<LabeledCloud> load_cloud(const std::string& path, const ReadOptions& options = {},
                                        const DecodeLimits& limits = {}, const StopToken& stop = {});

/// Writes a cloud to the file `path` in the format that its extension chooses (file_format_of). The path "-" writes PCD
/// to standard output. What the format cannot hold is left out. INVALID_ARGUMENT for another extension, and if
/// encode_file refuses the cloud, NOT_FOUND or PERMISSION_DENIED if the file cannot be opened, UNAVAILABLE if writing
/// it fails; the file may then be incomplete. Messages begin with the path.
absl::Status save_cloud(const std::string& path, const FileContent& content,
                        FileEncoding encoding = FileEncoding::kBinary);
/// Does the same for a cloud and its labels: one entry per point, or none.
absl::Status save_cloud(const std::string& path, const CloudView& cloud, std::span<const std::uint32_t> label,
                        FileEncoding encoding = FileEncoding::kBinary);

}  // namespace segserve::codec
