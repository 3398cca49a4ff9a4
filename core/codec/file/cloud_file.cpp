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

#include "absl/strings/cord.h"
#include "core/codec/common/text_parsing.hpp"
#include "segserve/codec/pcd.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kStandardStream = "-";

struct CloseFile {
  void operator()(std::FILE* file) const {
    if (file != stdin && file != stdout) std::fclose(file);
  }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// The same status, its message with the path in front.
absl::Status in_file(const std::string& path, const absl::Status& status) {
  absl::Status out(status.code(),
                   fmt::format("{}: {}", path, std::string_view(status.message().data(), status.message().size())));
  status.ForEachPayload([&](auto key, const absl::Cord& payload) { out.SetPayload(key, payload); });
  return out;
}

absl::Status open_error(const std::string& path, int error) {
  return in_file(path, absl::ErrnoToStatus(error, "cannot be opened"));
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
      return over_limit(fmt::format("more than the limit of {} bytes", limits.max_bytes),
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
  if (!bytes.ok()) return in_file(path, bytes.status());
  return bytes;
}

absl::Status write_path(const std::string& path, const std::string& bytes) {
  File file(path == kStandardStream ? stdout : std::fopen(path.c_str(), "wb"));
  if (!file) return open_error(path, errno);
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file.get()) == bytes.size();
  if (!written || std::fflush(file.get()) != 0) {
    return in_file(path, absl::UnavailableError(fmt::format("writing failed: {}", std::strerror(errno))));
  }
  return absl::OkStatus();
}

bool has_extension(const std::string& path, std::string_view extension) {
  if (path.size() < extension.size()) return false;
  const std::string_view end = std::string_view(path).substr(path.size() - extension.size());
  return std::equal(end.begin(), end.end(), extension.begin(),
                    [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

}  // namespace

absl::StatusOr<LabelledCloud> decode_cloud(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                           std::optional<View> view) {
  return is_ply(as_text(bytes)) ? decode_ply(bytes, limits, view) : decode_pcd(bytes, limits, view);
}

absl::StatusOr<LabelledCloud> load_cloud(const std::string& path, std::optional<View> view,
                                         const DecodeLimits& limits) {
  const auto bytes = read_path(path, limits);
  if (!bytes.ok()) return bytes.status();
  auto cloud = decode_cloud(*bytes, limits, view);
  if (!cloud.ok()) return in_file(path, cloud.status());
  return cloud;
}

absl::Status save_cloud(const std::string& path, const CloudView& cloud, std::span<const std::uint32_t> label,
                        FileEncoding encoding) {
  const bool text = encoding == FileEncoding::kText;
  if (path == kStandardStream || has_extension(path, ".pcd")) {
    return write_path(path, encode_pcd(cloud, label, text ? PcdEncoding::kAscii : PcdEncoding::kBinaryCompressed));
  }
  if (has_extension(path, ".ply")) {
    return write_path(path, encode_ply(cloud, label, text ? PlyEncoding::kAscii : PlyEncoding::kBinaryLittleEndian));
  }
  return in_file(path, absl::InvalidArgumentError("a cloud is written to a name that ends in .pcd or .ply"));
}

}  // namespace segserve::codec
