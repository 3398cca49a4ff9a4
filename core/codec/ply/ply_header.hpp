// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

/// The formats that can be read.
enum class PlyFormat : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

/// A property of an element: a number, or a list of numbers.
struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::kFloat32;  ///< type of the number, or of the numbers of the list
  std::optional<ScalarType> length_type;   ///< the integer type of a list's length; unset for a number
};

/// An element: a table with a row for each vertex, face or other thing.
struct PlyElement {
  std::string name;
  std::uint64_t rows = 0;
  std::vector<PlyProperty> properties;

  /// The fewest bytes that a row takes in a binary body, which are those of a row whose lists are empty.
  std::size_t least_row_bytes() const;
};

/// The content of a PLY header. It agrees with itself and with the limits, but has not been compared with the body.
struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  std::size_t vertex = 0;  ///< index of the element `vertex`, or `point` if there is none
  FieldRoles roles;        ///< indices into the properties of `vertex`
  FileStatements stated;
  bool has_texture = false;  ///< a comment names an image of texture, as MeshLab writes it
  std::vector<Warning> warnings;
  std::size_t body_offset = 0;  ///< bytes from the beginning of the file
  std::size_t body_line = 1;    ///< number of the body's first line, counted from 1
};

/// The properties of an element as find_field_roles has them. They refer to the names in the element.
std::vector<Field> fields_of(const PlyElement& element);

/// Parses the header at the beginning of a PLY file. INVALID_ARGUMENT that names the line and the fault, or the
/// exceeded limit. Headers beyond header_limits.hpp are refused.
absl::StatusOr<PlyHeader> parse_ply_header(std::string_view file, const DecodeLimits& limits);

}  // namespace segserve::codec
