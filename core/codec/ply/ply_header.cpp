// SPDX-License-Identifier: Apache-2.0
#include "core/codec/ply/ply_header.hpp"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "core/base/status_macros.hpp"
#include "core/base/status_text.hpp"
#include "core/codec/common/header_limits.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::codec {
namespace {

using Words = std::vector<std::string_view>;

constexpr std::string_view kPrefix = "PLY header: ";

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError(std::string(kPrefix) + fmt::format(format, std::forward<Args>(args)...));
}

std::optional<ScalarType> scalar_type(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, ScalarType>, 18> kTypes{{{"char", ScalarType::kInt8},
                                                                            {"int8", ScalarType::kInt8},
                                                                            {"uchar", ScalarType::kUint8},
                                                                            {"uint8", ScalarType::kUint8},
                                                                            {"short", ScalarType::kInt16},
                                                                            {"int16", ScalarType::kInt16},
                                                                            {"ushort", ScalarType::kUint16},
                                                                            {"uint16", ScalarType::kUint16},
                                                                            {"int", ScalarType::kInt32},
                                                                            {"int32", ScalarType::kInt32},
                                                                            {"uint", ScalarType::kUint32},
                                                                            {"uint32", ScalarType::kUint32},
                                                                            {"int64", ScalarType::kInt64},
                                                                            {"uint64", ScalarType::kUint64},
                                                                            {"float", ScalarType::kFloat32},
                                                                            {"float32", ScalarType::kFloat32},
                                                                            {"double", ScalarType::kFloat64},
                                                                            {"float64", ScalarType::kFloat64}}};
  for (const auto& [known, scalar] : kTypes) {
    if (known == name) return scalar;
  }
  return std::nullopt;
}

absl::Status read_format(const Words& words, std::size_t line, PlyHeader& header) {
  if (words.size() != 3 || words[2] != "1.0") return fault("line {} must be 'format NAME 1.0'", line);
  if (words[1] == "ascii") {
    header.format = PlyFormat::kAscii;
  } else if (words[1] == "binary_little_endian") {
    header.format = PlyFormat::kLittleEndian;
  } else if (words[1] == "binary_big_endian") {
    header.format = PlyFormat::kBigEndian;
  } else {
    return fault("format in line {} is {}; it must be ascii, binary_little_endian or binary_big_endian", line,
                 quoted(words[1]));
  }
  return absl::OkStatus();
}

absl::Status read_element(const Words& words, std::size_t line, PlyHeader& header) {
  const auto rows = words.size() == 3 ? parse_count(words[2]) : std::nullopt;
  if (!rows) return fault("line {} must be 'element NAME COUNT'", line);
  header.elements.push_back({std::string(words[1]), *rows, {}});
  return absl::OkStatus();
}

absl::Status read_property(const Words& words, std::size_t line, PlyHeader& header) {
  const bool is_list = words.size() == 5 && words[1] == "list";
  if (!is_list && words.size() != 3) {
    return fault("line {} must be 'property TYPE NAME' or 'property list TYPE TYPE NAME'", line);
  }
  if (header.elements.empty()) return fault("the property in line {} belongs to no element", line);
  PlyProperty property{std::string(words.back()), {}, {}};
  const std::string_view type_name = words[words.size() - 2];
  const auto type = scalar_type(type_name);
  if (!type) return fault("line {}: {} is not a type of PLY", line, quoted(type_name));
  property.type = *type;
  if (is_list) {
    property.length_type = scalar_type(words[2]);
    if (!property.length_type || is_float(*property.length_type)) {
      return fault("line {}: {} is not an integer type for the length of a list", line, quoted(words[2]));
    }
  }
  header.elements.back().properties.push_back(std::move(property));
  return absl::OkStatus();
}

absl::Status read_line(const Words& words, std::size_t line, PlyHeader& header) {
  if (words[0] == "comment" || words[0] == "obj_info") return absl::OkStatus();
  if (words[0] == "format") return read_format(words, line, header);
  if (words[0] == "element") return read_element(words, line, header);
  if (words[0] == "property") return read_property(words, line, header);
  return fault("line {} begins with {}, which is no entry of a PLY header", line, quoted(words[0]));
}

absl::Status split_header(std::string_view file, PlyHeader& header) {
  LineReader lines(header_part(file));
  lines.next();  // This line is the magic word.
  bool has_format = false;
  std::size_t fields = 0;
  while (const auto line = lines.next()) {
    const Words words = split_words(line->text);
    if (words.empty()) continue;
    if (!line->terminated) break;
    if (words[0] == "end_header") {
      header.body_offset = lines.offset();
      header.body_line = line->number + 1;
      return has_format ? absl::OkStatus() : fault("it has no line 'format'");
    }
    if (words[0] == "format" && has_format) return fault("'format' occurs twice, again in line {}", line->number);
    has_format = has_format || words[0] == "format";
    if ((words[0] == "element" || words[0] == "property") && ++fields > kMostHeaderFields) {
      return fault("line {} is one more than the {} elements and properties that are accepted", line->number,
                   kMostHeaderFields);
    }
    if (words[0] == "comment") {
      header.has_texture = header.has_texture || (words.size() > 1 && words[1] == "TextureFile");
      header.stated.take(line->text.substr(std::min(line->text.size(), line->text.find("comment ") + 8)));
    }
    RETURN_IF_ERROR(read_line(words, line->number, header));
  }
  if (file.size() > kMostHeaderBytes) return fault("no line 'end_header' is in the first {} bytes", kMostHeaderBytes);
  return fault("it ends without a line 'end_header'");
}

absl::Status assign_roles(PlyHeader& header) {
  auto roles = find_field_roles(fields_of(header.elements[header.vertex]), header.warnings);
  if (!roles.ok()) return with_prefix("PLY header: properties of 'vertex'", roles.status());
  header.roles = *std::move(roles);
  const bool is_told = !header.warnings.empty();
  if (header.has_texture && !header.roles.has_color() && !is_told) {
    header.warnings.push_back(
        {WarningReason::kColorNotUsed,
         "the cloud has no color: it is in an image of texture, which is not read; save colors of "
         "vertices"});
  }
  return absl::OkStatus();
}

absl::Status find_vertex(const DecodeLimits& limits, PlyHeader& header) {
  std::vector<std::string> lower_names;
  for (const PlyElement& element : header.elements) lower_names.push_back(lower_case(element.name));
  const Words names(lower_names.begin(), lower_names.end());
  std::optional<std::size_t> found;
  for (const std::string_view wanted : {"vertex", "vertices", "point", "points"}) {
    const auto vertex = find_unique(names, wanted);
    if (!vertex.ok()) return with_prefix("PLY header: elements", vertex.status());
    if (!found) found = *vertex;
  }
  if (!found) return fault("it has no element 'vertex'");
  header.vertex = *found;
  const std::uint64_t points = header.elements[header.vertex].rows;
  RETURN_IF_ERROR(check_points(kPrefix, points, limits));
  if (points > std::numeric_limits<std::uint32_t>::max()) {  // The number becomes the width of the cloud.
    return fault("element vertex {} does not fit into 32 bits", points);
  }
  return absl::OkStatus();
}

}  // namespace

std::size_t PlyElement::least_row_bytes() const {
  std::size_t sum = 0;
  for (const PlyProperty& property : properties) sum += size_of(property.length_type.value_or(property.type));
  return sum;
}

std::vector<Field> fields_of(const PlyElement& element) {
  std::vector<Field> fields;
  for (const PlyProperty& property : element.properties) {
    fields.push_back({property.name, property.type, property.length_type ? 0U : 1U});
  }
  return fields;
}

bool is_ply(std::string_view file) {
  file = without_byte_order_mark(file);
  if (!file.starts_with("ply")) return false;
  const std::size_t end = file.find_first_not_of(" \t", 3);
  return end != std::string_view::npos && (file[end] == '\n' || file[end] == '\r');
}

absl::StatusOr<PlyHeader> parse_ply_header(std::string_view file, const DecodeLimits& limits) {
  if (!is_ply(file)) return absl::InvalidArgumentError("not a PLY file: its first line is not 'ply'");
  PlyHeader header;
  RETURN_IF_ERROR(split_header(file, header));
  RETURN_IF_ERROR(find_vertex(limits, header));
  RETURN_IF_ERROR(assign_roles(header));
  return header;
}

}  // namespace segserve::codec
