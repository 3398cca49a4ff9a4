// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <utility>

#include "core/lab/synth/scene.hpp"
#include "segserve/cloud.hpp"

namespace segserve::client {

/// A small table with objects. Some points have no depth.
inline Cloud table_scene() {
  synth::SceneOptions options;
  options.width = 160;
  options.height = 120;
  auto scene = synth::make_tabletop(options);
  return std::move(scene->cloud);
}

/// A flat, gray, organized patch, which compresses well.
inline Cloud flat_cloud(std::uint32_t width, std::uint32_t height) {
  Cloud cloud;
  cloud.resize(std::size_t{width} * height, true);
  cloud.width = width;
  cloud.height = height;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.x[i] = static_cast<float>(i % width) * 0.001F;
    cloud.y[i] = static_cast<float>(i / width) * 0.001F;
    cloud.z[i] = 1.0F;
    cloud.rgb[i] = 0x808080;
  }
  return cloud;
}

/// A row of points whose coordinates no compressor makes small.
inline Cloud incompressible_cloud(std::uint32_t points) {
  Cloud cloud = flat_cloud(points, 1);
  std::uint32_t state = 1;
  const auto next = [&state] { return state = state * 1664525U + 1013904223U; };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.x[i] = static_cast<float>(next()) * 1e-10F;
    cloud.y[i] = static_cast<float>(next()) * 1e-10F;
    cloud.z[i] = 1.0F + static_cast<float>(next()) * 1e-10F;
    cloud.rgb[i] = next() & 0xffffffU;
  }
  return cloud;
}

}  // namespace segserve::client
