// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "segserve/codec/labeled_cloud.hpp"

namespace segserve::codec {

/// How the coordinates of one axis become integers: coordinate = scale * integer + offset.
struct LasAxis {
  double scale = 1, offset = 0;
  double low = 0, high = 0;  ///< of the coordinates

  std::int32_t to_integer(double coordinate) const {
    return static_cast<std::int32_t>(std::llround((coordinate - offset) / scale));
  }
};

/// The coordinate of a point along an axis, as the file has it.
inline double coordinate(const FileContent& content, std::size_t axis, std::size_t point) {
  if (content.position != nullptr) return (*content.position)[axis][point];
  const CloudView& cloud = content.cloud;
  return axis == 0 ? cloud.x[point] : axis == 1 ? cloud.y[point] : cloud.z[point];
}

/// Chooses scale and offset for the points, all of which are finite, see encode_las. INVALID_ARGUMENT if the
/// coordinates reach too far.
absl::StatusOr<LasAxis> choose_axis(const FileContent& content, std::size_t axis,
                                    const std::vector<std::uint32_t>& points);

}  // namespace segserve::codec
