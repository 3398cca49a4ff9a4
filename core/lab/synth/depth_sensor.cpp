// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/depth_sensor.hpp"

#include <algorithm>
#include <cmath>

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

/// Finds the pixels that the camera sees and the projector does not: each row is resampled at the columns of the
/// projector, where the largest disparity wins.
class ProjectorShadow {
 public:
  ProjectorShadow(const DepthImage& image, double focal_times_baseline)
      : image_(image), scale_(focal_times_baseline), nearest_(2 * std::size_t{image.width} + 2) {}

  void start_row(std::size_t first) {
    first_ = first;
    std::fill(nearest_.begin(), nearest_.end(), 0.0);
    std::size_t previous = column(0);
    for (std::uint32_t u = 0; u < image_.width; ++u) {
      const double d = disparity(u);
      const std::size_t k = column(u);
      const bool connected = u > 0 && std::abs(d - disparity(u - 1)) < 1.5;
      const std::size_t low = connected ? std::min(previous, k) : k;
      const std::size_t high = connected ? std::max(previous, k) : k;
      for (std::size_t j = low; j <= high; ++j) nearest_[j] = std::max(nearest_[j], d);
      previous = k;
    }
  }
  bool covers(std::uint32_t u) const { return nearest_[column(u)] > disparity(u) + 2.0; }

 private:
  double disparity(std::uint32_t u) const {
    const double z = image_.depth[first_ + u];
    return z > 0 ? std::min(scale_ / z, static_cast<double>(image_.width)) : 0;
  }
  std::size_t column(std::uint32_t u) const { return static_cast<std::size_t>(u + image_.width + 0.5 - disparity(u)); }

  const DepthImage& image_;
  double scale_;
  std::vector<double> nearest_;
  std::size_t first_ = 0;
};

void cut_shadow(DepthImage& image, double focal_times_baseline) {
  ProjectorShadow shadow(image, focal_times_baseline);
  std::vector<bool> hidden(image.width);
  for (std::uint32_t v = 0; v < image.height; ++v) {
    const std::size_t first = std::size_t{v} * image.width;
    shadow.start_row(first);
    for (std::uint32_t u = 0; u < image.width; ++u) hidden[u] = shadow.covers(u);
    for (std::uint32_t u = 0; u < image.width; ++u) {
      if (hidden[u]) image.depth[first + u] = 0;
    }
  }
}

/// The pattern is lost on surfaces that the rays only graze, in patches rather than single pixels.
void cut_grazing(DepthImage& image, std::uint64_t seed) {
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u) {
      const std::size_t i = std::size_t{v} * image.width + u;
      const double lost = (0.24 - image.incidence[i]) / 0.2;
      if (lost > 0 && value_noise(u / 3.0, v / 3.0, seed) < lost) image.depth[i] = 0;
    }
  }
}

/// Adds a few spots without depth, like those of glints and dark dots, at random places.
void cut_spots(DepthImage& image, Random& random) {
  const std::uint32_t count = 1 + random.below(4);
  for (std::uint32_t spot = 0; spot < count; ++spot) {
    const double scale = image.width / 640.0;
    const double cu = random.uniform(0, image.width), cv = random.uniform(0, image.height);
    const double ru = scale * random.uniform(1.5, 6), rv = scale * random.uniform(1.5, 5);
    const auto low = [](double x) { return static_cast<std::uint32_t>(std::max(0.0, std::floor(x))); };
    for (std::uint32_t v = low(cv - rv); v < std::min<double>(image.height, cv + rv); ++v) {
      for (std::uint32_t u = low(cu - ru); u < std::min<double>(image.width, cu + ru); ++u) {
        const double du = (u - cu) / ru, dv = (v - cv) / rv;
        if (du * du + dv * dv < 1) image.depth[std::size_t{v} * image.width + u] = 0;
      }
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
