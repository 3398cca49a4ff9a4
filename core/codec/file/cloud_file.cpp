// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/cloud_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/input_bytes.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/compressed_file.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/file/known_formats.hpp"
#include "core/codec/las/las.hpp"
#include "core/codec/las/las_header.hpp"
#include "core/codec/lidar_scan/lidar_scan.hpp"
#include "core/codec/npy/npy.hpp"
#include "core/codec/npy/npy_header.hpp"
#include "core/codec/obj/obj.hpp"
#include "core/codec/text/text_table.hpp"
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

absl::StatusOr<std::string> read_path(const std::string& path, const DecodeLimits& limits, const StopToken& stop) {
  auto bytes = read_input_bytes(path, limits.max_bytes, stop);
  if (absl::IsNotFound(bytes.status()) || absl::IsPermissionDenied(bytes.status())) {
    return with_prefix(path + ": cannot be opened", bytes.status());
  }
  if (!bytes.ok()) return with_prefix(path, bytes.status());
  if (bytes->size() <= limits.max_bytes) return bytes;
  const auto status = over_limit(fmt::format("it has more bytes than the limit of {}", limits.max_bytes),
                                 {"max_bytes", bytes->size(), limits.max_bytes});
  return with_prefix(path, status);
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

using Reader = absl::StatusOr<LabeledCloud> (*)(std::span<const std::byte>, const DecodeLimits&, const ReadOptions&,
                                                const StopToken&);

/// A format that is read.
struct Format {
  const char* name;
  bool (*is_own)(std::string_view file);
  Reader reader;
};

bool is_whole_lidar_scan(std::string_view file) { return is_lidar_scan(file, file.size()); }

constexpr Format kPcd{"PCD", nullptr, decode_pcd};

/// The format of a file that is not compressed. What no other format claims is PCD.
const Format& format_of(std::string_view file) {
  static constexpr std::array<Format, 7> kFormats{{
      {"PLY", is_ply, decode_ply},
      {"LAS", is_las, decode_las},
      {"NPY", is_npy, decode_npy},
      {"NPZ", is_npz, decode_npz},
      {"OBJ", is_obj, decode_obj},
      {"text", is_text_table, decode_text_table},
      {"LiDAR scan", is_whole_lidar_scan, decode_lidar_scan},
  }};
  const auto* const found =
      std::ranges::find_if(kFormats, [file](const Format& format) { return format.is_own(file); });
  return found == kFormats.end() ? kPcd : *found;
}

/// Whether a file begins with text.
bool is_printable(std::string_view file) {
  constexpr std::size_t kEnough = 256;
  constexpr unsigned char kFirst = 0x20, kLast = 0x7e;
  return std::ranges::all_of(file.substr(0, kEnough), [](unsigned char c) {
    return (c >= kFirst && c <= kLast) || c == '\t' || c == '\n' || c == '\r' || c >= 0xC2;
  });
}

absl::StatusOr<LabeledCloud> decode_plain(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                          const ReadOptions& options, const StopToken& stop) {
  const std::string_view file = as_text(bytes);
  const Format& format = format_of(file);
  // The first coordinate of a scan may begin with any bytes.
  if (format.is_own != is_whole_lidar_scan) {
    if (const auto advice = advice_on_format(file)) return absl::InvalidArgumentError(*advice);
  }
  if (file.empty()) return absl::InvalidArgumentError("the file is empty");
  auto cloud = format.reader(bytes, limits, options, stop);
  if (cloud.ok()) cloud->format = format.name;
  // No other format has claimed the file, so that it need not be meant as PCD.
  if (absl::IsInvalidArgument(cloud.status()) && cloud.status().message().substr(0, 14) == "not a PCD file") {
    if (!is_printable(file)) {
      return absl::InvalidArgumentError(
          fmt::format("not a PCD file: its bytes are those of no known format; {} can be "
                      "read; bytes alone tell neither types nor columns: save numbers as NPY",
                      kReadableFormats));
    }
    return absl::InvalidArgumentError(fmt::format("{}; {} can be read", message_of(cloud.status()), kReadableFormats));
  }
  return cloud;
}

/// Decodes what was decompressed. It is in memory beside what is made of it, so that both count towards the limit.
absl::StatusOr<LabeledCloud> decode_decompressed(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                                 const ReadOptions& options, const StopToken& stop) {
  DecodeLimits rest = limits;
  rest.max_bytes = limits.max_bytes - bytes.size();
  auto cloud = decode_plain(bytes, rest, options, stop);
  const auto excess = limit_excess(cloud.status());
  if (!excess || excess->limit != "max_bytes") return cloud;
  return over_limit(fmt::format("{}; its {} decompressed bytes count, too, towards the limit of {}",
                                message_of(cloud.status()), bytes.size(), limits.max_bytes),
                    {"max_bytes", saturating_sum(excess->actual, bytes.size()), limits.max_bytes});
}

}  // namespace

absl::StatusOr<LabeledCloud> decode_cloud(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                          const ReadOptions& options, const StopToken& stop) {
  const auto compression = compression_of(as_text(bytes));
  if (!compression) return decode_plain(bytes, limits, options, stop);
  StopCheck check(stop);
  std::vector<Warning> warnings;
  ASSIGN_OR_RETURN(const auto content, decompress(bytes, *compression, limits, check, warnings));
  ASSIGN_OR_RETURN(LabeledCloud out, decode_decompressed(content.bytes(), limits, options, stop));
  out.warnings.insert(out.warnings.begin(), warnings.begin(), warnings.end());
  out.format += *compression == Compression::kGzip ? ", gzip" : ", zstd";
  return out;
}

bool is_taken_as_pcd(std::span<const std::byte> bytes) {
  const std::string_view file = as_text(bytes);
  return !compression_of(file) && &format_of(file) == &kPcd && !advice_on_format(file);
}

bool is_cloud_file(const std::string& path) {
  if (!has_readable_extension(path)) return false;
  const bool is_scan = has_extension(path, ".bin");
  if (!is_scan && !has_extension(path, ".txt")) return true;
  constexpr std::size_t kEnough = std::size_t{1} << 16U;
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) return true;  // Reading it tells why.
  std::string begin(kEnough, '\0');
  begin.resize(std::fread(begin.data(), 1, begin.size(), file.get()));
  if (!is_scan) return table_kind(begin) == TableKind::kPoints;
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  return !error && is_lidar_scan(begin, size);
}

absl::StatusOr<LabeledCloud> load_cloud(const std::string& path, const ReadOptions& options, const DecodeLimits& limits,
                                        const StopToken& stop) {
  ASSIGN_OR_RETURN(const std::string bytes, read_path(path, limits, stop));
  auto cloud = decode_cloud(std::as_bytes(std::span(bytes)), limits, options, stop);
  if (!cloud.ok()) return with_prefix(path, cloud.status());
  return cloud;
}

absl::Status save_cloud(const std::string& path, const FileContent& content, FileEncoding encoding) {
  const auto format = path == kStandardStream ? FileFormat::kPcd : file_format_of(path);
  if (!format) {
    return with_prefix(
        path, absl::InvalidArgumentError(fmt::format("the name of a cloud must end in {}", writable_extensions())));
  }
  const auto file = encode_file(content, *format, encoding, scene_name(path));
  if (!file.ok()) return with_prefix(path, file.status());
  return write_path(path, file->bytes);
}

absl::Status save_cloud(const std::string& path, const CloudView& cloud, std::span<const std::uint32_t> label,
                        FileEncoding encoding) {
  return save_cloud(path, FileContent{.cloud = cloud, .label = label}, encoding);
}

}  // namespace segserve::codec
