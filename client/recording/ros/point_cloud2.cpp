// SPDX-License-Identifier: Apache-2.0
#include "client/recording/ros/point_cloud2.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "core/base/status_macros.hpp"

namespace segserve::recording {
namespace {

constexpr std::uint32_t kMaxFields = 4096;
constexpr std::size_t kLeastFieldBytes = 4 + 4 + 1 + 4;  // an empty name, offset, datatype and count
constexpr std::size_t kLabelBytes = 4;
constexpr std::string_view kInputLabel = "input_label";  // of labels that were there, as in files
constexpr std::uint32_t kLargest = std::numeric_limits<std::uint32_t>::max();

void write_label(char* to, std::uint32_t label, bool is_bigendian) {
  std::memcpy(to, &label, kLabelBytes);
  if (is_bigendian) std::reverse(to, to + kLabelBytes);
}

/// Writes the labels into a field that is there.
LabeledPoints overwrite_labels(const codec::StridedLayout& layout, std::string_view data, std::uint32_t offset,
                               std::span<const std::uint32_t> labels) {
  LabeledPoints out{layout, std::string(data)};
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::size_t row = i / layout.width;
    const std::size_t at = row * layout.row_step + (i % layout.width) * layout.point_step;
    write_label(out.data.data() + at + offset, labels[i], layout.is_bigendian);
  }
  return out;
}

bool has_field(const codec::StridedLayout& layout, std::string_view name) {
  return std::ranges::find(layout.fields, name, &codec::PointField::name) != layout.fields.end();
}

absl::StatusOr<codec::StridedLayout> with_label(const codec::StridedLayout& layout) {
  codec::StridedLayout out = layout;
  const std::string_view new_name = has_field(layout, kInputLabel) ? "label_before" : kInputLabel;
  for (codec::PointField& field : out.fields) {
    if (field.name == "label") field.name = new_name;
  }
  const std::uint64_t offset = (std::uint64_t{layout.point_step} + kLabelBytes - 1) / kLabelBytes * kLabelBytes;
  const std::uint64_t step = offset + kLabelBytes;
  if (step > kLargest || step * std::max(1U, layout.width) > kLargest) {
    return absl::InvalidArgumentError(
        fmt::format("rows of {} points become too large with a label each", layout.width));
  }
  out.fields.push_back({"label", static_cast<std::uint32_t>(offset), codec::PointDatatype::kUint32, 1});
  out.point_step = static_cast<std::uint32_t>(step);
  out.row_step = out.point_step * out.width;
  if (out.bytes() > kLargest) return absl::InvalidArgumentError("the cloud becomes too large with a label each point");
  return out;
}

}  // namespace

absl::StatusOr<PointCloud2> parse_point_cloud2(std::string_view bytes, RosWire wire) {
  RosReader reader(bytes, wire);
  PointCloud2 cloud;
  cloud.header = read_header(reader);
  cloud.layout.height = reader.number<std::uint32_t>();
  cloud.layout.width = reader.number<std::uint32_t>();
  const std::uint32_t fields = reader.count(kLeastFieldBytes);
  if (fields > kMaxFields) return absl::InvalidArgumentError(fmt::format("there are {} fields", fields));
  for (std::uint32_t i = 0; i < fields && reader.ok(); ++i) {
    codec::PointField& field = cloud.layout.fields.emplace_back();
    field.name = reader.string();
    field.offset = reader.number<std::uint32_t>();
    field.datatype = static_cast<codec::PointDatatype>(reader.number<std::uint8_t>());
    field.count = reader.number<std::uint32_t>();
  }
  cloud.layout.is_bigendian = reader.number<std::uint8_t>() != 0;
  cloud.layout.point_step = reader.number<std::uint32_t>();
  cloud.layout.row_step = reader.number<std::uint32_t>();
  cloud.data = reader.octets();
  cloud.is_dense = reader.number<std::uint8_t>() != 0;
  if (reader.ok()) return cloud;
  return absl::InvalidArgumentError(fmt::format(
      "the {} bytes of the message are no PointCloud2: they are too few for what they claim", bytes.size()));
}

std::string encode_point_cloud2(const PointCloud2& cloud, RosWire wire) {
  RosWriter writer(wire);
  write_header(cloud.header, wire, writer);
  writer.number(cloud.layout.height);
  writer.number(cloud.layout.width);
  writer.number(static_cast<std::uint32_t>(cloud.layout.fields.size()));
  for (const codec::PointField& field : cloud.layout.fields) {
    writer.string(field.name);
    writer.number(field.offset);
    writer.number(static_cast<std::uint8_t>(field.datatype));
    writer.number(field.count);
  }
  writer.number(static_cast<std::uint8_t>(cloud.layout.is_bigendian));
  writer.number(cloud.layout.point_step);
  writer.number(cloud.layout.row_step);
  writer.octets(cloud.data);
  writer.number(static_cast<std::uint8_t>(cloud.is_dense));
  return writer.take();
}

absl::StatusOr<LabeledPoints> add_labels(const codec::StridedLayout& layout, std::string_view data,
                                         std::span<const std::uint32_t> labels) {
  const auto old = std::ranges::find(layout.fields, "label", &codec::PointField::name);
  const bool is_ours = old != layout.fields.end() && old->datatype == codec::PointDatatype::kUint32 && old->count <= 1;
  if (is_ours && has_field(layout, kInputLabel)) {
    return overwrite_labels(layout, data, old->offset, labels);
  }
  LabeledPoints out;
  ASSIGN_OR_RETURN(out.layout, with_label(layout));
  out.data.resize(static_cast<std::size_t>(out.layout.bytes()));
  const std::uint32_t offset = out.layout.fields.back().offset;
  char* to = out.data.data();
  for (std::size_t i = 0; i < labels.size(); ++i, to += out.layout.point_step) {
    const std::size_t row = i / layout.width;
    const char* from = data.data() + row * layout.row_step + (i % layout.width) * layout.point_step;
    std::memcpy(to, from, layout.point_step);
    write_label(to + offset, labels[i], layout.is_bigendian);
  }
  return out;
}

}  // namespace segserve::recording
