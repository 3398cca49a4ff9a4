// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/file_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/gltf/gltf.hpp"
#include "core/codec/label_list/label_list.hpp"
#include "core/codec/las/las.hpp"
#include "core/codec/npy/npy.hpp"
#include "core/codec/text/text_table.hpp"
#include "segserve/codec/pcd.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::codec {
namespace {

struct Extension {
  std::string_view end;  ///< of a file's name, in lower case
  FileFormat format;
};

constexpr std::array<Extension, 10> kWritable{{
    {".pcd", FileFormat::kPcd},
    {".ply", FileFormat::kPly},
    {".las", FileFormat::kLas},
    {".csv", FileFormat::kCsv},
    {".xyz", FileFormat::kXyz},
    {".npy", FileFormat::kNpy},
    {".segs.json", FileFormat::kSegsJson},
    {".label", FileFormat::kKittiLabel},
    {".glb", FileFormat::kGlb},
    {".gltf", FileFormat::kGltf},
}};

constexpr std::array<std::string_view, 11> kReadable{".pcd", ".ply", ".las", ".xyz", ".txt", ".csv",
                                                     ".pts", ".obj", ".npy", ".npz", ".bin"};

const Extension* extension_of(std::string_view path) {
  const auto found = std::ranges::find_if(kWritable, [path](const Extension& e) { return has_extension(path, e.end); });
  return found == kWritable.end() ? nullptr : &*found;
}

absl::Status check_labels(const FileContent& content) {
  if (content.label.size() == content.cloud.size()) return absl::OkStatus();
  return absl::InvalidArgumentError("the format has nothing but labels, and the cloud has none");
}

}  // namespace

bool has_extension(std::string_view path, std::string_view extension) {
  if (path.size() < extension.size()) return false;
  const std::string_view end = path.substr(path.size() - extension.size());
  return std::equal(end.begin(), end.end(), extension.begin(),
                    [](char a, char b) { return (a >= 'A' && a <= 'Z' ? static_cast<char>(a - 'A' + 'a') : a) == b; });
}

std::optional<FileFormat> file_format_of(std::string_view path) {
  const Extension* const extension = extension_of(path);
  if (extension == nullptr) return std::nullopt;
  return extension->format;
}

std::string writable_extensions() {
  std::string all;
  for (std::size_t i = 0; i < kWritable.size(); ++i) {
    if (i > 0) all += i + 1 == kWritable.size() ? " or " : ", ";
    all += kWritable[i].end;
  }
  return all;
}

bool has_readable_extension(std::string_view path) {
  for (const std::string_view compression : {".gz", ".zst"}) {
    if (has_extension(path, compression)) {
      path.remove_suffix(compression.size());
      break;
    }
  }
  return std::ranges::any_of(kReadable, [path](std::string_view end) { return has_extension(path, end); });
}

bool has_labels_only(FileFormat format) { return format == FileFormat::kSegsJson || format == FileFormat::kKittiLabel; }

std::string scene_name(std::string_view path) {
  const std::size_t slash = path.find_last_of('/');
  if (slash != std::string_view::npos) path.remove_prefix(slash + 1);
  if (const Extension* const extension = extension_of(path)) path.remove_suffix(extension->end.size());
  return std::string(path);
}

absl::StatusOr<EncodedFile> encode_file(const FileContent& content, FileFormat format, FileEncoding encoding,
                                        std::string_view scene) {
  const bool text = encoding == FileEncoding::kText;
  switch (format) {
    case FileFormat::kPcd:
      return EncodedFile{encode_pcd(content, text ? PcdEncoding::kAscii : PcdEncoding::kBinaryCompressed), {}};
    case FileFormat::kPly:
      return EncodedFile{encode_ply(content, text ? PlyEncoding::kAscii : PlyEncoding::kBinaryLittleEndian), {}};
    case FileFormat::kLas:
      return encode_las(content);
    case FileFormat::kXyz:
      return EncodedFile{encode_text_table(content, Separator::kSpace), {}};
    case FileFormat::kCsv:
      return EncodedFile{encode_text_table(content, Separator::kComma), {}};
    case FileFormat::kNpy:
      return EncodedFile{encode_npy(content), {}};
    case FileFormat::kSegsJson:
      RETURN_IF_ERROR(check_labels(content));
      return EncodedFile{encode_segs_json(content.label, scene), {}};
    case FileFormat::kKittiLabel: {
      RETURN_IF_ERROR(check_labels(content));
      ASSIGN_OR_RETURN(std::string bytes, encode_kitti_label(content.label));
      return EncodedFile{std::move(bytes), {}};
    }
    case FileFormat::kGlb:
      return encode_gltf(content, GltfForm::kBinary);
    case FileFormat::kGltf:
      break;
  }
  return encode_gltf(content, GltfForm::kText);
}

}  // namespace segserve::codec
