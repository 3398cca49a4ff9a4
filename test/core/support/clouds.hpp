// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "segserve/cloud.hpp"

namespace segserve::test {

/// An empty cloud without rows, to which `add` adds points.
inline Cloud unorganized(View view = View::world(0, 0, 5)) {
  Cloud cloud;
  cloud.view = view;
  cloud.height = 1;
  return cloud;
}

/// Adds a point with the color 0x00RRGGBB.
inline void add(Cloud& cloud, float x, float y, float z, std::uint32_t rgb) {
  cloud.x.push_back(x), cloud.y.push_back(y), cloud.z.push_back(z), cloud.rgb.push_back(rgb);
  ++cloud.width;
}

/// Adds a flat square patch of side `size` meters at z, sampled every `step` meters.
inline void add_patch(Cloud& cloud, float x0, float y0, float z, float size, float step, std::uint32_t rgb) {
  const int n = static_cast<int>(size / step);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      add(cloud, x0 + static_cast<float>(i) * step, y0 + static_cast<float>(j) * step, z, rgb);
    }
  }
}

/// Random points in a cube of side `size` around (0, 0, middle).
inline Cloud random_cloud(std::size_t points, float size, float middle, View view, unsigned seed = 1) {
  Cloud cloud = unorganized(view);
  std::mt19937 random(seed);
  const auto coordinate = [&] { return size * (static_cast<float>(random() % 100000) / 100000.0F - 0.5F); };
  for (std::size_t i = 0; i < points; ++i) {
    const float x = coordinate(), y = coordinate(), z = middle + coordinate();
    add(cloud, x, y, z, static_cast<std::uint32_t>(random()) & 0xffffffU);
  }
  return cloud;
}

/// The points in another order; point i of the result is point order[i] of the cloud.
inline Cloud permuted(const Cloud& cloud, std::span<const std::uint32_t> order) {
  Cloud result;
  result.view = cloud.view;
  result.resize(cloud.size(), cloud.has_color());
  result.width = static_cast<std::uint32_t>(cloud.size());
  result.height = 1;
  for (std::size_t i = 0; i < order.size(); ++i) {
    result.x[i] = cloud.x[order[i]], result.y[i] = cloud.y[order[i]], result.z[i] = cloud.z[order[i]];
    if (cloud.has_color()) result.rgb[i] = cloud.rgb[order[i]];
  }
  return result;
}

}  // namespace segserve::test
