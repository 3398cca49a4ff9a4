// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/time_of_flight_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/lab/synth/noise_field.hpp"
#include "core/lab/synth/silhouette.hpp"

namespace segserve::synth {
namespace {

/// The share of the light that each pixel gets back, apart from its distance. Infrared light is reflected by dark
/// colors, too.
std::vector<float> reflected_light(const std::vector<Vec3>& color, const DepthImage& image) {
  std::vector<float> result(color.size());
  for (std::size_t i = 0; i < color.size(); ++i) {
    const double brightness = (color[i].x + color[i].y + color[i].z) / 3;
    result[i] = static_cast<float>(std::max(0.01, (0.12 + 0.88 * brightness * brightness) * image.incidence[i]));
  }
  return result;
}

/// Rounds concave corners.
class CornerRounding {
 public:
  CornerRounding(const DepthImage& image, double focal) : image_(image), focal_(focal) {}

  /// The inverse depth of a pixel beside which surfaces bend toward the camera.
  double inverse_depth(std::size_t i, std::uint32_t u, std::uint32_t v) const {
    const double z = image_.depth[i];
    const auto reach = static_cast<std::size_t>(std::clamp(kReach * focal_ / z, 2.0, 30.0));
    const std::size_t across = std::min({reach, std::size_t{u}, std::size_t{image_.width - 1 - u}});
    const std::size_t down = std::min({reach, std::size_t{v}, std::size_t{image_.height - 1 - v}});
    return 1 / z + kStrength * std::max(concavity(i, 1, across), concavity(i, image_.width, down));
  }

 private:
  static constexpr double kReach = 0.05;  // meters from the corner
  static constexpr double kStrength = 0.5;

  /// How much nearer the surface is on both sides than a plane through the pixel, as a mean over the pixels within
  /// reach. Inverse depth is linear on planes. A silhouette ends the surface.
  double concavity(std::size_t i, std::size_t step, std::size_t reach) const {
    double sum = 0;
    std::size_t r = 1;
    for (; r <= reach && continues(i + r * step, step) && continues(i - (r - 1) * step, step); ++r) {
      sum += 0.5 * (1 / image_.depth[i + r * step] + 1 / image_.depth[i - r * step]) - 1 / image_.depth[i];
    }
    return r > 1 ? std::max(0.0, sum / static_cast<double>(r - 1)) : 0;
  }
  /// Whether pixel `j` and the one before it see one surface.
  bool continues(std::size_t j, std::size_t step) const {
    const std::size_t k = j - step;
    return image_.depth[j] > 0 && image_.depth[k] > 0 && !is_silhouette(image_, j, k, focal_, 1) &&
           !is_silhouette(image_, k, j, focal_, 1);
  }

  const DepthImage& image_;
  double focal_;
};

void round_corners(DepthImage& image, double focal, double share) {
  const DepthImage before = image;
  const CornerRounding rounding(before, focal);
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u, ++i) {
      double& z = image.depth[i];
      if (z > 0) z += share * (1 / rounding.inverse_depth(i, u, v) - z);
    }
  }
}

void cut_faint(DepthImage& image, const std::vector<float>& reflected) {
  constexpr double kFaintest = 0.0018;  // light that comes back, relative to a white surface at 1 m
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    if (reflected[i] < kFaintest * image.depth[i] * image.depth[i]) image.depth[i] = 0;
  }
}

void add_time_noise(DepthImage& image, const std::vector<float>& reflected, double noise, Random& random) {
  constexpr double kCorrelated = 0.45, kWhite = 0.9;  // filters leave little of the noise correlated
  const NoiseField field(image.width, image.height, 3, random);
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < image.height; ++v) {
    for (std::uint32_t u = 0; u < image.width; ++u, ++i) {
      const double normal = kCorrelated * field.at(u, v) + kWhite * random.gaussian();
      double& z = image.depth[i];
      if (z > 0) z = std::max(0.1, z + noise * time_of_flight_noise(z, reflected[i]) * normal);
    }
  }
}

}  // namespace

void TimeOfFlightSensor::measure(const std::vector<Vec3>& color, DepthImage& image, Random& random) const {
  const std::vector<float> reflected = reflected_light(color, image);
  if (noise > 0) {
    round_corners(image, focal, std::min(1.0, noise));
    blend_silhouettes(image, focal, 0.6, random);
  }
  if (holes) cut_faint(image, reflected);
  if (noise > 0) add_time_noise(image, reflected, noise, random);
}

}  // namespace segserve::synth
