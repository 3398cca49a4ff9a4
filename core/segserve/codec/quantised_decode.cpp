#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "segserve/codec/quantised.hpp"
#include "segserve/codec/quantised_header.hpp"
#include "segserve/codec/zstd.hpp"

namespace segserve::codec {
namespace {

using Bytes = const std::uint8_t*;

/// The indices of the finite points; nullopt unless the bitmap has as many as the header says, and no bit beyond the
/// last point.
std::optional<std::vector<std::uint32_t>> finite_points(const QuantisedHeader& header, Bytes bitmap) {
  std::vector<std::uint32_t> indices;
  indices.reserve(header.finite);
  for (std::size_t byte = 0; byte < header.bitmap_bytes(); ++byte) {
    for (unsigned bits = bitmap[byte]; bits != 0; bits &= bits - 1) {
      const std::size_t i = 8 * byte + static_cast<unsigned>(std::countr_zero(bits));
      if (i >= header.points() || indices.size() == header.finite) return std::nullopt;
      indices.push_back(static_cast<std::uint32_t>(i));
    }
  }
  if (indices.size() != header.finite) return std::nullopt;
  return indices;
}

/// Coordinate k of one axis: the middle of its cell.
template <unsigned kPlanes, typename Put>
void read_axis(Bytes planes, std::size_t count, double step, Put put) {
  std::uint32_t cell = 0;  // wraps around in broken bytes, which is no harm
  for (std::size_t k = 0; k < count; ++k) {
    std::uint32_t zigzag = 0;
    for (unsigned plane = 0; plane < kPlanes; ++plane) zigzag |= std::uint32_t{planes[plane * count + k]} << 8 * plane;
    cell += (zigzag >> 1U) ^ (0U - (zigzag & 1U));
    put(k, static_cast<float>((static_cast<double>(static_cast<std::int32_t>(cell)) + 0.5) * step));
  }
}

template <typename Put>
void read_axis(unsigned plane_count, Bytes planes, std::size_t count, double step, Put put) {
  switch (plane_count) {
    case 1:
      return read_axis<1>(planes, count, step, put);
    case 2:
      return read_axis<2>(planes, count, step, put);
    case 3:
      return read_axis<3>(planes, count, step, put);
    default:
      return read_axis<4>(planes, count, step, put);
  }
}

/// The three colour planes, interleaved again.
template <typename Put>
void read_colors(Bytes planes, std::size_t count, Put put) {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  for (std::size_t k = 0; k < count; ++k) {
    r = static_cast<std::uint8_t>(r + planes[k]);
    g = static_cast<std::uint8_t>(g + planes[count + k]);
    b = static_cast<std::uint8_t>(b + planes[2 * count + k]);
    put(k, pack_rgb(r, g, b));
  }
}

/// `at(k)` is the index of finite point k.
template <typename At>
void read_points(const QuantisedHeader& header, Bytes planes, At at, Cloud& cloud) {
  const std::array<float*, 3> axes{cloud.x.data(), cloud.y.data(), cloud.z.data()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    read_axis(header.planes[axis], planes, header.finite, header.step,
              [out = axes[axis], at](std::size_t k, float value) { out[at(k)] = value; });
    planes += std::size_t{header.finite} * header.planes[axis];
  }
  if (!header.has_color) return;
  read_colors(planes, header.finite,
              [out = cloud.rgb.data(), at](std::size_t k, std::uint32_t rgb) { out[at(k)] = rgb; });
}

Cloud empty_cloud(const QuantisedHeader& header, const View& view) {
  constexpr float kNoPoint = std::numeric_limits<float>::quiet_NaN();
  Cloud cloud;
  cloud.width = header.width;
  cloud.height = header.height;
  cloud.view = view;
  cloud.rgb.resize(header.has_color ? header.points() : 0);
  for (std::vector<float>* axis : {&cloud.x, &cloud.y, &cloud.z}) axis->assign(header.points(), kNoPoint);
  return cloud;
}

}  // namespace

absl::StatusOr<QuantisedCloud> decode_quantised(std::string_view bytes, const View& view, const DecodeLimits& limits) {
  const absl::StatusOr<QuantisedHeader> header = decode_header(bytes, limits);
  if (!header.ok()) return header.status();
  const absl::StatusOr<std::string> body =
      zstd_decompress(bytes.substr(QuantisedHeader::kBytes), header->body_bytes(), limits);
  if (!body.ok()) return body.status();

  const auto* data = reinterpret_cast<Bytes>(body->data());
  QuantisedCloud decoded{empty_cloud(*header, view), header->error_bound};
  if (!header->has_bitmap()) {
    if (header->finite > 0)
      read_points(
          *header, data, [](std::size_t k) { return k; }, decoded.cloud);
    return decoded;
  }
  const auto finite = finite_points(*header, data);
  if (!finite) {
    return absl::InvalidArgumentError(
        fmt::format("quantised cloud: the bitmap does not have {} of {} points", header->finite, header->points()));
  }
  if (finite->empty()) return decoded;
  read_points(
      *header, data + header->bitmap_bytes(), [at = finite->data()](std::size_t k) { return at[k]; }, decoded.cloud);
  return decoded;
}

}  // namespace segserve::codec
