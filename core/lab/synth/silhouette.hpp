// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "core/lab/synth/depth_raster.hpp"
#include "core/math/random.hpp"

namespace segserve::synth {

/// Whether the surface that pixel `front` sees ends before pixel `behind`, a few pixels away, which sees another one
/// farther back: the step of depth is larger than that of a surface as steep as the less steep of the two. `focal` and
/// `pixels`, the distance of the pixels, are in pixels. False if one of them sees nothing.
bool is_silhouette(const DepthImage& image, std::size_t front, std::size_t behind, double focal, double pixels);

/// Blends the depths of the two surfaces at silhouettes, as pixels do that see a part of each. A pixel beside a
/// silhouette is blended with the probability `share`. It then flies between the surfaces, lies on none, and gets label
/// 0.
void blend_silhouettes(DepthImage& image, double focal, double share, Random& random);

}  // namespace segserve::synth
