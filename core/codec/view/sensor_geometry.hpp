// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/base/stop_check.hpp"
#include "segserve/cloud.hpp"

// Properties of a cloud's points that hint at the sensor that saw them, if it is at the origin. Points that are not
// finite, and those at the origin, are ignored. Once the StopCheck has stopped, results mean nothing.
namespace segserve::codec {

/// How many points lie before and behind the plane z = 0, and the box that holds them.
struct Extent {
  std::size_t points = 0, in_front = 0, behind = 0;
  std::size_t wide = 0;   ///< points more than 52 degrees aside of the z axis, as few cameras see
  std::size_t zeros = 0;  ///< points at the origin, which do not count in the others
  float low[3] = {}, high[3] = {};

  /// Whether (nearly) all points are in front, or behind: one in a hundred may be a fault of the sensor.
  bool is_in_front() const { return points > 0 && points - in_front <= points / 100; }
  /// Whether (nearly) all points can be within what a camera sees that looks along z.
  bool is_in_frustum() const { return is_in_front() && wide <= points / 100; }
  bool is_behind() const { return points > 0 && points - behind <= points / 100; }
};
Extent extent_of(const CloudView& cloud, StopCheck& check);

/// Returns the same as extent_of(cloud).is_behind(), but mostly after a look at a few points.
bool is_behind_origin(const CloudView& cloud, StopCheck& check);

enum class Agreement { kNo, kYes, kUnknown };

/// Whether an organized cloud can come from a camera: x/z hardly changes along the columns, and y/z along the rows, or
/// the other way around. Clouds of a few points cannot tell.
Agreement follows_pixels(const CloudView& cloud, StopCheck& check);

/// Whether an organized cloud can come from a spinning LiDAR: along each row, or along each column, the elevation from
/// the origin hardly changes.
bool follows_rings(const CloudView& cloud, StopCheck& check);

/// Whether the points of an unorganized cloud have the few, equidistant values of x/z and of y/z that the pixels of a
/// camera have.
bool has_pixel_values(const CloudView& cloud, const Extent& extent, StopCheck& check);

/// Whether the points of an unorganized cloud have the few elevations that the rings of a spinning LiDAR have. Both
/// judge by a sample of the points that does not depend on their order.
bool has_ring_values(const CloudView& cloud, StopCheck& check);

/// Whether a fifth of the points lie within a fiftieth of their range of z, as those of a floor or table do.
bool has_horizontal_plane(const CloudView& cloud, const Extent& extent, StopCheck& check);

}  // namespace segserve::codec
