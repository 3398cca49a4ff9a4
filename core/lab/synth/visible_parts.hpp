// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace segserve::synth {

/// Parts with fewer pixels are specks of the sensor.
inline constexpr std::uint32_t kSpeckPixels = 16;

/// Gives each connected visible part of an object (8 neighbors) a label of its own, as OSD does: 20, 21, 22 and so on
/// by descending size, for at most ten parts. Parts with fewer than `smallest` pixels are specks of the sensor and keep
/// the first label of the object. Labels below 10 stay. `label` has one entry per pixel, row by row.
void label_visible_parts(std::uint32_t width, std::uint32_t height, std::uint32_t smallest,
                         std::vector<std::uint32_t>& label);

}  // namespace segserve::synth
