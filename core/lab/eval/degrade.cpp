// SPDX-License-Identifier: Apache-2.0
#include "core/lab/eval/degrade.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

#include "core/base/status_macros.hpp"
#include "core/math/random.hpp"
#include "fmt/format.h"

namespace segserve::eval {
namespace {

constexpr double kMaxScale = 1000;
constexpr double kMaxNoise = 1000;

/// FNV-1a, because std::hash differs between libraries.
std::uint64_t hash(std::string_view text) {
  std::uint64_t value = 0xCBF29CE484222325U;
  for (const char c : text) value = (value ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  return value;
}

void remove_point(codec::LabeledCloud& scene, std::size_t i) {
  Cloud& cloud = scene.cloud;
  cloud.x[i] = cloud.y[i] = cloud.z[i] = std::numeric_limits<float>::quiet_NaN();
  if (!scene.label.empty()) scene.label[i] = 0;
}

void rescale(Cloud& cloud, double scale) {
  const auto times = [scale](float& v) { v = static_cast<float>(v * scale); };
  for (auto* plane : {&cloud.x, &cloud.y, &cloud.z}) {
    for (float& v : *plane) times(v);
  }
  if (cloud.view.sensor) {
    for (float& v : *cloud.view.sensor) times(v);
  }
}

void add_noise(codec::LabeledCloud& scene, double sigma, Random& random) {
  Cloud& cloud = scene.cloud;
  const bool camera = cloud.view.kind == ViewKind::kCamera;
  const Eigen::Vector3f origin = cloud.view.sensor.value_or(Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    // Missing points get a number, too, so that the noise of a pixel does not depend on the holes before it.
    const double gaussian = random.gaussian();
    if (!is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) continue;
    const std::array<double, 3> ray = {double{cloud.x[i]} - origin[0], double{cloud.y[i]} - origin[1],
                                       double{cloud.z[i]} - origin[2]};
    const double depth = camera ? ray[2] : std::sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
    const double stretch = 1 + sigma * depth * gaussian;  // (depth + sigma depth^2 gaussian) / depth
    if (stretch <= 0) {
      remove_point(scene, i);
      continue;
    }
    cloud.x[i] = static_cast<float>(origin[0] + ray[0] * stretch);
    cloud.y[i] = static_cast<float>(origin[1] + ray[1] * stretch);
    cloud.z[i] = static_cast<float>(origin[2] + ray[2] * stretch);
  }
}

}  // namespace

absl::Status check(const Degradation& d) {
  std::string faults;
  const auto expect = [&](bool in_range, std::string_view name, double value, std::string_view range) {
    if (in_range) return;
    faults += fmt::format("{}{}: {} is not in {}", faults.empty() ? "" : "; ", name, value, range);
  };
  expect(d.scale > 0 && d.scale <= kMaxScale, "scale", d.scale, "(0, 1000]");
  expect(d.noise_mm >= 0 && d.noise_mm <= kMaxNoise, "noise-mm", d.noise_mm, "[0, 1000]");
  expect(d.keep > 0 && d.keep <= 1, "keep", d.keep, "(0, 1]");
  return faults.empty() ? absl::OkStatus() : absl::InvalidArgumentError(faults);
}

absl::Status degrade(codec::LabeledCloud& scene, const Degradation& d, std::string_view scene_name) {
  RETURN_IF_ERROR(check(d));
  if (d.noise_mm > 0 && !scene.cloud.view.has_sensor()) {
    return absl::InvalidArgumentError("depth noise needs to know where the sensor is, which the file does not say");
  }
  Random noise(mix(d.seed) ^ hash(scene_name));
  Random loss(noise.bits());
  if (d.scale != 1) rescale(scene.cloud, d.scale);
  if (d.noise_mm > 0) add_noise(scene, d.noise_mm / 1000, noise);
  for (std::size_t i = 0; d.keep < 1 && i < scene.cloud.size(); ++i) {
    if (!loss.chance(d.keep)) remove_point(scene, i);
  }
  if (!d.color) scene.cloud.rgb.clear();
  return absl::OkStatus();
}

}  // namespace segserve::eval
