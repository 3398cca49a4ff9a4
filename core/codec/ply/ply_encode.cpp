// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <vector>

#include "core/codec/common/file_columns.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/common/text_parsing.hpp"
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

/// Whether a double that was made of an integer is that integer.
template <typename T>
bool is_same(double made, T integer) {
  return made < std::ldexp(1.0, std::numeric_limits<T>::digits) && static_cast<T>(made) == integer;
}

/// The attribute with doubles instead of its integers of type T, which has 64 bits. Warns of values that change.
template <typename T>
Attribute with_doubles(const Attribute& attribute, std::vector<Warning>& warnings) {
  Attribute doubles{attribute.name, ScalarType::kFloat64, attribute.count, {}};
  doubles.values.resize(attribute.values.size());
  std::size_t changed = 0;
  for (std::size_t at = 0; at < attribute.values.size(); at += sizeof(double)) {
    const T integer = load<T>(attribute.values.data() + at);
    const auto value = static_cast<double>(integer);
    changed += is_same(value, integer) ? 0 : 1;
    std::memcpy(doubles.values.data() + at, &value, sizeof value);
  }
  if (changed > 0) {
    warnings.push_back({WarningReason::kAttributeNotKept,
                        fmt::format("{} of {} values of {} are rounded, because PLY has no integers of 64 bits; PCD, "
                                    "LAS, NPY and text keep them",
                                    changed, attribute.values.size() / sizeof(T), quoted(attribute.name))});
  }
  return doubles;
}

/// Attributes of the types that PLY has.
std::vector<Attribute> ply_attributes(std::span<const Attribute> attributes, std::vector<Warning>& warnings) {
  std::vector<Attribute> all;
  for (const Attribute& attribute : attributes) {
    if (attribute.type == ScalarType::kInt64) {
      all.push_back(with_doubles<std::int64_t>(attribute, warnings));
    } else if (attribute.type == ScalarType::kUint64) {
      all.push_back(with_doubles<std::uint64_t>(attribute, warnings));
    } else {
      all.push_back(attribute);
    }
  }
  return all;
}

}  // namespace

std::string encode_ply(const FileContent& content, PlyEncoding encoding, std::vector<Warning>* warnings) {
  std::vector<Warning> ignored;
  const auto attributes = ply_attributes(content.attributes, warnings == nullptr ? ignored : *warnings);
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
