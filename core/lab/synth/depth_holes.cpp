// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/depth_holes.hpp"

#include <algorithm>
#include <cmath>

#include "core/lab/synth/value_noise.hpp"

namespace segserve::synth {
namespace {

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

}  // namespace

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

void cut_grazing(DepthImage& image, std::uint64_t seed) {
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u) {
      const std::size_t i = std::size_t{v} * image.width + u;
      const double lost = (0.24 - image.incidence[i]) / 0.2;
      if (lost > 0 && value_noise(u / 3.0, v / 3.0, seed) < lost) image.depth[i] = 0;
    }
  }
}

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

}  // namespace segserve::synth
