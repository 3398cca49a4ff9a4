// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

#include "core/lab/synth/scene.hpp"

namespace segserve::synth {

/// FNV-1a over the bits of all coordinates, colors and labels.
inline std::uint64_t checksum(const SyntheticScene& scene) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  const auto mix_in = [&hash](std::uint32_t word) {
    for (unsigned shift = 0; shift < 32; shift += 8) hash = (hash ^ (word >> shift & 0xFFU)) * 0x100000001b3U;
  };
  for (std::size_t i = 0; i < scene.label.size(); ++i) {
    for (const float value : {scene.cloud.x[i], scene.cloud.y[i], scene.cloud.z[i]}) {
      mix_in(std::bit_cast<std::uint32_t>(value));
    }
    if (scene.cloud.has_color()) mix_in(scene.cloud.rgb[i]);
    mix_in(scene.label[i]);
  }
  return hash;
}

}  // namespace segserve::synth
