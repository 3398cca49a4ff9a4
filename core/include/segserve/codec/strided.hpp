// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/cloud.hpp"
#include "segserve/codec/decode_limits.hpp"
#include "segserve/codec/labeled_cloud.hpp"
#include "segserve/codec/read_options.hpp"
#include "segserve/stop_token.hpp"

// The layout of ROS's sensor_msgs/PointCloud2
// (https://docs.ros.org/en/noetic/api/sensor_msgs/html/msg/PointCloud2.html): points one after the other, each with all
// its fields, possibly with gaps.
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

/// A field that every point has, as in sensor_msgs/PointField.
struct PointField {
  std::string name;
  std::uint32_t offset = 0;  ///< bytes from the start of the point
  PointDatatype datatype = PointDatatype::kFloat32;
  std::uint32_t count = 1;  ///< elements of the field; 0 means 1, as in ROS
};

/// Where the fields of a cloud of width * height points lie. Point (row, column) begins at byte
/// row * row_step + column * point_step.
struct StridedLayout {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<PointField> fields;
  std::uint32_t point_step = 0;  ///< bytes from one point to the next
  std::uint32_t row_step = 0;    ///< bytes from one row to the next, at least width * point_step if there are several
  bool is_bigendian = false;     ///< byte order of all fields

  /// Bytes of all rows. The product of two 32-bit numbers cannot overflow. No row follows a single one, whose row_step
  /// may then be 0.
  std::uint64_t bytes() const {
    return height == 1 ? std::max<std::uint64_t>(row_step, std::uint64_t{width} * point_step)
                       : std::uint64_t{height} * row_step;
  }
};

/// A layout and the layout.bytes() bytes of the cloud.
struct StridedCloud {
  StridedLayout layout;
  std::string data;
};

/// Checks a layout before there is any data. INVALID_ARGUMENT that names the field and the value for a field that ends
/// beyond point_step, rows that overlap, an x, y or z that is missing or more than one number, a name with a meaning
/// that occurs twice, more than 64 fields, or an exceeded limit. Other fields must only lie within the point.
absl::Status check_layout(const StridedLayout& layout, const DecodeLimits& limits);

/// Decodes a cloud from `data`, which must be layout.bytes() long. Coordinates, colors and labels are found by the
/// names and types that decode_pcd knows. The view is that of the options, else what the points make plain, as for
/// decode_ply. INVALID_ARGUMENT as check_layout says, or if the length of `data` is wrong. CANCELLED and
/// DEADLINE_EXCEEDED as `stop` says. Coordinates are not checked, and an empty cloud is no error.
absl::StatusOr<LabeledCloud> decode_strided(const StridedLayout& layout, std::string_view data,
                                            const ReadOptions& options, const DecodeLimits& limits,
                                            const StopToken& stop = {});

/// Copies a cloud into the fields x, y, z and, if it has color, rgb. All are little-endian FLOAT32 without gaps; the
/// bits of rgb are 0x00RRGGBB. The width of the cloud must be below 2^28, so that a row of up to 16 bytes a point fits
/// row_step.
StridedCloud encode_strided(const CloudView& cloud);

}  // namespace segserve::codec
