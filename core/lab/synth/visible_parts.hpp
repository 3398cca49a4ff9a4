#pragma once

#include <cstdint>
#include <vector>

namespace segserve::synth {

/// Gives the visible parts of each object that do not touch in the image (8 neighbours) labels of
/// their own, as OSD does: 20, 21, .. by descending size, at most ten. Parts below `smallest` pixels
/// are specks of the sensor and keep the object's first label. Labels below 10 stay.
void label_visible_parts(std::uint32_t width, std::uint32_t height, std::uint32_t smallest,
                         std::vector<std::uint32_t>& label);

}  // namespace segserve::synth
