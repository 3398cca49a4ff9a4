#pragma once

#include "core/math/vec3.hpp"
#include "core/weights/lab_color.hpp"

namespace segserve {

/// From sRGB (IEC 61966-2-1), channels 0..255; means need not be whole. Many at once: MetricKernels.
Lab srgb_to_lab(const Vec3& rgb);

/// CIEDE2000 colour difference with k_L = k_C = k_H = 1 (Sharma, Wu, Dalal 2005, eq. 2 to 22). Many at once:
/// MetricKernels.
double ciede2000(const Lab& p, const Lab& q);

/// R of eq. 4: the range of CIEDE2000 over all pairs of sRGB colours that the authors use.
inline constexpr double kCiede2000Range = 137.3607;

}  // namespace segserve
