// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/planar.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/append_generated.hpp"
#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/scalar_type.hpp"

namespace segserve::codec {
namespace {

absl::Status check_plane(std::string_view name, std::string_view bytes, std::uint64_t points,
                         std::uint64_t bytes_per_point) {
  // This divides, because points * bytes_per_point may exceed 64 bits.
  if (bytes.size() / bytes_per_point == points && bytes.size() % bytes_per_point == 0) return absl::OkStatus();
  return absl::InvalidArgumentError(fmt::format("plane {} has {} bytes, but {} points of {} bytes are needed", name,
                                                bytes.size(), points, bytes_per_point));
}

absl::Status check_planes(const PlanarBytes& planes, std::uint64_t points, const DecodeLimits& limits) {
  RETURN_IF_ERROR(check_points("", points, limits));
  RETURN_IF_ERROR(check_bytes("", planes.x.size() + planes.y.size() + planes.z.size() + planes.rgb.size(), limits));
  RETURN_IF_ERROR(check_plane("x", planes.x, points, 4));
  RETURN_IF_ERROR(check_plane("y", planes.y, points, 4));
  RETURN_IF_ERROR(check_plane("z", planes.z, points, 4));
  return planes.rgb.empty() ? absl::OkStatus() : check_plane("rgb", planes.rgb, points, 3);
}

std::string_view bytes_of(std::span<const float> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

/// The floats at their place in `bytes` if they are aligned there, otherwise copied to `aligned`.
std::span<const float> floats_of(std::string_view bytes, std::vector<float>& aligned) {
  const auto* floats = reinterpret_cast<const float*>(bytes.data());
  const std::size_t count = bytes.size() / sizeof(float);
  if (count == 0 || reinterpret_cast<std::uintptr_t>(floats) % alignof(float) == 0) return {floats, count};
  aligned.resize(count);
  std::memcpy(aligned.data(), bytes.data(), bytes.size());
  return aligned;
}

constexpr std::uint32_t byte_swapped(std::uint32_t v) { return __builtin_bswap32(v); }

/// How many of the points have colors that can be read or written as words of four bytes. The last one cannot, because
/// there may be no byte behind its three.
constexpr std::size_t colors_as_words(std::size_t points) { return points == 0 ? 0 : points - 1; }

std::uint32_t read_color(const char* bytes) {
  const auto* channels = reinterpret_cast<const std::uint8_t*>(bytes);
  return pack_rgb(channels[0], channels[1], channels[2]);
}

/// Packs the three bytes of each point. It reads them as one word, because single bytes take longer.
std::vector<std::uint32_t> read_colors(std::string_view bytes, StopCheck& check) {
  const std::size_t points = bytes.size() / 3;
  std::vector<std::uint32_t> rgb;
  rgb.reserve(points);
  check.for_each_block(0, points, [&](std::size_t first, std::size_t last) {
    math::append_generated(rgb, first, std::min(last, colors_as_words(points)), [bytes = bytes.data()](std::size_t i) {
      std::uint32_t word = 0;
      std::memcpy(&word, bytes + 3 * i, sizeof word);
      return byte_swapped(word) >> 8U;
    });
    if (last == points) rgb.push_back(read_color(bytes.data() + 3 * (points - 1)));
  });
  return rgb;
}

/// Writes the three bytes of each point, as words for the same reason.
void write_colors(std::span<const std::uint32_t> rgb, char* out) {
  if (rgb.empty()) return;
  for (const std::uint32_t color : rgb.first(colors_as_words(rgb.size()))) {
    const std::uint32_t word = byte_swapped(color << 8U);
    std::memcpy(out, &word, sizeof word);
    out += 3;
  }
  *out++ = static_cast<char>(red(rgb.back()));
  *out++ = static_cast<char>(green(rgb.back()));
  *out = static_cast<char>(blue(rgb.back()));
}

}  // namespace

absl::StatusOr<BorrowingCloud> decode_planar(const PlanarBytes& planes, std::uint32_t width, std::uint32_t height,
                                             const View& view, const DecodeLimits& limits, const StopToken& stop) {
  const std::uint64_t points = std::uint64_t{width} * height;
  RETURN_IF_ERROR(check_planes(planes, points, limits));
  Cloud owned;
  owned.width = width;
  owned.height = height;
  owned.view = view;
  CloudView borrowed;
  borrowed.x = floats_of(planes.x, owned.x);
  borrowed.y = floats_of(planes.y, owned.y);
  borrowed.z = floats_of(planes.z, owned.z);
  StopCheck check(stop);
  owned.rgb = read_colors(planes.rgb, check);
  RETURN_IF_ERROR(check.status());
  return BorrowingCloud(std::move(owned), borrowed);
}

PlanarPlanes encode_planar(const CloudView& cloud) {
  PlanarPlanes planes{std::string(bytes_of(cloud.x)), std::string(bytes_of(cloud.y)), std::string(bytes_of(cloud.z)),
                      std::string(3 * cloud.rgb.size(), '\0')};
  write_colors(cloud.rgb, planes.rgb.data());
  return planes;
}

PlanarBytes encode_planar_in_place(const CloudView& cloud, std::unique_ptr<char[]>& rgb) {
  const std::size_t bytes = 3 * cloud.rgb.size();
  rgb = std::make_unique_for_overwrite<char[]>(bytes);
  write_colors(cloud.rgb, rgb.get());
  return {bytes_of(cloud.x), bytes_of(cloud.y), bytes_of(cloud.z), std::string_view(rgb.get(), bytes)};
}

}  // namespace segserve::codec
