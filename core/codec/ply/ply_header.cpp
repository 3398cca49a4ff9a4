// SPDX-License-Identifier: Apache-2.0
#include "core/codec/ply/ply_header.hpp"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "core/codec/common/text_parsing.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::codec {
namespace {

using Words = std::vector<std::string_view>;

template <typename... Args>
absl::Status fault(fmt::format_string<Args...> format, Args&&... args) {
  return absl::InvalidArgumentError("PLY header: " + fmt::format(format, std::forward<Args>(args)...));
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
    return fault("format in line {} is {}; known are ascii, binary_little_endian and binary_big_endian", line,
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
  LineReader lines(file);
  lines.next();  // the magic word
  bool has_format = false;
  while (const auto line = lines.next()) {
    const Words words = split_words(line->text);
    if (words.empty()) continue;
    if (!line->terminated) break;
    if (words[0] == "end_header") {
      header.body_offset = lines.offset();
      header.body_line = line->number + 1;
      return has_format ? absl::OkStatus() : fault("it has no line 'format'");
    }
    if (words[0] == "format" && has_format) return fault("'format' is there twice, again in line {}", line->number);
    has_format = has_format || words[0] == "format";
    if (auto status = read_line(words, line->number, header); !status.ok()) return status;
  }
  return fault("it ends without a line 'end_header'");
}

/// Colors are 0 to 255; a float might mean 0 to 1 as well, and nothing in the file tells.
absl::Status check_roles(const PlyElement& vertex, const Roles& roles) {
  for (const std::size_t i : roles.fields()) {
    if (vertex.properties[i].length_type) return fault("property '{}' must not be a list", vertex.properties[i].name);
  }
  for (const std::size_t i : roles.position) {
    const PlyProperty& property = vertex.properties[i];
    if (!is_float(property.type)) return fault("property '{}' must be a float or double", property.name);
  }
  if (!roles.channels) return absl::OkStatus();
  for (const std::size_t i : *roles.channels) {
    const PlyProperty& property = vertex.properties[i];
    if (is_float(property.type)) return fault("property '{}' must be an integer, 0 to 255", property.name);
  }
  return absl::OkStatus();
}

absl::Status assign_roles(PlyHeader& header) {
  const PlyElement& vertex = header.elements[header.vertex];
  Words names;
  for (const PlyProperty& property : vertex.properties) names.emplace_back(property.name);
  const auto in_vertex = [](const absl::Status& s) { return fault("property {}", std::string(s.message())); };
  const auto position = find_three(names, {"x", "y", "z"});
  if (!position.ok()) return in_vertex(position.status());
  if (!*position) return fault("element 'vertex' must have the properties x, y and z");
  header.roles.position = **position;
  for (const std::array<std::string_view, 3>& wanted :
       {std::array<std::string_view, 3>{"red", "green", "blue"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}}) {
    const auto channels = find_three(names, wanted);
    if (!channels.ok()) return in_vertex(channels.status());
    if (!header.roles.channels) header.roles.channels = *channels;
  }
  for (const std::string_view wanted : {"label", "scalar_Label"}) {
    const auto label = find_unique(names, wanted);
    if (!label.ok()) return in_vertex(label.status());
    if (!header.roles.label) header.roles.label = *label;
  }
  return check_roles(vertex, header.roles);
}

absl::Status find_vertex(const DecodeLimits& limits, PlyHeader& header) {
  Words names;
  for (const PlyElement& element : header.elements) names.emplace_back(element.name);
  const auto vertex = find_unique(names, "vertex");
  if (!vertex.ok()) return fault("element {}", std::string(vertex.status().message()));
  if (!*vertex) return fault("it has no element 'vertex'");
  header.vertex = **vertex;
  const std::uint64_t points = header.elements[header.vertex].rows;
  if (points > limits.max_points) {
    return over_limit(
        fmt::format("PLY header: element vertex {} exceeds the limit of {} points", points, limits.max_points),
        {"max_points", points, limits.max_points});
  }
  if (points > std::numeric_limits<std::uint32_t>::max()) {  // the width of the cloud
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

bool is_ply(std::string_view file) { return file.starts_with("ply\n") || file.starts_with("ply\r\n"); }

absl::StatusOr<PlyHeader> parse_ply_header(std::string_view file, const DecodeLimits& limits) {
  if (!is_ply(file)) return absl::InvalidArgumentError("not a PLY file: its first line is not 'ply'");
  PlyHeader header;
  if (auto status = split_header(file, header); !status.ok()) return status;
  if (auto status = find_vertex(limits, header); !status.ok()) return status;
  if (auto status = assign_roles(header); !status.ok()) return status;
  return header;
}

}  // namespace segserve::codec
