// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/depth_sensor.hpp"

#include <algorithm>
#include <cmath>

#include "core/lab/synth/depth_holes.hpp"
#include "core/lab/synth/value_noise.hpp"

namespace segserve::synth {
namespace {

constexpr double kEdge = 0.015;  // relative step of depth between neighbors at a silhouette

/// The correlation window of the sensor sees both sides of a silhouette, so that borders fray by about a pixel. This
/// moves depth and label of a neighbor across the border.
void fray_borders(DepthImage& image, double noise, std::uint64_t seed) {
  const auto w = static_cast<std::int64_t>(image.width);
  const auto h = static_cast<std::int64_t>(image.height);
  const std::vector<double> depth = image.depth;
  const std::vector<std::uint32_t> label = image.label;
  const double reach = std::min(noise, 2.0) * 3.0;  // pixels
  for (std::int64_t v = 1; v + 1 < h; ++v) {
    for (std::int64_t u = 1; u + 1 < w; ++u) {
      const std::int64_t i = v * w + u;
      const double z = depth[static_cast<std::size_t>(i)];
      const auto jump = [&](std::int64_t j) { return std::abs(depth[static_cast<std::size_t>(j)] - z) > kEdge * z; };
      if (!jump(i - 1) && !jump(i + 1) && !jump(i - w) && !jump(i + w)) continue;
      const double shift_u = (value_noise(u / 2.5, v / 2.5, seed) - 0.5) * reach;
      const double shift_v = (value_noise(u / 2.5, v / 2.5, seed + 1) - 0.5) * reach;
      const std::int64_t from_u = std::clamp<std::int64_t>(u + std::llround(shift_u), 0, w - 1);
      const std::int64_t from_v = std::clamp<std::int64_t>(v + std::llround(shift_v), 0, h - 1);
      const auto source = static_cast<std::size_t>(from_v * w + from_u);
      if (depth[source] == 0) continue;
      image.depth[static_cast<std::size_t>(i)] = depth[source];
      image.label[static_cast<std::size_t>(i)] = label[source];
    }
  }
}

/// Noise of unit variance that is correlated over a few pixels, because the sensor matches windows of its pattern, not
/// pixels.
class CorrelatedNoise {
 public:
  CorrelatedNoise(std::uint32_t width, std::uint32_t height, Random& random)
      : across_(width / kCell + 2), value_(std::size_t{across_} * (height / kCell + 2)) {
    for (double& value : value_) value = random.gaussian();
  }

  double at(std::uint32_t u, std::uint32_t v) const {
    const double* cell = value_.data() + std::size_t{v / kCell} * across_ + u / kCell;
    const double su = kBlend[u % kCell];
    const double sv = kBlend[v % kCell];
    const double low = cell[0] + (cell[1] - cell[0]) * su;
    const double high = cell[across_] + (cell[across_ + 1] - cell[across_]) * su;
    constexpr double kUnitVariance = 1.354;  // 1 / mean of (s^2 + (1 - s)^2) over kBlend
    return kUnitVariance * (low + (high - low) * sv);
  }

 private:
  static constexpr std::uint32_t kCell = 5;                                 // pixels
  static constexpr double kBlend[kCell] = {0, 0.104, 0.352, 0.648, 0.896};  // smoothstep
  std::uint32_t across_;
  std::vector<double> value_;
};

/// Adds axial noise, then quantizes disparity to eighths of a pixel. The shares of correlated and of white noise were
/// measured on the tables of OSD's scenes (second differences at several lags).
void add_noise(DepthImage& image, double noise, double focal_times_baseline, Random& random) {
  constexpr double kCorrelated = 0.9, kWhite = 0.25;
  constexpr double kStepsPerPixel = 8;
  const CorrelatedNoise field(image.width, image.height, random);
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u, ++i) {
      const double normal = kCorrelated * field.at(u, v) + kWhite * random.gaussian();
      double& z = image.depth[i];
      if (z == 0) continue;
      const double measured = std::max(0.1, z + noise * axial_noise(z) * normal);
      const double steps = std::floor(kStepsPerPixel * focal_times_baseline / measured + 0.5);
      z = kStepsPerPixel * focal_times_baseline / std::max(1.0, steps);
    }
  }
}

}  // namespace

void DepthSensor::measure(DepthImage& image, Random& random) const {
  const std::uint64_t seed = random.bits();
  if (noise > 0) fray_borders(image, noise, seed);
  if (holes) {
    cut_shadow(image, focal * baseline);
    cut_grazing(image, seed + 2);
    cut_spots(image, random);
  }
  // The noise is that of a sensor with 640 columns (focal length 525 pixels), whatever the size of the image.
  if (noise > 0) add_noise(image, noise, 525 * baseline, random);
}

}  // namespace segserve::synth
