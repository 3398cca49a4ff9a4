// SPDX-License-Identifier: Apache-2.0
#include "segserve/codec/draco.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/status_macros.hpp"
#include "core/base/stop_check.hpp"
#include "core/codec/common/finite_point_mask.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/draco/draco_header.hpp"
#include "draco/compression/decode.h"
#include "draco/compression/encode.h"
#include "draco/point_cloud/point_cloud_builder.h"

namespace segserve::codec {
namespace {

constexpr std::uint64_t kPointBytes = 15;  // A decoded point has 3 floats and 3 bytes of color.
constexpr int kMaxBits = 30;               // Draco quantizes a coordinate to at most so many bits.

absl::Status fault(std::string_view message) { return absl::InvalidArgumentError(fmt::format("Draco: {}", message)); }

/// Returns the result of function(), or INVALID_ARGUMENT if it throws. Draco throws nothing itself, but its containers
/// may.
template <typename Function>
auto catch_exceptions(Function function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& error) {
    return fault(error.what());
  }
}

/// The fewest bits that keep the bound. Draco's grid has 2^bits values along the longest side of the bounding box, and
/// Draco computes in floats, whose rounding takes some of the bound.
absl::StatusOr<int> quantization_bits(const CloudView& cloud, std::span<const std::uint32_t> finite, double bound) {
  double range = 0;
  double magnitude = 0;
  for (const std::span<const float> axis : {cloud.x, cloud.y, cloud.z}) {
    float least = axis[finite[0]];
    float most = least;
    for (const std::uint32_t i : finite) {
      least = std::min(least, axis[i]);
      most = std::max(most, axis[i]);
    }
    range = std::max(range, double{most} - least);
    magnitude = std::max({magnitude, std::abs(double{least}), std::abs(double{most})});
  }
  const double rounding = (magnitude + range) * 0x1p-22;
  for (int bits = 1; bits <= kMaxBits; ++bits) {
    const double step = range / static_cast<double>((1U << static_cast<unsigned>(bits)) - 1);
    if (step / 2 + rounding <= bound) return bits;
  }
  return fault(fmt::format("coordinates of {} m cannot be kept within {} m", magnitude, bound));
}

/// Draco's bytes of the finite points.
absl::StatusOr<std::string> encode_points(const CloudView& cloud, std::span<const std::uint32_t> finite, int bits) {
  draco::PointCloudBuilder builder;
  builder.Start(static_cast<draco::PointIndex::ValueType>(finite.size()));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int color = cloud.has_color() ? builder.AddAttribute(draco::GeometryAttribute::COLOR, 3, draco::DT_UINT8) : -1;
  for (std::size_t k = 0; k < finite.size(); ++k) {
    const std::uint32_t i = finite[k];
    const draco::PointIndex point(static_cast<std::uint32_t>(k));
    const std::array<float, 3> xyz{cloud.x[i], cloud.y[i], cloud.z[i]};
    builder.SetAttributeValueForPoint(position, point, xyz.data());
    if (color < 0) continue;
    const std::array<std::uint8_t, 3> rgb{red(cloud.rgb[i]), green(cloud.rgb[i]), blue(cloud.rgb[i])};
    builder.SetAttributeValueForPoint(color, point, rgb.data());
  }
  const std::unique_ptr<draco::PointCloud> points = builder.Finalize(false);
  if (points == nullptr) return absl::InternalError("Draco: the points cannot be built");
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodePointCloudToBuffer(*points, &buffer);
  if (!status.ok()) return absl::InternalError(fmt::format("Draco: {}", status.error_msg()));
  return std::string(buffer.data(), buffer.size());
}

/// Copies Draco's points to the cloud. Point k goes to index finite[k].
absl::Status read_points(const draco::PointCloud& points, std::span<const std::uint32_t> finite, const StopToken& stop,
                         Cloud& cloud) {
  const draco::PointAttribute* position = points.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  const draco::PointAttribute* color = points.GetNamedAttribute(draco::GeometryAttribute::COLOR);
  if (points.num_points() != finite.size() || position == nullptr || (color != nullptr) != cloud.has_color()) {
    return fault("it decodes to other points than its header claims");
  }
  StopCheck check(stop);
  for (std::size_t k = 0; k < finite.size() && !check.after(1); ++k) {
    const draco::PointIndex point(static_cast<std::uint32_t>(k));
    const std::uint32_t i = finite[k];
    std::array<float, 3> xyz{};
    if (!position->ConvertValue<float, 3>(position->mapped_index(point), xyz.data())) {
      return fault(fmt::format("the position of point {} is broken", k));
    }
    if (!is_finite(xyz[0], xyz[1], xyz[2])) return fault(fmt::format("point {} is not finite", k));
    cloud.x[i] = xyz[0];
    cloud.y[i] = xyz[1];
    cloud.z[i] = xyz[2];
    if (color == nullptr) continue;
    std::array<std::uint8_t, 3> rgb{};
    if (!color->ConvertValue<std::uint8_t, 3>(color->mapped_index(point), rgb.data())) {
      return fault(fmt::format("the color of point {} is broken", k));
    }
    cloud.rgb[i] = pack_rgb(rgb[0], rgb[1], rgb[2]);
  }
  return check.status();
}

absl::Status wrong_count(std::uint64_t points, std::uint64_t cloud_points) {
  return fault(fmt::format("it has {} points, but the cloud has {}", points, cloud_points));
}

/// The indices in the cloud, which has `points` points, of the points that Draco's header announces. `finite` is
/// DracoFile::finite.
absl::StatusOr<std::vector<std::uint32_t>> indices_of(const DracoHeader& header, std::string_view finite,
                                                      std::uint64_t points, const StopToken& stop) {
  if (finite.empty()) {
    if (header.points != points) return wrong_count(header.points, points);
    std::vector<std::uint32_t> all(points);
    std::iota(all.begin(), all.end(), 0U);
    return all;
  }
  if (finite.size() != bitmap_bytes(points)) {
    return fault(
        fmt::format("the bitmap of {} points has {} bytes, not {}", points, finite.size(), bitmap_bytes(points)));
  }
  if (header.points > points) return wrong_count(header.points, points);
  StopCheck check(stop);
  auto indices = read_bitmap(finite, points, header.points, check);
  if (check.stopped()) return check.status();
  if (!indices) return fault(fmt::format("the bitmap does not mark {} of {} points", header.points, points));
  return *std::move(indices);
}

absl::Status decode_points(std::string_view data, std::span<const std::uint32_t> indices, const StopToken& stop,
                           Cloud& cloud) {
  draco::DecoderBuffer buffer;
  buffer.Init(data.data(), data.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
  if (!decoded.ok()) return fault(decoded.status().error_msg());
  return read_points(*decoded.value(), indices, stop, cloud);
}

}  // namespace

bool draco_is_built() { return true; }

absl::StatusOr<DracoFile> encode_draco(const CloudView& cloud, double error_bound) {
  if (!(error_bound > 0)) return fault(fmt::format("an error bound of {} m is not above 0", error_bound));
  const std::vector<std::uint32_t> finite = finite_points(cloud);
  DracoFile file;
  if (finite.size() != cloud.size()) {
    file.finite.resize(bitmap_bytes(cloud.size()));
    write_bitmap(finite, file.finite.data());
  }
  if (finite.empty()) return file;
  ASSIGN_OR_RETURN(const int bits, quantization_bits(cloud, finite, error_bound));
  ASSIGN_OR_RETURN(file.data, catch_exceptions([&] { return encode_points(cloud, finite, bits); }));
  return file;
}

absl::StatusOr<Cloud> decode_draco(std::string_view data, std::string_view finite, std::uint32_t width,
                                   std::uint32_t height, const View& view, const DecodeLimits& limits,
                                   const StopToken& stop) {
  if (!limits.draco) return absl::FailedPreconditionError("Draco is not enabled");
  const std::uint64_t points = std::uint64_t{width} * height;
  RETURN_IF_ERROR(check_points("Draco: ", points, limits));
  RETURN_IF_ERROR(check_decoded_points("Draco: ", points, kPointBytes, limits));
  DracoHeader header;
  if (!data.empty()) {
    ASSIGN_OR_RETURN(header, read_draco_header(data));
  }
  ASSIGN_OR_RETURN(const std::vector<std::uint32_t> indices, indices_of(header, finite, points, stop));
  Cloud cloud = make_nan_cloud(width, height, header.color_components > 0, view);
  if (indices.empty()) return cloud;
  RETURN_IF_ERROR(catch_exceptions([&] { return decode_points(data, indices, stop, cloud); }));
  return cloud;
}

}  // namespace segserve::codec
