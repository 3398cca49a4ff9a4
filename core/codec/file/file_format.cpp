// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/file_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/gltf/gltf.hpp"
#include "core/codec/label_list/label_list.hpp"
#include "core/codec/las/las.hpp"
#include "core/codec/npy/npy.hpp"
#include "core/codec/pcd/pcd_viewpoint.hpp"
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

struct ReadableExtension {
  std::string_view end;
  bool may_have_labels = true;
};

constexpr std::array<ReadableExtension, 11> kReadable{{
    {".pcd"},
    {".ply"},
    {".las"},
    {".xyz"},
    {".txt"},
    {".csv"},
    {".pts"},
    {".obj", false},
    {".npy"},
    {".npz"},
    {".bin", false},
}};
constexpr std::array<std::string_view, 2> kCompressed{".gz", ".zst"};

/// ".pcd, .ply or .las"
std::string listed(std::span<const std::string_view> ends) {
  std::string all;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (i > 0) all += i + 1 == ends.size() ? " or " : ", ";
    all += ends[i];
  }
  return all;
}

/// The row of the end of a name, which may also tell a compression; null if there is none.
const ReadableExtension* readable_extension_of(std::string_view path) {
  for (const std::string_view compression : kCompressed) {
    if (has_extension(path, compression)) {
      path.remove_suffix(compression.size());
      break;
    }
  }
  const auto found =
      std::ranges::find_if(kReadable, [path](const ReadableExtension& e) { return has_extension(path, e.end); });
  return found == kReadable.end() ? nullptr : &*found;
}

const Extension* extension_of(std::string_view path) {
  const auto found = std::ranges::find_if(kWritable, [path](const Extension& e) { return has_extension(path, e.end); });
  return found == kWritable.end() ? nullptr : &*found;
}

absl::Status check_labels(const FileContent& content) {
  if (content.label.size() == content.cloud.size()) return absl::OkStatus();
  return absl::InvalidArgumentError("the format has nothing but labels, and the cloud has none");
}

/// Whether the format is one for clouds that are read again, and has points in a single row.
bool has_a_single_row(FileFormat format) {
  return format == FileFormat::kPly || format == FileFormat::kLas || format == FileFormat::kXyz ||
         format == FileFormat::kCsv;
}

/// Whether the format is one for clouds that are read again.
bool is_read_again(FileFormat format) {
  return has_a_single_row(format) || format == FileFormat::kPcd || format == FileFormat::kNpy;
}

absl::StatusOr<EncodedFile> encode_as(const FileContent& content, FileFormat format, FileEncoding encoding,
                                      std::string_view scene) {
  const bool text = encoding == FileEncoding::kText;
  switch (format) {
    case FileFormat::kPcd:
      return EncodedFile{encode_pcd(content, text ? PcdEncoding::kAscii : PcdEncoding::kBinaryCompressed), {}};
    case FileFormat::kPly: {
      EncodedFile file;
      file.bytes = encode_ply(content, text ? PlyEncoding::kAscii : PlyEncoding::kBinaryLittleEndian, &file.warnings);
      return file;
    }
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
  std::array<std::string_view, kWritable.size()> ends;
  std::ranges::transform(kWritable, ends.begin(), &Extension::end);
  return listed(ends);
}

std::string readable_extensions(ReadableFor use) {
  std::vector<std::string_view> ends;
  for (const ReadableExtension& extension : kReadable) {
    if (extension.may_have_labels || use == ReadableFor::kSegmentation) ends.push_back(extension.end);
  }
  return fmt::format("{}, also compressed as {}", listed(ends), listed(kCompressed));
}

bool has_readable_extension(std::string_view path, ReadableFor use) {
  const ReadableExtension* const extension = readable_extension_of(path);
  return extension != nullptr && (extension->may_have_labels || use == ReadableFor::kSegmentation);
}

bool has_labels_only(FileFormat format) { return format == FileFormat::kSegsJson || format == FileFormat::kKittiLabel; }

std::string scene_name(std::string_view path) {
  const std::size_t slash = path.find_last_of('/');
  if (slash != std::string_view::npos) path.remove_prefix(slash + 1);
  if (const Extension* const extension = extension_of(path)) path.remove_suffix(extension->end.size());
  return std::string(path);
}

std::vector<Warning> losses_of(const FileContent& content, FileFormat format) {
  std::vector<std::string> messages;
  const CloudView& cloud = content.cloud;
  if (cloud.height > 1 && has_a_single_row(format)) {
    messages.push_back(
        fmt::format("the rows and columns of the organized cloud ({} x {}) are not kept; PCD and NPY keep them",
                    cloud.width, cloud.height));
  }
  if (content.viewpoint && is_read_again(format)) {
    const bool keeps = keeps_viewpoint(content);
    if (format == FileFormat::kPcd) {
      if (!keeps)
        messages.emplace_back("the file's VIEWPOINT is not kept, because another place of the sensor was given");
    } else if (content.viewpoint->is_turned() || !keeps || !content.cloud.view.sensor) {
      messages.emplace_back("the file's VIEWPOINT is not kept; PCD keeps it");
    }
  }
  if (!content.reference_records.empty() && format != FileFormat::kLas && !has_labels_only(format)) {
    messages.emplace_back("the coordinate reference system is not kept; LAS keeps it, and the coordinates stay");
  }
  std::vector<Warning> losses;
  losses.reserve(messages.size());
  for (std::string& message : messages) losses.push_back({WarningReason::kAttributeNotKept, std::move(message)});
  return losses;
}

absl::StatusOr<EncodedFile> encode_file(const FileContent& content, FileFormat format, FileEncoding encoding,
                                        std::string_view scene) {
  ASSIGN_OR_RETURN(EncodedFile file, encode_as(content, format, encoding, scene));
  for (Warning& loss : losses_of(content, format)) file.warnings.push_back(std::move(loss));
  return file;
}

}  // namespace segserve::codec
