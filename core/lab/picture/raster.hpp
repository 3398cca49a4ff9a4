#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "segserve/cloud.hpp"

namespace segserve::picture {

/// For each pixel the point that is seen there, and how far away it is.
struct Raster {
  static constexpr std::uint32_t kNoPoint = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint32_t> point;  ///< index into the cloud, or kNoPoint
  std::vector<float> depth;          ///< metres along the line of sight; 0 without a point

  Raster(std::uint32_t w, std::uint32_t h)
      : width(w), height(h), point(std::size_t{w} * h, kNoPoint), depth(std::size_t{w} * h) {}
};

/// An organised cloud as the image that it is; depth is z for CAMERA, else the distance to the sensor
/// (without one: 1).
Raster rasterize_organised(const CloudView& cloud);

/// Any cloud, projected with a z-buffer as render() tells.
Raster project(const CloudView& cloud, std::uint32_t width, std::uint32_t height);

}  // namespace segserve::picture
