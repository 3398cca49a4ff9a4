// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/color_sensor.hpp"

#include <algorithm>

#include "core/lab/synth/packed_color.hpp"

namespace segserve::synth {
namespace {

/// The filter (1 2 1) / 4 along a line of pixels.
Vec3 smoothed(const Vec3& before, const Vec3& here, const Vec3& after) { return 0.25 * (before + after) + 0.5 * here; }

std::vector<Vec3> blurred(std::uint32_t width, std::uint32_t height, const std::vector<Vec3>& color) {
  std::vector<Vec3> rows(color.size());
  for (std::uint32_t v = 0; v < height; ++v) {
    const Vec3* row = color.data() + std::size_t{v} * width;
    for (std::uint32_t u = 0; u < width; ++u) {
      rows[std::size_t{v} * width + u] = smoothed(row[u > 0 ? u - 1 : 0], row[u], row[std::min(u + 1, width - 1)]);
    }
  }
  std::vector<Vec3> result(color.size());
  for (std::uint32_t v = 0; v < height; ++v) {
    const Vec3* row = rows.data() + std::size_t{v} * width;
    const Vec3* above = v > 0 ? row - width : row;
    const Vec3* below = v + 1 < height ? row + width : row;
    for (std::uint32_t u = 0; u < width; ++u) {
      result[std::size_t{v} * width + u] = smoothed(above[u], row[u], below[u]);
    }
  }
  return result;
}

}  // namespace

std::vector<std::uint32_t> ColorSensor::record(std::uint32_t width, std::uint32_t height,
                                               const std::vector<Vec3>& color, Random& random) const {
  const std::vector<Vec3> picture = noise > 0 ? blurred(width, height, color) : color;
  const double grain = 0.008 * noise;
  std::vector<std::uint32_t> rgb(color.size());
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < height; ++v) {
    const double down = 2.0 * v / height - 1;
    for (std::uint32_t u = 0; u < width; ++u, ++i) {
      const double across = 2.0 * u / width - 1;
      const double corner = noise > 0 ? 1 - 0.06 * (across * across + down * down) : 1;
      const Vec3& c = picture[i];
      // Demosaicing leaves noise that is mostly common to the channels.
      const double common = random.gaussian();
      const double r = random.gaussian(), g = random.gaussian(), b = random.gaussian();
      const Vec3 value{corner * c.x + grain * (common + 0.6 * r), corner * c.y + grain * (common + 0.6 * g),
                       corner * c.z + grain * (common + 0.6 * b)};
      rgb[i] = packed_color(value);
    }
  }
  return rgb;
}

}  // namespace segserve::synth
