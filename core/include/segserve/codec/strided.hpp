// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/stop_token.hpp"

namespace segserve::codec {

/// The types of a field, with the numbers of sensor_msgs/PointField.
enum class PointDatatype : std::uint8_t {
  kInt8 = 1,
  kUint8 = 2,
  kInt16 = 3,
  kUint16 = 4,
  kInt32 = 5,
  kUint32 = 6,
  kFloat32 = 7,
  kFloat64 = 8,
};

/// A field of every point, as in sensor_msgs/PointField.
struct PointField {
  std::string name;
  std::uint32_t offset = 0;  ///< bytes from the start of the point
  PointDatatype datatype = PointDatatype::kFloat32;
  std::uint32_t count = 1;  ///< elements; 0 counts as 1, as in ROS
};

/// The layout of sensor_msgs/PointCloud2: point (row, column) begins at row * row_step + column * point_step.
struct StridedLayout {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<PointField> fields;
  std::uint32_t point_step = 0;  ///< bytes
  std::uint32_t row_step = 0;    ///< bytes, at least width * point_step
  bool is_bigendian = false;

  /// Cannot overflow.
  std::uint64_t bytes() const { return std::uint64_t{height} * row_step; }
};

/// Bytes in a layout.
struct StridedCloud {
  StridedLayout layout;
  std::string data;
};

/// What of the layout is wrong, or over a limit, before there is any data. INVALID_ARGUMENT that names the field and
/// the value: a field beyond point_step, rows that overlap, x, y or z missing or no float, color of a wrong type, a
/// name that is there twice, more than 64 fields. Fields that mean nothing to us are only checked to be within the
/// point.
absl::Status check_layout(const StridedLayout& layout, const DecodeLimits& limits);

/// The cloud of `data`, which must be layout.bytes() long. Color: `rgb` or `rgba`, whose 4 bytes are 0xAARRGGBB
/// whatever their type, else `r`, `g` and `b`; else none. Neither coordinates nor an empty cloud are judged here.
absl::StatusOr<Cloud> decode_strided(const StridedLayout& layout, std::string_view data, const View& view,
                                     const DecodeLimits& limits, const StopToken& stop = {});

/// x, y, z and, with color, rgb: FLOAT32, without gaps, little endian.
StridedCloud encode_strided(const CloudView& cloud);

}  // namespace segserve::codec
