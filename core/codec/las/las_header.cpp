// SPDX-License-Identifier: Apache-2.0
#include "core/codec/las/las_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/common/surplus_lines.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/las/las_fields.hpp"
#include "core/codec/las/las_records.hpp"

namespace segserve::codec {
namespace {

// Offsets in the header.
constexpr std::size_t kEncoding = 6, kMajor = 24, kMinor = 25, kHeaderBytes = 94, kBodyOffset = 96, kRecords = 100,
                      kFormat = 104, kRecordBytes = 105, kOldCount = 107, kScale = 131, kOffset = 155, kWaveforms = 227,
                      kExtended = 235, kExtendedCount = 243, kCount = 247;
constexpr std::size_t kLeastHeader = 227, kLeastHeader13 = 235, kLeastHeader14 = 375;
constexpr unsigned kNewestMinor = 4;

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError("LAS header: " + fmt::format(format, std::forward<Args>(args)...));
}

/// Reads numbers at offsets that the caller has checked.
class HeaderBytes {
 public:
  explicit HeaderBytes(std::span<const std::byte> file) : file_(file) {}
  template <typename T>
  T at(std::size_t offset) const {
    return load<T>(file_.data() + offset);
  }

 private:
  std::span<const std::byte> file_;
};

absl::Status check_version(const HeaderBytes& bytes) {
  const unsigned major = bytes.at<std::uint8_t>(kMajor), minor = bytes.at<std::uint8_t>(kMinor);
  if (major == 1 && minor <= kNewestMinor) return absl::OkStatus();
  return fault("version {}.{} is not known; 1.0 to 1.4 are", major, minor);
}

absl::Status check_format(std::uint8_t format) {
  constexpr unsigned kCompressed = 0xC0;
  if ((format & kCompressed) != 0) {
    return absl::InvalidArgumentError(
        "this is LAZ, or COPC, which is compressed LAS and cannot be read; las2las or pdal translate makes a LAS file "
        "of it, which can");
  }
  if (format > kMostLasFormat) return fault("point format {} is not known; 0 to 10 are", format);
  return absl::OkStatus();
}

absl::Status read_transform(const HeaderBytes& bytes, LasHeader& header) {
  constexpr std::string_view kAxes = "xyz";
  for (std::size_t axis = 0; axis < 3; ++axis) {
    header.scale[axis] = bytes.at<double>(kScale + 8 * axis);
    header.offset[axis] = bytes.at<double>(kOffset + 8 * axis);
    if (!std::isfinite(header.scale[axis]) || header.scale[axis] == 0) {
      return fault("the scale of {} is {}", kAxes[axis], header.scale[axis]);
    }
    if (!std::isfinite(header.offset[axis])) return fault("the offset of {} is {}", kAxes[axis], header.offset[axis]);
  }
  return absl::OkStatus();
}

bool has_fields_of(const HeaderBytes& bytes, unsigned minor, std::size_t least_header) {
  return bytes.at<std::uint8_t>(kMinor) >= minor && bytes.at<std::uint16_t>(kHeaderBytes) >= least_header;
}

/// The number of points that the header promises. Version 1.4 has it a second time, with 64 bits.
std::uint64_t promised_points(const HeaderBytes& bytes) {
  const std::uint64_t old = bytes.at<std::uint32_t>(kOldCount);
  if (!has_fields_of(bytes, 4, kLeastHeader14)) return old;
  const auto wide = bytes.at<std::uint64_t>(kCount);
  return wide != 0 ? wide : old;
}

/// Where the points end at the latest: at the waveforms or the extended records that follow them, or with the file.
std::size_t end_of_points(const HeaderBytes& bytes, std::size_t begin, std::size_t file_bytes) {
  std::size_t end = file_bytes;
  const auto end_at = [&](std::uint64_t offset) {
    if (offset >= begin) end = static_cast<std::size_t>(std::min<std::uint64_t>(end, offset));
  };
  if (has_fields_of(bytes, 3, kLeastHeader13)) end_at(bytes.at<std::uint64_t>(kWaveforms));
  if (has_fields_of(bytes, 4, kLeastHeader14) && bytes.at<std::uint32_t>(kExtendedCount) > 0) {
    end_at(bytes.at<std::uint64_t>(kExtended));
  }
  return end;
}

absl::Status read_extent(std::span<const std::byte> file, std::uint64_t promised, const DecodeLimits& limits,
                         LasHeader& header) {
  const std::size_t least = las_layout(header.point_format).bytes;
  if (header.record_bytes < least) {
    return fault("points of format {} have at least {} bytes, not {}", header.point_format, least, header.record_bytes);
  }
  if (header.body_offset > file.size()) {
    return fault("the points begin at byte {}, but the file has {} bytes", header.body_offset, file.size());
  }
  RETURN_IF_ERROR(check_points("LAS header: ", promised, limits));
  const std::uint64_t held = (file.size() - header.body_offset) / header.record_bytes;
  if (promised > held && held == 0) return fault("{} points are promised, but the file holds none", promised);
  header.points = static_cast<std::size_t>(std::min(promised, held));
  if (promised > held) {
    header.warnings.push_back(
        {WarningReason::kRowsNotUsed, fmt::format("the file is cut off: it holds {} of {} points", held, promised)});
  }
  return absl::OkStatus();
}

/// Looks at the bytes between the promised points and what follows them. A program that was stopped leaves a header
/// that promises no points, and then all of them are read; else they are mentioned.
absl::Status read_surplus(std::span<const std::byte> file, std::size_t end, const DecodeLimits& limits,
                          LasHeader& header) {
  const std::size_t promised_end = header.body_offset + header.points * header.record_bytes;
  if (end <= promised_end) return absl::OkStatus();
  std::vector<Warning> surplus;
  warn_of_surplus_bytes(file.subspan(promised_end, end - promised_end), header.record_bytes, surplus);
  if (surplus.empty()) return absl::OkStatus();
  if (header.points > 0) {
    header.warnings.push_back(std::move(surplus[0]));
    return absl::OkStatus();
  }
  header.points = (end - header.body_offset) / header.record_bytes;
  header.warnings.push_back(
      {WarningReason::kRowsNotUsed,
       fmt::format("the header promises no points, and the file holds {}, which are read", header.points)});
  return check_points("LAS file: ", header.points, limits);
}

/// Reads the variable length records of both kinds, and what they tell of the reference system.
void read_all_records(std::span<const std::byte> file, StopCheck& check, LasHeader& header) {
  const HeaderBytes bytes(file);
  const std::size_t header_bytes = bytes.at<std::uint16_t>(kHeaderBytes);
  read_las_records(file.subspan(header_bytes, header.body_offset - header_bytes), LasRecordKind::kShort,
                   bytes.at<std::uint32_t>(kRecords), check, header);
  if (has_fields_of(bytes, 4, kLeastHeader14)) {
    const auto begin =
        static_cast<std::size_t>(std::min<std::uint64_t>(bytes.at<std::uint64_t>(kExtended), file.size()));
    read_las_records(file.subspan(begin), LasRecordKind::kExtended, bytes.at<std::uint32_t>(kExtendedCount), check,
                     header);
  }
  const bool is_text = (bytes.at<std::uint16_t>(kEncoding) & kLasTextSystem) != 0;
  header.reference_system = header.reference_records.read(is_text, header.warnings);
}

}  // namespace

bool is_las(std::string_view file) { return file.starts_with("LASF"); }

absl::StatusOr<LasHeader> parse_las_header(std::span<const std::byte> file, const DecodeLimits& limits,
                                           StopCheck& check) {
  if (file.size() < kLeastHeader) return fault("it has {} bytes and needs {}", file.size(), kLeastHeader);
  const HeaderBytes bytes(file);
  RETURN_IF_ERROR(check_version(bytes));
  RETURN_IF_ERROR(check_format(bytes.at<std::uint8_t>(kFormat)));
  LasHeader header;
  header.point_format = bytes.at<std::uint8_t>(kFormat);
  header.record_bytes = bytes.at<std::uint16_t>(kRecordBytes);
  header.body_offset = bytes.at<std::uint32_t>(kBodyOffset);
  header.has_standard_gps_time = (bytes.at<std::uint16_t>(kEncoding) & kLasStandardGpsTime) != 0;
  const std::size_t header_bytes = bytes.at<std::uint16_t>(kHeaderBytes);
  if (header_bytes < kLeastHeader || header_bytes > header.body_offset) {
    return fault("its length is {} bytes, and the points begin at byte {}", header_bytes, header.body_offset);
  }
  if (header_bytes > file.size()) return fault("it has {} bytes and needs {}", file.size(), header_bytes);
  RETURN_IF_ERROR(read_transform(bytes, header));
  RETURN_IF_ERROR(read_extent(file, promised_points(bytes), limits, header));
  RETURN_IF_ERROR(read_surplus(file, end_of_points(bytes, header.body_offset, file.size()), limits, header));
  read_all_records(file, check, header);
  RETURN_IF_ERROR(check.status());
  return header;
}

}  // namespace segserve::codec
