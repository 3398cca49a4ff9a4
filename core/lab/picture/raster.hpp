// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "segserve/cloud.hpp"

namespace segserve::picture {

/// For each pixel the point that is seen there, and its distance.
struct Raster {
  static constexpr std::uint32_t kNoPoint = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint32_t> point;  ///< Index into the cloud, or kNoPoint.
  std::vector<float> depth;          ///< Distance from the viewer in meters; 0 without a point.

  Raster(std::uint32_t w, std::uint32_t h)
      : width(w), height(h), point(std::size_t{w} * h, kNoPoint), depth(std::size_t{w} * h) {}
};

/// An organized cloud as the image that it is. The depth is z for CAMERA, else the distance to the sensor, or 1 if
/// there is no sensor.
Raster rasterize_organized(const CloudView& cloud);

/// Any cloud, projected with a z-buffer as described at render().
Raster rasterize_projected(const CloudView& cloud, std::uint32_t width, std::uint32_t height,
                           const std::optional<Eigen::Vector3f>& view_from);

/// Closes small holes in surfaces: a pixel that shows nothing, or what lies behind, takes the point of the surface that
/// surrounds it. The outlines of surfaces stay where they are.
void close_holes(Raster& raster);

}  // namespace segserve::picture
