// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/math/vec3.hpp"
#include "segserve/cloud.hpp"

namespace segserve::synth {

/// A color (0 to 1 in each channel, clamped) as 0x00RRGGBB.
inline std::uint32_t packed_color(const Vec3& color) {
  const auto byte = [](double value) { return static_cast<std::uint8_t>(std::clamp(255 * value + 0.5, 0.0, 255.0)); };
  return pack_rgb(byte(color.x), byte(color.y), byte(color.z));
}

}  // namespace segserve::synth
