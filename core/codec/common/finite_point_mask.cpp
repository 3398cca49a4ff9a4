// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/finite_point_mask.hpp"

#include <bit>
#include <limits>

#include "core/base/stop_check.hpp"

namespace segserve::codec {

std::vector<std::uint32_t> finite_points(const CloudView& cloud) {
  std::vector<std::uint32_t> indices(cloud.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    indices[count] = static_cast<std::uint32_t>(i);
    count += is_finite(cloud.x[i], cloud.y[i], cloud.z[i]) ? 1 : 0;
  }
  indices.resize(count);
  return indices;
}

void write_bitmap(std::span<const std::uint32_t> finite, char* bitmap) {
  for (const std::uint32_t i : finite) bitmap[i / 8] = static_cast<char>(bitmap[i / 8] | 1U << i % 8);
}

std::optional<std::vector<std::uint32_t>> read_bitmap(std::string_view bitmap, std::size_t points, std::size_t finite,
                                                      StopCheck& check) {
  std::vector<std::uint32_t> indices;
  indices.reserve(finite);
  for (std::size_t byte = 0; byte < bitmap.size() && !check.after(8); ++byte) {
    for (unsigned bits = static_cast<unsigned char>(bitmap[byte]); bits != 0; bits &= bits - 1) {
      const std::size_t i = 8 * byte + static_cast<unsigned>(std::countr_zero(bits));
      if (i >= points || indices.size() == finite) return std::nullopt;
      indices.push_back(static_cast<std::uint32_t>(i));
    }
  }
  if (indices.size() != finite) return std::nullopt;
  return indices;
}

Cloud make_nan_cloud(std::uint32_t width, std::uint32_t height, bool color, const View& view) {
  const std::size_t points = std::size_t{width} * height;
  Cloud cloud;
  cloud.width = width;
  cloud.height = height;
  cloud.view = view;
  cloud.rgb.resize(color ? points : 0);
  for (std::vector<float>* axis : {&cloud.x, &cloud.y, &cloud.z}) {
    axis->assign(points, std::numeric_limits<float>::quiet_NaN());
  }
  return cloud;
}

}  // namespace segserve::codec
