// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/codec/common/field_roles.hpp"
#include "core/codec/common/file_statements.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/pcd.hpp"

namespace segserve::codec {

/// A field of every point: its entries in FIELDS, TYPE, SIZE and COUNT.
struct PcdField {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::size_t count = 1;  ///< values of the type, at least 1

  std::size_t bytes() const { return size_of(type) * count; }
  /// Whether the field is padding. PCL leaves it out of a body that is binary_compressed; other programs do not.
  bool is_padding() const { return name == "_"; }
};

/// The content of a PCD header. It agrees with itself and with the limits, but has not been compared with the body.
struct PcdHeader {
  std::vector<PcdField> fields;
  FieldRoles roles;  ///< indices into `fields`
  std::vector<Warning> warnings;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::size_t points = 0;               ///< width * height
  std::optional<SensorPose> viewpoint;  ///< unset if it is missing
  FileStatements stated;
  PcdEncoding encoding = PcdEncoding::kAscii;
  std::size_t body_offset = 0;  ///< bytes from the beginning of the file
  std::size_t body_line = 1;    ///< number of the body's first line, counted from 1

  /// The fields as find_field_roles has them. They refer to the names in this header.
  std::vector<Field> point_fields() const;
  /// Bytes of one point in a body, which has padding or not. The sum cannot overflow, because it is at most
  /// DecodeLimits::max_bytes.
  std::size_t point_bytes(bool with_padding) const;
};

/// Parses the header at the beginning of a PCD file. INVALID_ARGUMENT that names the line and the fault, or the
/// exceeded limit. Headers beyond header_limits.hpp are refused. The VERSION does not matter.
absl::StatusOr<PcdHeader> parse_pcd_header(std::string_view file, const DecodeLimits& limits);

}  // namespace segserve::codec
