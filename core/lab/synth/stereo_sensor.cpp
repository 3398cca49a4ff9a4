// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/stereo_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/lab/synth/depth_holes.hpp"
#include "core/lab/synth/noise_field.hpp"
#include "core/lab/synth/silhouette.hpp"
#include "core/lab/synth/value_noise.hpp"

namespace segserve::synth {
namespace {

constexpr std::int64_t kWindow = 3;       // pixels on each side of the pixel whose window is compared, at 640 columns
constexpr double kStereoFocal = 525;      // pixels; the noise is that of 640 columns, whatever the size of the image
constexpr double kDisparityError = 0.06;  // pixels, where there is texture enough
constexpr double kEnoughTexture = 0.03;   // standard deviation of brightness in a window, of 0 to 1
constexpr double kStepsPerPixel = 32;     // of disparity

/// Lengths in pixels grow with the image.
double pixel_scale(const DepthImage& image) { return std::max(1.0, image.width / 640.0); }

/// The standard deviation of brightness in the window around each pixel.
std::vector<float> contrast_of(const std::vector<Vec3>& color, std::int64_t width, std::int64_t height) {
  const auto brightness = [&](std::size_t i) { return (color[i].x + color[i].y + color[i].z) / 3; };
  // Sums over all pixels above and to the left give the sum over any window.
  const std::int64_t stride = width + 1;
  std::vector<double> sum(static_cast<std::size_t>(stride * (height + 1))), squares(sum.size());
  for (std::int64_t v = 0; v < height; ++v) {
    for (std::int64_t u = 0; u < width; ++u) {
      const double b = brightness(static_cast<std::size_t>(v * width + u));
      const auto i = static_cast<std::size_t>((v + 1) * stride + u + 1), up = i - static_cast<std::size_t>(stride);
      sum[i] = b + sum[i - 1] + sum[up] - sum[up - 1];
      squares[i] = b * b + squares[i - 1] + squares[up] - squares[up - 1];
    }
  }
  std::vector<float> contrast(color.size());
  for (std::int64_t v = 0, i = 0; v < height; ++v) {
    const std::int64_t top = std::max<std::int64_t>(0, v - kWindow), bottom = std::min(height, v + kWindow + 1);
    for (std::int64_t u = 0; u < width; ++u, ++i) {
      const std::int64_t left = std::max<std::int64_t>(0, u - kWindow), right = std::min(width, u + kWindow + 1);
      const auto over_window = [&](const std::vector<double>& s) {
        const auto at = [&](std::int64_t row, std::int64_t column) {
          return s[static_cast<std::size_t>(row * stride + column)];
        };
        return (at(bottom, right) - at(top, right) - at(bottom, left) + at(top, left)) /
               static_cast<double>((bottom - top) * (right - left));
      };
      const double mean = over_window(sum);
      contrast[static_cast<std::size_t>(i)] =
          static_cast<float>(std::sqrt(std::max(0.0, over_window(squares) - mean * mean)));
    }
  }
  return contrast;
}

/// How well windows can be compared: 1 with texture enough, 0 without any.
std::vector<float> matchability(const std::vector<Vec3>& color, const DepthImage& image, bool projector) {
  std::vector<float> result = contrast_of(color, image.width, image.height);
  for (std::size_t i = 0; i < result.size(); ++i) {
    constexpr double kPatternReach = 2.5;  // meters
    const double z = std::max(kPatternReach, image.depth[i]);
    const double pattern = projector ? kEnoughTexture * kPatternReach / z : 0;
    const double texture = std::sqrt(result[i] * result[i] + pattern * pattern);
    result[i] = static_cast<float>(std::min(1.0, texture / kEnoughTexture));
  }
  return result;
}

/// A window that holds a part of an object in front is matched to that object, so that objects grow.
void fatten_edges(DepthImage& image, double focal, double noise, std::uint64_t seed) {
  const DepthImage before = image;
  const auto w = static_cast<std::int64_t>(image.width), h = static_cast<std::int64_t>(image.height);
  const double scale = pixel_scale(image);
  const auto reach = static_cast<std::int64_t>(kWindow * scale);
  for (std::int64_t v = reach; v + reach < h; ++v) {
    for (std::int64_t u = reach; u + reach < w; ++u) {
      const auto i = static_cast<std::size_t>(v * w + u);
      const double grown = reach * std::min(1.0, noise) * (0.2 + value_noise(u / (4 * scale), v / (4 * scale), seed));
      const std::int64_t most = std::min<std::int64_t>(reach, std::llround(grown));
      std::int64_t best = most * most + 1;
      for (std::int64_t dv = -most; dv <= most; ++dv) {
        for (std::int64_t du = -most; du <= most; ++du) {
          const std::int64_t square = du * du + dv * dv;
          const auto j = static_cast<std::size_t>((v + dv) * w + u + du);
          if (square >= best || before.depth[j] >= before.depth[i]) continue;
          if (!is_silhouette(before, j, i, focal, std::sqrt(static_cast<double>(square)))) continue;
          best = square;
          image.depth[i] = before.depth[j];
          image.incidence[i] = before.incidence[j];
          image.label[i] = before.label[j];
        }
      }
    }
  }
}

void cut_textureless(DepthImage& image, const std::vector<float>& matchable, std::uint64_t seed) {
  const double cell = 14 * pixel_scale(image);
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u) {
      const std::size_t i = std::size_t{v} * image.width + u;
      constexpr double kDoubtful = 0.2;
      const double lost = 0.7 * (kDoubtful - matchable[i]) / kDoubtful;
      if (lost > 0 && value_noise(u / cell, v / cell, seed) < lost) image.depth[i] = 0;
    }
  }
}

void add_disparity_noise(DepthImage& image, const std::vector<float>& matchable, double noise, double baseline,
                         Random& random) {
  constexpr double kBroad = 0.84, kFine = 0.54, kWhite = 0.06, kLeastMatchable = 0.33;
  const double scale = pixel_scale(image);
  const NoiseField broad(image.width, image.height, 16 * scale, random);
  const NoiseField fine(image.width, image.height, 6 * scale, random);
  const double focal_times_baseline = kStereoFocal * baseline;
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u, ++i) {
      const double normal = kBroad * broad.at(u, v) + kFine * fine.at(u, v) + kWhite * random.gaussian();
      double& z = image.depth[i];
      if (z == 0) continue;
      const double error = noise * kDisparityError / std::max(kLeastMatchable, static_cast<double>(matchable[i]));
      const double disparity = focal_times_baseline / z + error * normal;
      const double steps = std::floor(kStepsPerPixel * disparity + 0.5);
      z = kStepsPerPixel * focal_times_baseline / std::max(kStepsPerPixel / 2, steps);
    }
  }
}

}  // namespace

void StereoSensor::measure(const std::vector<Vec3>& color, DepthImage& image, Random& random) const {
  const std::uint64_t seed = random.bits();
  const std::vector<float> matchable = matchability(color, image, projector);
  if (holes) cut_shadow(image, focal * baseline);
  if (noise > 0) {
    fatten_edges(image, focal, noise, seed);
    blend_silhouettes(image, focal, 0.4, random);
  }
  if (holes) {
    cut_grazing(image, seed + 2);
    cut_textureless(image, matchable, seed + 3);
  }
  if (noise > 0) add_disparity_noise(image, matchable, noise, baseline, random);
}

}  // namespace segserve::synth
