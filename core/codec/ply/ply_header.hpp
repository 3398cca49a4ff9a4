// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/codec/common/point_columns.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "segserve/codec/decode_limits.hpp"

namespace segserve::codec {

enum class PlyFormat : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

struct PlyProperty {
  std::string name;
  ScalarType type = ScalarType::kFloat32;  ///< of a list: of its entries
  std::optional<ScalarType> length_type;   ///< lists only: an integer
};

struct PlyElement {
  std::string name;
  std::uint64_t rows = 0;
  std::vector<PlyProperty> properties;

  /// The fewest bytes of a row in a binary body: all its lists are empty.
  std::size_t least_row_bytes() const;
};

/// What a PLY header says, checked for itself and against the limits; not yet against the body.
struct PlyHeader {
  PlyFormat format = PlyFormat::kAscii;
  std::vector<PlyElement> elements;
  std::size_t vertex = 0;       ///< index of the element `vertex`
  Roles roles;                  ///< indices into its properties
  std::size_t body_offset = 0;  ///< bytes from the begin of the file
  std::size_t body_line = 1;    ///< number of the body's first line
};

/// INVALID_ARGUMENT with the line and the fault.
absl::StatusOr<PlyHeader> parse_ply_header(std::string_view file, const DecodeLimits& limits);

}  // namespace segserve::codec
