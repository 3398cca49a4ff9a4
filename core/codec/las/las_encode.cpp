// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/las/las.hpp"
#include "core/codec/las/las_axis.hpp"
#include "core/codec/las/las_dimensions.hpp"
#include "core/codec/las/las_fields.hpp"
#include "core/codec/las/las_header.hpp"

namespace segserve::codec {
namespace {

constexpr std::size_t kHeaderBytes = 375;

template <typename T>
void put_number(std::string& out, std::size_t offset, T value) {
  std::memcpy(out.data() + offset, &value, sizeof value);
}

/// A variable length record.
std::string record(std::string_view user, std::uint16_t id, std::string_view payload) {
  std::string out(kLasRecordHeaderBytes, '\0');
  std::memcpy(out.data() + 2, user.data(), user.size());
  put_number(out, 18, id);
  put_number(out, 20, static_cast<std::uint16_t>(payload.size()));
  return out.append(payload);
}

/// Writes the points of a cloud that are finite.
class LasWriter {
 public:
  explicit LasWriter(const FileContent& content) : content_(content) { find_points(); }

  absl::StatusOr<EncodedFile> run() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSIGN_OR_RETURN(axes_[axis], choose_axis(content_, axis, points_));
    }
    const bool has_color = content_.cloud.has_color();
    format_ = has_color ? 7 : 6;
    const LasLayout layout = las_layout(format_);
    const LasDimensions dimensions(content_, points_, layout, out_.warnings);
    record_bytes_ = layout.bytes + dimensions.extra_bytes();
    body_.resize(points_.size() * record_bytes_);
    for (std::size_t axis = 0; axis < 3; ++axis) write_axis(axis);
    if (has_color) write_color(*layout.color);
    dimensions.write(body_.data(), record_bytes_);
    finish(dimensions.descriptions());
    return std::move(out_);
  }

 private:
  void find_points() {
    const CloudView& cloud = content_.cloud;
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      bool finite = is_finite(cloud.x[i], cloud.y[i], cloud.z[i]);
      if (content_.position != nullptr) {
        finite = std::ranges::all_of(*content_.position, [i](const auto& axis) { return std::isfinite(axis[i]); });
      }
      if (finite) points_.push_back(i);
    }
    if (points_.size() == cloud.size()) return;
    out_.warnings.push_back({WarningReason::kPointsNotUsed,
                             fmt::format("{} points that are not finite are left out, because LAS has no such points",
                                         cloud.size() - points_.size())});
  }

  void write_axis(std::size_t axis) {
    char* to = body_.data() + 4 * axis;
    for (const std::uint32_t point : points_) {
      const std::int32_t value = axes_[axis].to_integer(coordinate(content_, axis, point));
      std::memcpy(to, &value, sizeof value);
      to += record_bytes_;
    }
  }

  void write_color(std::size_t offset) {
    constexpr unsigned kFull = 257;  // makes 255 65535
    char* to = body_.data() + offset;
    for (const std::uint32_t point : points_) {
      const std::uint32_t rgb = content_.cloud.rgb[point];
      const std::array<std::uint16_t, 3> color{static_cast<std::uint16_t>(red(rgb) * kFull),
                                               static_cast<std::uint16_t>(green(rgb) * kFull),
                                               static_cast<std::uint16_t>(blue(rgb) * kFull)};
      std::memcpy(to, color.data(), sizeof color);
      to += record_bytes_;
    }
  }

  /// How many points are the first return of their pulse, the second, and so on to the 15th.
  std::array<std::uint64_t, 15> returns() const {
    std::array<std::uint64_t, 15> counts{};
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const unsigned number = static_cast<unsigned char>(body_[i * record_bytes_ + 14]) & 0xFU;
      if (number > 0) ++counts[number - 1];
    }
    return counts;
  }

  /// Appends the records of the coordinate reference system to `records`. Returns how many they are.
  std::uint16_t put_reference_system(std::string& records) {
    std::uint16_t count = 0;
    for (const auto& [id, payload] : content_.reference_records) {
      if (payload.size() > std::numeric_limits<std::uint16_t>::max()) {
        out_.warnings.push_back({WarningReason::kAttributeNotKept,
                                 fmt::format("record {} of the coordinate reference system is not kept, because it has "
                                             "{} bytes; the coordinates are",
                                             id, payload.size())});
        continue;
      }
      records += record(kLasProjectionUser, id, payload);
      ++count;
    }
    return count;
  }

  /// The statements of a LAS file. The unit is always among them where a reference system might tell another one.
  std::vector<std::string> statements() const {
    std::vector<std::string> all = statements_of(content_);
    if (content_.unit == LengthUnit::kMeter && !content_.reference_records.empty()) {
      all.push_back(unit_statement(LengthUnit::kMeter));
    }
    return all;
  }

  void finish(const std::string& descriptions) {
    std::string records;
    std::uint16_t count = 0;
    for (const std::string& statement : statements()) {
      records += record(kLasStatementUser, static_cast<std::uint16_t>(kLasFirstStatement + count), statement);
      ++count;
    }
    count += put_reference_system(records);
    if (!descriptions.empty()) {
      records += record(kLasSpecUser, kLasExtraBytesRecord, descriptions);
      ++count;
    }
    std::string header(kHeaderBytes, '\0');
    std::memcpy(header.data(), "LASF", 4);
    // The specification wants a text as reference system in the formats from 6 on. A file that has only GeoKeys keeps
    // them, and says so, which readers understand.
    const auto& reference = content_.reference_records;
    const bool has_keys_alone =
        !reference.empty() && std::ranges::find(reference, kLasTextRecord, &ReferenceRecord::id) == reference.end();
    const unsigned encoding =
        (has_keys_alone ? 0U : kLasTextSystem) | (content_.has_standard_gps_time ? kLasStandardGpsTime : 0U);
    put_number(header, 6, static_cast<std::uint16_t>(encoding));
    put_number<std::uint8_t>(header, 24, 1);
    put_number<std::uint8_t>(header, 25, 4);
    std::memcpy(header.data() + 26, "segserve", 8);
    std::memcpy(header.data() + 58, "segserve", 8);
    put_number(header, 94, static_cast<std::uint16_t>(kHeaderBytes));
    put_number(header, 96, static_cast<std::uint32_t>(kHeaderBytes + records.size()));
    put_number(header, 100, std::uint32_t{count});
    put_number(header, 104, static_cast<std::uint8_t>(format_));
    put_number(header, 105, static_cast<std::uint16_t>(record_bytes_));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      put_number(header, 131 + 8 * axis, axes_[axis].scale);
      put_number(header, 155 + 8 * axis, axes_[axis].offset);
      put_number(header, 179 + 16 * axis, axes_[axis].high);
      put_number(header, 187 + 16 * axis, axes_[axis].low);
    }
    put_number(header, 247, std::uint64_t{points_.size()});
    put_number(header, 255, returns());
    out_.bytes = header + records + body_;
  }

  const FileContent& content_;
  std::vector<std::uint32_t> points_;  // those that are written
  std::array<LasAxis, 3> axes_;
  unsigned format_ = 6;
  std::size_t record_bytes_ = 0;
  std::string body_;
  EncodedFile out_;
};

}  // namespace

absl::StatusOr<EncodedFile> encode_las(const FileContent& content) { return LasWriter(content).run(); }

}  // namespace segserve::codec
