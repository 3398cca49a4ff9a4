// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/cloud_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/file/known_formats.hpp"
#include "segserve/codec/pcd.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kStandardStream = "-";

/// Closes a file unless it is a standard stream.
struct CloseFile {
  void operator()(std::FILE* file) const {
    if (file != stdin && file != stdout) std::fclose(file);
  }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

absl::Status open_error(const std::string& path, int error) {
  return with_prefix(path, absl::ErrnoToStatus(error, "cannot be opened"));
}

absl::StatusOr<std::vector<std::byte>> read_all(std::FILE* file, const DecodeLimits& limits) {
  constexpr std::size_t kChunk = std::size_t{1} << 20U;
  std::vector<std::byte> bytes;
  std::size_t size = 0;
  while (true) {
    bytes.resize(std::max(size + kChunk, size + size / 2));
    const std::size_t got = std::fread(bytes.data() + size, 1, bytes.size() - size, file);
    size += got;
    if (size > limits.max_bytes) {
      return over_limit(fmt::format("it has more bytes than the limit of {}", limits.max_bytes),
                        {"max_bytes", size, limits.max_bytes});
    }
    if (got == 0) break;
  }
  if (std::ferror(file) != 0) return absl::UnavailableError(fmt::format("reading failed: {}", std::strerror(errno)));
  bytes.resize(size);
  return bytes;
}

absl::StatusOr<std::vector<std::byte>> read_path(const std::string& path, const DecodeLimits& limits) {
  const File file(path == kStandardStream ? stdin : std::fopen(path.c_str(), "rb"));
  if (!file) return open_error(path, errno);
  auto bytes = read_all(file.get(), limits);
  if (!bytes.ok()) return with_prefix(path, bytes.status());
  return bytes;
}

absl::Status write_path(const std::string& path, const std::string& bytes) {
  File file(path == kStandardStream ? stdout : std::fopen(path.c_str(), "wb"));
  if (!file) return open_error(path, errno);
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  if (!written || std::fflush(file.get()) != 0) {
    return with_prefix(path, absl::UnavailableError(fmt::format("writing failed: {}", std::strerror(errno))));
  }
  return absl::OkStatus();
}

/// Whether the path ends in `extension`, which is in lower case, in any case.
bool has_extension(const std::string& path, std::string_view extension) {
  if (path.size() < extension.size()) return false;
  const std::string_view end = std::string_view(path).substr(path.size() - extension.size());
  return std::equal(end.begin(), end.end(), extension.begin(),
                    [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

}  // namespace

absl::StatusOr<LabeledCloud> decode_cloud(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                          const ReadOptions& options, const StopToken& stop) {
  const auto with_format = [](absl::StatusOr<LabeledCloud> cloud, const char* format) {
    if (cloud.ok()) cloud->format = format;
    return cloud;
  };
  if (is_ply(as_text(bytes))) return with_format(decode_ply(bytes, limits, options, stop), "PLY");
  if (const auto advice = advice_on_format(as_text(bytes))) return absl::InvalidArgumentError(*advice);
  return with_format(decode_pcd(bytes, limits, options, stop), "PCD");
}

absl::StatusOr<LabeledCloud> load_cloud(const std::string& path, const ReadOptions& options,
                                        const DecodeLimits& limits) {
  ASSIGN_OR_RETURN(const std::vector<std::byte> bytes, read_path(path, limits));
  auto cloud = decode_cloud(bytes, limits, options);
  if (!cloud.ok()) return with_prefix(path, cloud.status());
  return cloud;
}

absl::Status save_cloud(const std::string& path, const FileContent& content, FileEncoding encoding) {
  const bool text = encoding == FileEncoding::kText;
  if (path == kStandardStream || has_extension(path, ".pcd")) {
    return write_path(path, encode_pcd(content, text ? PcdEncoding::kAscii : PcdEncoding::kBinaryCompressed));
  }
  if (has_extension(path, ".ply")) {
    return write_path(path, encode_ply(content, text ? PlyEncoding::kAscii : PlyEncoding::kBinaryLittleEndian));
  }
  return with_prefix(path, absl::InvalidArgumentError("the name of a cloud must end in .pcd or .ply"));
}

absl::Status save_cloud(const std::string& path, const CloudView& cloud, std::span<const std::uint32_t> label,
                        FileEncoding encoding) {
  return save_cloud(path, FileContent{.cloud = cloud, .label = label}, encoding);
}

}  // namespace segserve::codec
