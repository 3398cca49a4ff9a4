// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstring>
#include <iterator>
#include <vector>

#include "core/codec/common/file_columns.hpp"
#include "core/codec/common/file_statements.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::codec {
namespace {

std::string_view type_name(ScalarType type) {
  // PLY has no integers of 64 bits; such columns are made doubles before.
  constexpr std::array<std::string_view, 10> kNames{"char",   "short", "int",    "double", "uchar",
                                                    "ushort", "uint",  "double", "float",  "double"};
  return kNames[static_cast<std::size_t>(type)];
}

std::string encode_header(const FileContent& content, const FileTable& table, PlyEncoding encoding) {
  std::string properties;
  for (const FileColumn& column : table.columns()) {
    for (std::size_t k = 0; k < column.count; ++k) {
      fmt::format_to(std::back_inserter(properties), "property {} {}{}\n", type_name(column.type), column.name,
                     column.count == 1 ? "" : fmt::format("_{}", k));
    }
  }
  return fmt::format("ply\nformat {} 1.0\ncomment written by segserve\ncomment {}\nelement vertex {}\n{}end_header\n",
                     encoding == PlyEncoding::kAscii ? "ascii" : "binary_little_endian",
                     fmt::join(statements_of(content), "\ncomment "), table.points(), properties);
}

/// The attribute with doubles instead of integers of 64 bits.
Attribute with_doubles(const Attribute& attribute) {
  Attribute doubles{attribute.name, ScalarType::kFloat64, attribute.count, {}};
  doubles.values.resize(attribute.values.size());
  for (std::size_t at = 0; at < attribute.values.size(); at += sizeof(double)) {
    const double value = attribute.type == ScalarType::kInt64
                             ? static_cast<double>(load<std::int64_t>(attribute.values.data() + at))
                             : static_cast<double>(load<std::uint64_t>(attribute.values.data() + at));
    std::memcpy(doubles.values.data() + at, &value, sizeof value);
  }
  return doubles;
}

/// Attributes of the types that PLY has.
std::vector<Attribute> ply_attributes(std::span<const Attribute> attributes) {
  std::vector<Attribute> all;
  for (const Attribute& attribute : attributes) {
    const bool is_wide = attribute.type == ScalarType::kInt64 || attribute.type == ScalarType::kUint64;
    all.push_back(is_wide ? with_doubles(attribute) : attribute);
  }
  return all;
}

}  // namespace

std::string encode_ply(const FileContent& content, PlyEncoding encoding) {
  const std::vector<Attribute> attributes = ply_attributes(content.attributes);
  FileContent fitting = content;
  fitting.attributes = attributes;
  const FileTable table(fitting, ColorForm::kChannels);
  std::string out = encode_header(content, table, encoding);
  if (encoding == PlyEncoding::kAscii) {
    table.append_text(out);
  } else {
    table.append_rows(out);
  }
  return out;
}

std::string encode_ply(const CloudView& cloud, std::span<const std::uint32_t> label, PlyEncoding encoding) {
  return encode_ply(FileContent{.cloud = cloud, .label = label}, encoding);
}

}  // namespace segserve::codec
