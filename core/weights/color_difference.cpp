// SPDX-License-Identifier: Apache-2.0
#include "core/weights/color_difference.hpp"

#include "core/weights/simd/weight_kernels.hpp"

namespace segserve {

Lab srgb_to_lab(const Vec3& rgb) {
  Lab color;
  weight_kernels().srgb_to_lab(&rgb, 1, &color);
  return color;
}

double ciede2000(const Lab& p, const Lab& q) {
  const Lab colors[] = {p, q};
  const RegionEdge pair{0, 1};
  double difference = 0;
  weight_kernels().color_differences(colors, &pair, 1, &difference);
  return difference;
}

}  // namespace segserve
