// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "segserve/codec/attribute.hpp"

// The records of points in LAS files ("LAS Specification 1.4 - R15", American Society for Photogrammetry and Remote
// Sensing, tables 7 to 17).
namespace segserve::codec {

/// A value that a LAS record has beside the coordinates and the color. Values that share a byte with others are
/// `bits` wide, and begin at bit `shift`.
struct LasField {
  std::string_view name;
  ScalarType type = ScalarType::kUint8;
  std::size_t offset = 0;  ///< in the record
  unsigned shift = 0;
  unsigned bits = 0;  ///< 0: the value has bytes of its own
  double factor = 1;  ///< the value in degrees is this times the stored integer; 1 for all other values

  bool is_packed() const { return bits != 0; }
  /// A packed value of a record.
  unsigned value_in(const std::byte* record) const {
    return (static_cast<unsigned>(record[offset]) >> shift) & ((1U << bits) - 1);
  }
  bool is_angle() const { return factor != 1 || name == "scan_angle"; }
};

/// The layout of one of the point formats 0 to 10.
struct LasLayout {
  std::size_t bytes = 0;  ///< of a record without extra bytes
  std::span<const LasField> fields;
  std::optional<std::size_t> color;     ///< offset of red, green and blue, 16 bits each
  std::optional<std::size_t> gps_time;  ///< offset of a double
  std::optional<std::size_t> infrared;  ///< offset of 16 bits
  bool has_waveform = false;            ///< the record ends with a wave packet of 29 bytes
};

inline constexpr unsigned kMostLasFormat = 10;

/// `format` must be 0 to kMostLasFormat.
LasLayout las_layout(unsigned format);

}  // namespace segserve::codec
