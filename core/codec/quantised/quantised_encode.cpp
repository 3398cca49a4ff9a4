// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "core/codec/common/finite_point_mask.hpp"
#include "core/codec/common/zstd_block.hpp"
#include "core/codec/quantised/quantised_header.hpp"
#include "segserve/codec/quantised.hpp"

namespace segserve::codec {
namespace {

constexpr int kZstdLevel = 1;

double largest_magnitude(const CloudView& cloud, std::span<const std::uint32_t> finite) {
  float largest = 0;
  for (const std::span<const float> axis : {cloud.x, cloud.y, cloud.z}) {
    for (const std::uint32_t i : finite) largest = std::max(largest, std::abs(axis[i]));
  }
  return largest;
}

/// The step of the grid: twice the bound, less what rounding the decoded coordinate to a float may add.
absl::StatusOr<double> grid_step(double error_bound, double largest) {
  const double rounding = (largest + error_bound) * 0x1p-23;
  if (rounding <= error_bound / 2) return 2 * (error_bound - rounding);
  return absl::InvalidArgumentError(
      fmt::format("coordinates of {} m cannot be kept within {} m: floats that large are {} m apart", largest,
                  error_bound, rounding));
}

/// The differences of the cell numbers of subsequent finite points along one axis, zigzag: small ones are small
/// numbers, whatever their sign.
std::vector<std::uint32_t> differences(std::span<const float> axis, std::span<const std::uint32_t> finite,
                                       double step) {
  std::vector<std::uint32_t> out(finite.size());
  const double cells_per_meter = 1 / step;
  std::int32_t before = 0;
  for (std::size_t k = 0; k < finite.size(); ++k) {
    const double position = axis[finite[k]] * cells_per_meter;  // beyond +-2^24 grid_step has refused
    const auto truncated = static_cast<std::int32_t>(position);
    const std::int32_t cell = truncated - (position < truncated ? 1 : 0);
    const std::int32_t difference = cell - before;
    before = cell;
    out[k] = static_cast<std::uint32_t>(difference) << 1U ^ static_cast<std::uint32_t>(difference >> 31U);
  }
  return out;
}

std::uint8_t bytes_needed(std::span<const std::uint32_t> values) {
  std::uint32_t all = 0;
  for (const std::uint32_t value : values) all |= value;
  return static_cast<std::uint8_t>(std::max(1U, (static_cast<unsigned>(std::bit_width(all)) + 7) / 8));
}

char* write_planes(std::span<const std::uint32_t> values, unsigned planes, char* out) {
  for (unsigned plane = 0; plane < planes; ++plane) {
    for (const std::uint32_t value : values) *out++ = static_cast<char>(value >> 8 * plane);
  }
  return out;
}

void write_colors(std::span<const std::uint32_t> rgb, std::span<const std::uint32_t> finite, char* out) {
  for (const unsigned shift : {16U, 8U, 0U}) {
    std::uint32_t before = 0;
    for (const std::uint32_t i : finite) {
      const std::uint32_t value = rgb[i] >> shift;
      *out++ = static_cast<char>(value - before);
      before = value;
    }
  }
}

}  // namespace

absl::StatusOr<std::string> encode_quantised(const CloudView& cloud, double error_bound) {
  if (!(error_bound >= kMinErrorBound && error_bound <= kMaxErrorBound)) {
    return absl::InvalidArgumentError(
        fmt::format("an error bound of {} m is not in [{}, {}] m", error_bound, kMinErrorBound, kMaxErrorBound));
  }
  const std::vector<std::uint32_t> finite = finite_points(cloud);
  const absl::StatusOr<double> step = grid_step(error_bound, largest_magnitude(cloud, finite));
  if (!step.ok()) return step.status();

  QuantisedHeader header{.width = cloud.width,
                         .height = cloud.height,
                         .finite = static_cast<std::uint32_t>(finite.size()),
                         .has_color = cloud.has_color(),
                         .step = *step,
                         .error_bound = error_bound};
  std::array<std::vector<std::uint32_t>, 3> axes;
  const std::array<std::span<const float>, 3> coordinates{cloud.x, cloud.y, cloud.z};
  for (std::size_t axis = 0; axis < 3 && !finite.empty(); ++axis) {
    axes[axis] = differences(coordinates[axis], finite, *step);
    header.planes[axis] = bytes_needed(axes[axis]);
  }
  std::string body(header.body_bytes(), '\0');
  if (header.has_bitmap()) write_bitmap(finite, body.data());
  char* out = body.data() + header.bitmap_bytes();
  for (std::size_t axis = 0; axis < 3; ++axis) out = write_planes(axes[axis], header.planes[axis], out);
  if (cloud.has_color()) write_colors(cloud.rgb, finite, out);

  const absl::StatusOr<std::string> compressed = zstd_compress(body, kZstdLevel);
  if (!compressed.ok()) return compressed.status();
  return encode_header(header) + *compressed;
}

}  // namespace segserve::codec
