// SPDX-License-Identifier: Apache-2.0
#include "client/recording/foxglove/foxglove_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "client/recording/bytes/append.hpp"
#include "client/recording/bytes/byte_cursor.hpp"
#include "client/recording/foxglove/proto_reader.hpp"

namespace segserve::recording {
namespace {

using codec::PointDatatype;

constexpr std::uint32_t kMaxFields = 4096;

/// The datatype of each number of PackedElementField.NumericType.
constexpr std::array<PointDatatype, 9> kDatatypes{
    PointDatatype{0},       PointDatatype::kUint8,   PointDatatype::kInt8,
    PointDatatype::kUint16, PointDatatype::kInt16,   PointDatatype::kUint32,
    PointDatatype::kInt32,  PointDatatype::kFloat32, PointDatatype::kFloat64};

absl::Status damaged(std::string_view bytes, std::string_view type) {
  return absl::InvalidArgumentError(fmt::format("the {} bytes of the message are no {}", bytes.size(), type));
}

/// google.protobuf.Timestamp as nanoseconds; those beyond 64 bits become 0.
std::int64_t read_timestamp(std::string_view bytes) {
  constexpr std::int64_t kMostSeconds = 9'000'000'000;
  std::int64_t seconds = 0;
  std::int64_t nanoseconds = 0;
  ProtoReader reader(bytes);
  while (const auto field = reader.next()) {
    if (field->number == 1) seconds = static_cast<std::int64_t>(field->value);
    if (field->number == 2) nanoseconds = static_cast<std::int32_t>(field->value);
  }
  if (seconds < -kMostSeconds || seconds > kMostSeconds) return 0;
  return seconds * kNanosecondsPerSecond + nanoseconds;
}

codec::PointField read_field(std::string_view bytes) {
  codec::PointField result;
  result.datatype = PointDatatype{0};
  ProtoReader reader(bytes);
  while (const auto field = reader.next()) {
    if (field->number == 1) result.name = field->bytes;
    if (field->number == 2) result.offset = static_cast<std::uint32_t>(field->value);
    if (field->number == 3 && field->value < kDatatypes.size()) result.datatype = kDatatypes[field->value];
  }
  return result;
}

/// Whether a foxglove.Pose moves anything: any number of it but w of the quaternion, which is 1, is not 0.
bool is_moved(std::string_view pose) {
  ProtoReader parts(pose);
  while (const auto part = parts.next()) {
    ProtoReader numbers(part->bytes);
    while (const auto number = numbers.next()) {
      const bool is_w = part->number == 2 && number->number == 4;
      if (!is_w && number->as_double() != 0) return true;
    }
  }
  return false;
}

/// Appends the numbers of a repeated double, which are packed into one field, or in one field each.
void append_doubles(const ProtoField& field, std::vector<double>& out) {
  if (field.bytes.empty()) return out.push_back(field.as_double());
  ByteCursor cursor(field.bytes);
  while (cursor.rest().size() >= sizeof(double)) out.push_back(std::bit_cast<double>(cursor.number<std::uint64_t>()));
}

void append_varint(std::string& out, std::uint64_t value) {
  for (; value >= 0x80U; value >>= 7U) out += static_cast<char>(value | 0x80U);
  out += static_cast<char>(value);
}

void append_bytes(std::string& out, std::uint32_t number, std::string_view bytes) {
  append_varint(out, number << 3U | 2U);
  append_varint(out, bytes.size());
  out += bytes;
}

void append_fixed32(std::string& out, std::uint32_t number, std::uint32_t value) {
  append_varint(out, number << 3U | 5U);
  append_number(out, value);
}

}  // namespace

absl::StatusOr<PointCloud2> parse_foxglove_cloud(std::string_view bytes) {
  PointCloud2 cloud;
  ProtoReader reader(bytes);
  while (const auto field = reader.next()) {
    if (field->number == 1) cloud.header.stamp = read_timestamp(field->bytes);
    if (field->number == 2) cloud.header.frame_id = field->bytes;
    if (field->number == 3) cloud.has_pose = is_moved(field->bytes);
    if (field->number == 4) cloud.layout.point_step = static_cast<std::uint32_t>(field->value);
    if (field->number == 5) cloud.layout.fields.push_back(read_field(field->bytes));
    if (field->number == 6) cloud.data = field->bytes;
    if (cloud.layout.fields.size() > kMaxFields) break;
  }
  if (!reader.ok() || cloud.layout.fields.size() > kMaxFields) return damaged(bytes, "foxglove.PointCloud");
  const std::uint32_t stride = cloud.layout.point_step;
  if (stride == 0 ? !cloud.data.empty() : cloud.data.size() % stride != 0) {
    return absl::InvalidArgumentError(
        fmt::format("the data have {} bytes, which are no whole points of point_stride {}", cloud.data.size(), stride));
  }
  cloud.layout.height = 1;
  cloud.layout.width = static_cast<std::uint32_t>(stride == 0 ? 0 : cloud.data.size() / stride);
  cloud.layout.row_step = static_cast<std::uint32_t>(cloud.data.size());
  return cloud;
}

std::string with_points(std::string_view bytes, const codec::StridedLayout& layout, std::string_view data) {
  std::string out;
  ProtoReader reader(bytes);
  while (const auto field = reader.next()) {
    if (field->number < 4 || field->number > 6) out += field->whole;
  }
  append_fixed32(out, 4, layout.point_step);
  for (const codec::PointField& field : layout.fields) {
    std::string packed;
    append_bytes(packed, 1, field.name);
    append_fixed32(packed, 2, field.offset);
    append_varint(packed, 3U << 3U);
    append_varint(packed,
                  static_cast<std::uint64_t>(std::ranges::find(kDatatypes, field.datatype) - kDatatypes.begin()));
    append_bytes(out, 5, packed);
  }
  append_bytes(out, 6, data);
  return out;
}

absl::StatusOr<RawImage> parse_foxglove_raw_image(std::string_view bytes) {
  RawImage image;
  ProtoReader reader(bytes);
  while (const auto field = reader.next()) {
    if (field->number == 1) image.header.stamp = read_timestamp(field->bytes);
    if (field->number == 2) image.width = static_cast<std::uint32_t>(field->value);
    if (field->number == 3) image.height = static_cast<std::uint32_t>(field->value);
    if (field->number == 4) image.encoding = field->bytes;
    if (field->number == 5) image.step = static_cast<std::uint32_t>(field->value);
    if (field->number == 6) image.data = field->bytes;
    if (field->number == 7) image.header.frame_id = field->bytes;
  }
  if (!reader.ok()) return damaged(bytes, "foxglove.RawImage");
  return image;
}

absl::StatusOr<CompressedImage> parse_foxglove_compressed_image(std::string_view bytes) {
  CompressedImage image;
  ProtoReader reader(bytes);
  while (const auto field = reader.next()) {
    if (field->number == 1) image.header.stamp = read_timestamp(field->bytes);
    if (field->number == 2) image.data = field->bytes;
    if (field->number == 3) image.format = field->bytes;
    if (field->number == 4) image.header.frame_id = field->bytes;
  }
  if (!reader.ok()) return damaged(bytes, "foxglove.CompressedImage");
  return image;
}

absl::StatusOr<CameraInfo> parse_foxglove_calibration(std::string_view bytes) {
  CameraInfo info;
  std::vector<double> k;
  std::vector<double> p;
  ProtoReader reader(bytes);
  while (const auto field = reader.next()) {
    if (field->number == 2) info.width = static_cast<std::uint32_t>(field->value);
    if (field->number == 3) info.height = static_cast<std::uint32_t>(field->value);
    if (field->number == 5) append_doubles(*field, info.distortion);
    if (field->number == 6) append_doubles(*field, k);
    if (field->number == 8) append_doubles(*field, p);
  }
  if (!reader.ok()) return damaged(bytes, "foxglove.CameraCalibration");
  std::copy_n(k.begin(), std::min(k.size(), info.k.size()), info.k.begin());
  std::copy_n(p.begin(), std::min(p.size(), info.p.size()), info.p.begin());
  return info;
}

}  // namespace segserve::recording
