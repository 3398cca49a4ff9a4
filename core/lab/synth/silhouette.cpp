// SPDX-License-Identifier: Apache-2.0
#include "core/lab/synth/silhouette.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace segserve::synth {
namespace {

constexpr double kLeastStep = 0.012;  // relative step of depth that two surfaces make at least

double tangent(float cosine) {
  const double c = std::max(0.02, static_cast<double>(cosine));
  return std::sqrt(std::max(0.0, 1 - c * c)) / c;
}

}  // namespace

bool is_silhouette(const DepthImage& image, std::size_t front, std::size_t behind, double focal, double pixels) {
  const double near = image.depth[front], far = image.depth[behind];
  if (near == 0 || far == 0 || far <= near) return false;
  const double slope = std::min(tangent(image.incidence[front]), tangent(image.incidence[behind]));
  return far - near > kLeastStep * near + 2 * pixels * slope * far / focal;
}

void blend_silhouettes(DepthImage& image, double focal, double share, Random& random) {
  const DepthImage before = image;
  const std::size_t w = image.width;
  for (std::size_t v = 1; v + 1 < image.height; ++v) {
    for (std::size_t u = 1; u + 1 < w; ++u) {
      const std::size_t i = v * w + u;
      const double chance = random.uniform();
      const double blend = random.uniform(0.1, 0.9);
      if (chance >= share) continue;
      for (const std::size_t j : std::array<std::size_t, 4>{i - 1, i + 1, i - w, i + w}) {
        if (!is_silhouette(before, i, j, focal, 1) && !is_silhouette(before, j, i, focal, 1)) continue;
        image.depth[i] = before.depth[i] + blend * (before.depth[j] - before.depth[i]);
        image.label[i] = 0;
        break;
      }
    }
  }
}

}  // namespace segserve::synth
