// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstdint>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/finite_point_mask.hpp"
#include "core/codec/common/zstd_block.hpp"
#include "core/codec/quantised/quantised_header.hpp"
#include "segserve/codec/quantised.hpp"

namespace segserve::codec {
namespace {

using Bytes = const std::uint8_t*;

/// Calls put(k, coordinate) for the `count` finite points, along one axis. A coordinate is the middle of its cell.
template <unsigned kPlanes, typename Put>
void read_axis(Bytes planes, std::size_t count, double step, StopCheck& check, Put put) {
  std::uint32_t cell = 0;  // Damaged bytes may let it wrap around, which does no harm.
  check.for_each(0, count, [&](std::size_t k) {
    std::uint32_t zigzag = 0;
    for (unsigned plane = 0; plane < kPlanes; ++plane) zigzag |= std::uint32_t{planes[plane * count + k]} << 8 * plane;
    cell += (zigzag >> 1U) ^ (0U - (zigzag & 1U));
    put(k, static_cast<float>((static_cast<double>(static_cast<std::int32_t>(cell)) + 0.5) * step));
  });
}

template <typename Put>
void read_axis(unsigned plane_count, Bytes planes, std::size_t count, double step, StopCheck& check, Put put) {
  switch (plane_count) {
    case 1:
      return read_axis<1>(planes, count, step, check, put);
    case 2:
      return read_axis<2>(planes, count, step, check, put);
    case 3:
      return read_axis<3>(planes, count, step, check, put);
    default:
      return read_axis<4>(planes, count, step, check, put);
  }
}

/// Calls put(k, color) for the `count` finite points.
template <typename Put>
void read_colors(Bytes planes, std::size_t count, StopCheck& check, Put put) {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  check.for_each(0, count, [&](std::size_t k) {
    r = static_cast<std::uint8_t>(r + planes[k]);
    g = static_cast<std::uint8_t>(g + planes[count + k]);
    b = static_cast<std::uint8_t>(b + planes[2 * count + k]);
    put(k, pack_rgb(r, g, b));
  });
}

/// Reads the planes of all finite points. at(k) is the index of finite point k.
template <typename At>
void read_points(const QuantisedHeader& header, Bytes planes, At at, StopCheck& check, Cloud& cloud) {
  const std::array<float*, 3> axes{cloud.x.data(), cloud.y.data(), cloud.z.data()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    read_axis(header.planes[axis], planes, header.finite, header.step, check,
              [out = axes[axis], at](std::size_t k, float value) { out[at(k)] = value; });
    planes += std::size_t{header.finite} * header.planes[axis];
  }
  if (!header.has_color) return;
  read_colors(planes, header.finite, check,
              [out = cloud.rgb.data(), at](std::size_t k, std::uint32_t rgb) { out[at(k)] = rgb; });
}

/// Reads the content of the zstd frame, which has header.body_bytes() bytes, into a cloud of points at NaN.
absl::Status read_body(const QuantisedHeader& header, std::string_view body, const StopToken& stop, Cloud& cloud) {
  if (header.finite == 0 && !header.has_bitmap()) return absl::OkStatus();
  StopCheck check(stop);
  const auto* planes = reinterpret_cast<Bytes>(body.data()) + header.bitmap_bytes();
  if (!header.has_bitmap()) {
    const auto at = [](std::size_t k) { return k; };
    read_points(header, planes, at, check, cloud);
    return check.status();
  }
  const auto finite = read_bitmap(body.substr(0, header.bitmap_bytes()), header.points(), header.finite, check);
  if (check.stopped()) return check.status();
  if (!finite) {
    return absl::InvalidArgumentError(
        fmt::format("quantised cloud: the bitmap does not mark {} of {} points", header.finite, header.points()));
  }
  if (finite->empty()) return absl::OkStatus();
  const auto at = [indices = finite->data()](std::size_t k) { return indices[k]; };
  read_points(header, planes, at, check, cloud);
  return check.status();
}

}  // namespace

absl::StatusOr<QuantisedCloud> decode_quantised(std::string_view bytes, const View& view, const DecodeLimits& limits,
                                                const StopToken& stop) {
  ASSIGN_OR_RETURN(const QuantisedHeader header, decode_header(bytes, limits));
  ASSIGN_OR_RETURN(const std::string body,
                   zstd_decompress(bytes.substr(QuantisedHeader::kBytes), header.body_bytes(), limits));
  RETURN_IF_ERROR(stop.check());
  QuantisedCloud decoded{make_nan_cloud(header.width, header.height, header.has_color, view), header.error_bound};
  RETURN_IF_ERROR(read_body(header, body, stop, decoded.cloud));
  return decoded;
}

}  // namespace segserve::codec
