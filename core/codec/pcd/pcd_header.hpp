// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/pcd.hpp"

namespace segserve::codec {

struct PcdField {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::size_t count = 1;

  std::size_t bytes() const { return size_of(type) * count; }
  /// Padding, which binary_compressed leaves out.
  bool is_padding() const { return name == "_"; }
};

/// What a PCD header says, checked for itself and against the limits; not yet against the body.
struct PcdHeader {
  std::vector<PcdField> fields;
  Roles roles;  ///< indices into `fields`
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::size_t points = 0;            ///< width * height
  std::array<float, 3> viewpoint{};  ///< translation, meters
  bool identity_viewpoint = true;    ///< neither translation nor rotation
  PcdEncoding encoding = PcdEncoding::kAscii;
  std::size_t body_offset = 0;  ///< bytes from the begin of the file
  std::size_t body_line = 1;    ///< number of the body's first line

  /// Bytes of one point in a binary body; no overflow, by the check against the limits.
  std::size_t point_bytes() const;
};

/// INVALID_ARGUMENT with the line and the fault.
absl::StatusOr<PcdHeader> parse_pcd_header(std::string_view file, const DecodeLimits& limits);

}  // namespace segserve::codec
