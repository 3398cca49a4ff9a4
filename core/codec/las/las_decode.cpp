// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/las/las.hpp"
#include "core/codec/las/las_fields.hpp"
#include "core/codec/las/las_header.hpp"

namespace segserve::codec {
namespace {

/// Makes the table of a file's points. Values that are not stored as they are get memory of their own.
class LasTable {
 public:
  LasTable(std::span<const std::byte> file, const LasHeader& header, bool keep_everything, StopCheck& check)
      : body_(file.data() + header.body_offset), header_(header), check_(check) {
    table_.width = static_cast<std::uint32_t>(header.points);
    table_.height = 1;
    table_.stated = header.stated;
    table_.column = [this](std::size_t i) { return columns_[i]; };
    const LasLayout layout = las_layout(header.point_format);
    for (std::size_t axis = 0; axis < 3; ++axis) add_axis(axis);
    if (layout.color) add_color(*layout.color);
    const auto label = std::ranges::find_if(header.extra, is_label);
    if (keep_everything) {
      add_fields(layout);
      for (auto extra = header.extra.begin(); extra != header.extra.end(); ++extra) {
        if (extra != label) add_extra(*extra);
      }
    }
    if (label == header.extra.end()) return;
    table_.roles.label = table_.fields.size();
    add_extra(*label);
  }
  const PointTable& table() const { return table_; }

 private:
  void add(Field field, Column column) {
    table_.fields.push_back(field);
    columns_.push_back(column);
  }
  void add_stored(std::string_view name, ScalarType type, std::size_t count, std::size_t offset) {
    add({name, type, count}, {body_ + offset, header_.record_bytes, type});
  }
  template <typename T>
  T* own(std::size_t values) {
    owned_.push_back(std::make_unique_for_overwrite<std::byte[]>(std::max<std::size_t>(values * sizeof(T), 1)));
    return reinterpret_cast<T*>(owned_.back().get());
  }
  template <typename T>
  static Column column_of(const T* values, std::size_t count, ScalarType type) {
    return {reinterpret_cast<const std::byte*>(values), count * sizeof(T), type};
  }

  void add_axis(std::size_t axis) {
    constexpr std::array<std::string_view, 3> kNames{"x", "y", "z"};
    auto* const out = own<double>(header_.points);
    const double scale = header_.scale[axis], offset = header_.offset[axis];
    const Column stored{body_ + 4 * axis, header_.record_bytes, ScalarType::kInt32};
    for_each_value(stored, header_.points, check_,
                   [=](std::size_t i, auto value) { out[i] = static_cast<double>(value) * scale + offset; });
    table_.roles.position[axis] = table_.fields.size();
    add({kNames[axis], ScalarType::kFloat64}, column_of(out, 1, ScalarType::kFloat64));
  }

  void add_color(std::size_t offset) {
    constexpr std::array<std::string_view, 3> kNames{"red", "green", "blue"};
    std::array<std::size_t, 3> channels{};
    for (std::size_t i = 0; i < 3; ++i) {
      channels[i] = table_.fields.size();
      add_stored(kNames[i], ScalarType::kUint16, 1, offset + 2 * i);
    }
    table_.roles.channels = channels;
    if (header_.is_from_segserve) table_.roles.channel_kind = ChannelKind::kSixteenBits;
  }

  static bool is_label(const LasExtra& extra) {
    constexpr std::array<absl::string_view, 3> kNames{"segment", "label", "scalar_label"};
    const auto has_name = [&extra](absl::string_view name) { return absl::EqualsIgnoreCase(extra.name, name); };
    return extra.count == 1 && std::ranges::any_of(kNames, has_name);
  }

  void add_extra(const LasExtra& extra) {
    if (!extra.is_scaled()) return add_stored(extra.name, extra.type, extra.count, extra.offset);
    auto* const out = own<double>(header_.points * extra.count);
    for (std::size_t k = 0; k < extra.count; ++k) {
      const double scale = extra.scale ? (*extra.scale)[k] : 1, shift = extra.shift ? (*extra.shift)[k] : 0;
      const Column stored{body_ + extra.offset + k * size_of(extra.type), header_.record_bytes, extra.type};
      for_each_value(stored, header_.points, check_, [=, count = extra.count](std::size_t i, auto value) {
        out[i * count + k] = static_cast<double>(value) * scale + shift;
      });
    }
    add({extra.name, ScalarType::kFloat64, extra.count}, column_of(out, extra.count, ScalarType::kFloat64));
  }

  /// Whether any of the bytes at the offset is not 0, in any record.
  bool is_used(std::size_t offset, std::size_t bytes) {
    bool used = false;
    check_.for_each(0, header_.points, [&](std::size_t i) {
      const std::byte* const value = body_ + i * header_.record_bytes + offset;
      for (std::size_t k = 0; k < bytes; ++k) used = used || value[k] != std::byte{0};
    });
    return used;
  }
  /// Whether a field says anything: whether it is not 0 for all points, nor 1 for all points if it counts returns.
  bool is_used(const LasField& field) {
    if (!field.is_packed()) return is_used(field.offset, size_of(field.type));
    const unsigned least = field.name.ends_with("return_number") || field.name.starts_with("number_of") ? 1 : 0;
    unsigned low = least, high = 0;
    check_.for_each(0, header_.points, [&](std::size_t i) {
      const unsigned value = field.value_in(body_ + i * header_.record_bytes);
      low = std::min(low, value);
      high = std::max(high, value);
    });
    return high > least || (high == 1 && low == 0);
  }
  bool is_taken(std::string_view name) const {
    return std::ranges::find(header_.extra, name, &LasExtra::name) != header_.extra.end();
  }

  void add_fields(const LasLayout& layout) {
    for (const LasField& field : layout.fields) {
      if (is_taken(field.name) || !is_used(field)) continue;
      if (field.is_packed()) {
        add_bits(field);
      } else if (field.is_angle()) {
        add_angle(field);
      } else {
        add_stored(field.name, field.type, 1, field.offset);
      }
    }
    if (layout.gps_time && !is_taken("gps_time") && is_used(*layout.gps_time, sizeof(double))) {
      add_stored("gps_time", ScalarType::kFloat64, 1, *layout.gps_time);
    }
    if (layout.infrared && !is_taken("infrared") && is_used(*layout.infrared, 2)) {
      add_stored("infrared", ScalarType::kUint16, 1, *layout.infrared);
    }
  }

  void add_bits(const LasField& field) {
    auto* const out = own<std::uint8_t>(header_.points);
    check_.for_each(0, header_.points, [&](std::size_t i) {
      out[i] = static_cast<std::uint8_t>(field.value_in(body_ + i * header_.record_bytes));
    });
    add({field.name, ScalarType::kUint8}, column_of(out, 1, ScalarType::kUint8));
  }

  /// Angles are in degrees, whatever their unit in the file is.
  void add_angle(const LasField& field) {
    auto* const out = own<float>(header_.points);
    const Column stored{body_ + field.offset, header_.record_bytes, field.type};
    for_each_value(stored, header_.points, check_, [=, factor = field.factor](std::size_t i, auto value) {
      out[i] = static_cast<float>(static_cast<double>(value) * factor);
    });
    add({field.name, ScalarType::kFloat32}, column_of(out, 1, ScalarType::kFloat32));
  }

  const std::byte* body_;
  const LasHeader& header_;
  StopCheck& check_;
  PointTable table_;
  std::vector<Column> columns_;
  std::vector<std::unique_ptr<std::byte[]>> owned_;
};

void warn_of_what_is_not_kept(const LasHeader& header, std::vector<Warning>& warnings) {
  const auto warn = [&warnings](std::string_view message) {
    warnings.push_back({WarningReason::kAttributeNotKept, fmt::format("{}", message)});
  };
  const LasLayout layout = las_layout(header.point_format);
  if (layout.has_waveform) warn("the waveforms of the points are not kept");
  std::size_t described = layout.bytes;
  for (const LasExtra& extra : header.extra) described = extra.offset + extra.count * size_of(extra.type);
  if (described < header.record_bytes) {
    warn(fmt::format("the last {} bytes of each point are not kept, because the file does not describe them",
                     header.record_bytes - described));
  }
}

}  // namespace

absl::StatusOr<LabeledCloud> decode_las(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                        const ReadOptions& options, const StopToken& stop) {
  RETURN_IF_ERROR(check_bytes("LAS file: ", bytes.size(), limits));
  StopCheck check(stop);
  ASSIGN_OR_RETURN(LasHeader header, parse_las_header(bytes, limits, check));
  LabeledCloud out;
  out.warnings = std::move(header.warnings);
  out.has_standard_gps_time = header.has_standard_gps_time;
  if (options.keep_everything) out.reference_records = header.reference_records.copies();
  warn_of_what_is_not_kept(header, out.warnings);
  const LasTable points(bytes, header, options.keep_everything, check);
  RETURN_IF_ERROR(check.status());
  PointTable table = points.table();
  if (header.reference_system && !options.unit && !header.stated.unit) {
    RETURN_IF_ERROR(use_reference_system(*header.reference_system, check, table, out.warnings));
  }
  RETURN_IF_ERROR(read_points(table, {}, options, stop, out));
  return out;
}

}  // namespace segserve::codec
