// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/warning.hpp"

// The formats in which labeled clouds are written.
namespace segserve::codec {

enum class FileFormat : std::uint8_t {
  kPcd,
  kPly,
  kLas,         ///< LAS 1.4; the labels are the extra dimension `segment`
  kXyz,         ///< text, with spaces, and with the names of the columns in a comment
  kCsv,         ///< text, with commas, and with the names of the columns in a line
  kNpy,         ///< an array of NumPy with named fields
  kSegsJson,    ///< ScanNet's list of the segment of each point; nothing else of the cloud
  kKittiLabel,  ///< SemanticKITTI's label of each point; nothing else of the cloud
  kGlb,         ///< binary glTF 2.0, a node for each segment, in meters near the origin, y up
  kGltf,        ///< the same as JSON
};

/// How a file has its numbers.
enum class FileEncoding : std::uint8_t {
  kBinary,  ///< the smallest binary form of the format: binary_compressed for PCD, binary_little_endian for PLY
  kText,    ///< ascii
};

/// The format that the end of a file's name chooses, in any case; nullopt if it chooses none.
std::optional<FileFormat> file_format_of(std::string_view path);

/// The ends of names that choose a format, for messages: ".pcd, .ply, .." and "or" before the last one.
std::string writable_extensions();

/// Whether the path ends in `extension`, which is in lower case, in any case.
bool has_extension(std::string_view path, std::string_view extension);

/// The purpose for which a file is read. Some formats cannot hold labels.
enum class ReadableFor : std::uint8_t { kSegmentation, kLabels };

/// Whether a file's name ends as those do that decode_cloud can read, such as .pcd or .las.gz.
bool has_readable_extension(std::string_view path, ReadableFor use = ReadableFor::kSegmentation);

/// The ends of these names, for messages: ".pcd, .ply, .. or .bin, also compressed as .gz or .zst".
std::string readable_extensions(ReadableFor use = ReadableFor::kSegmentation);

/// Whether the format has nothing but the labels of the points.
bool has_labels_only(FileFormat format);

/// The name of a file without its folder and the end that chooses its format.
std::string scene_name(std::string_view path);

/// The bytes of a file, and what of the cloud is not in it.
struct EncodedFile {
  std::string bytes;
  std::vector<Warning> warnings;
};

/// Warnings of what is in the content and not in a file of this format: rows and columns, the pose of the sensor, the
/// coordinate reference system. Values of points are left out. encode_file gives these warnings, too.
std::vector<Warning> losses_of(const FileContent& content, FileFormat format);

/// Encodes a cloud. Only PCD and PLY have both encodings; the others ignore it. `scene` is the name of the scene, which
/// only kSegsJson has. INVALID_ARGUMENT if the format cannot hold a label or coordinate, or if there are no labels and
/// it has nothing else.
absl::StatusOr<EncodedFile> encode_file(const FileContent& content, FileFormat format,
                                        FileEncoding encoding = FileEncoding::kBinary, std::string_view scene = {});

}  // namespace segserve::codec
