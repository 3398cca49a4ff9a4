// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <vector>

#include "core/base/status_macros.hpp"
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

/// The step of the grid. It is twice the bound, less the most that rounding the decoded coordinate to a float can add.
absl::StatusOr<double> grid_step(double error_bound, double largest) {
  const double rounding = (largest + error_bound) * 0x1p-23;
  if (rounding <= error_bound / 2) return 2 * (error_bound - rounding);
  return absl::InvalidArgumentError(
      fmt::format("coordinates of {} m cannot be kept within {} m: rounding them to floats adds up to {} m", largest,
                  error_bound, rounding));
}

/// The differences between the cell numbers of subsequent finite points along one axis. They are zigzag, so that small
/// differences of either sign are small numbers.
std::vector<std::uint32_t> differences(std::span<const float> axis, std::span<const std::uint32_t> finite,
                                       double step) {
  std::vector<std::uint32_t> out(finite.size());
  const double cells_per_meter = 1 / step;
  std::int32_t before = 0;
  for (std::size_t k = 0; k < finite.size(); ++k) {
    const double position = axis[finite[k]] * cells_per_meter;  // grid_step refuses positions beyond +-2^24.
    const auto truncated = static_cast<std::int32_t>(position);
    const std::int32_t cell = truncated - (position < truncated ? 1 : 0);
    const std::int32_t difference = cell - before;
    before = cell;
    out[k] = static_cast<std::uint32_t>(difference) << 1U ^ static_cast<std::uint32_t>(difference >> 31U);
  }
  return out;
}

/// The bytes that the largest value needs, at least 1.
std::uint8_t bytes_needed(std::span<const std::uint32_t> values) {
  std::uint32_t all = 0;
  for (const std::uint32_t value : values) all |= value;
  return static_cast<std::uint8_t>(std::max(1U, (static_cast<unsigned>(std::bit_width(all)) + 7) / 8));
}

/// Writes byte p of each value to plane p. Returns the end of the planes.
char* write_planes(std::span<const std::uint32_t> values, unsigned planes, char* out) {
  for (unsigned plane = 0; plane < planes; ++plane) {
    for (const std::uint32_t value : values) *out++ = static_cast<char>(value >> 8 * plane);
  }
  return out;
}

/// Writes a plane for each of R, G and B, with the differences between subsequent finite points.
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
  ASSIGN_OR_RETURN(const double step, grid_step(error_bound, largest_magnitude(cloud, finite)));
  QuantisedHeader header{.width = cloud.width,
                         .height = cloud.height,
                         .finite = static_cast<std::uint32_t>(finite.size()),
                         .has_color = cloud.has_color(),
                         .step = step,
                         .error_bound = error_bound};
  std::array<std::vector<std::uint32_t>, 3> axes;
  const std::array<std::span<const float>, 3> coordinates{cloud.x, cloud.y, cloud.z};
  for (std::size_t axis = 0; axis < 3 && !finite.empty(); ++axis) {
    axes[axis] = differences(coordinates[axis], finite, step);
    header.planes[axis] = bytes_needed(axes[axis]);
  }
  std::string body(header.body_bytes(), '\0');
  if (header.has_bitmap()) write_bitmap(finite, body.data());
  char* out = body.data() + header.bitmap_bytes();
  for (std::size_t axis = 0; axis < 3; ++axis) out = write_planes(axes[axis], header.planes[axis], out);
  if (cloud.has_color()) write_colors(cloud.rgb, finite, out);

  ASSIGN_OR_RETURN(const std::string compressed, zstd_compress(body, kZstdLevel));
  return encode_header(header) + compressed;
}

}  // namespace segserve::codec
