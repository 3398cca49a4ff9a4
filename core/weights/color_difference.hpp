// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/math/vec3.hpp"
#include "core/weights/lab_color.hpp"

namespace segserve {

/// Converts a color from sRGB (IEC 61966-2-1), with channels 0..255 that need not be whole. WeightKernels converts
/// many.
Lab srgb_to_lab(const Vec3& rgb);

/// The CIEDE2000 color difference with k_L = k_C = k_H = 1 (Sharma, Wu, Dalal 2005, eq. 2 to 22). WeightKernels
/// computes many.
double ciede2000(const Lab& p, const Lab& q);

/// R of eq. 4: the range of CIEDE2000 over all pairs of sRGB colors, as the authors use it.
inline constexpr double kCiede2000Range = 137.3607;

}  // namespace segserve
