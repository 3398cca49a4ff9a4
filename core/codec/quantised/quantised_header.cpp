// SPDX-License-Identifier: Apache-2.0
#include "core/codec/quantised/quantised_header.hpp"

#include <fmt/format.h>

#include "core/base/status_macros.hpp"
#include "core/codec/common/limit_checks.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "segserve/codec/quantised.hpp"

namespace segserve::codec {
namespace {

constexpr std::string_view kPrefix = "quantised cloud: ";
constexpr std::string_view kMagic = "SEGQ";
constexpr std::uint16_t kVersion = 1;
constexpr std::uint8_t kColorFlag = 1;
constexpr std::uint64_t kPointBytes = 15;  // A decoded point has 3 floats and 3 bytes of color.
constexpr std::size_t kColorChannels = 3;

template <typename T>
T load_at(std::string_view bytes, std::size_t offset) {
  return load<T>(reinterpret_cast<const std::byte*>(bytes.data()) + offset);
}

template <typename T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

absl::Status fault(std::string_view message) {
  return absl::InvalidArgumentError(fmt::format("{}{}", kPrefix, message));
}

absl::Status check_identity(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) return fault("it does not begin with SEGQ");
  if (bytes.size() < QuantisedHeader::kBytes) {
    return fault(fmt::format("it has {} bytes, but the header alone has {}", bytes.size(), QuantisedHeader::kBytes));
  }
  if (const auto version = load_at<std::uint16_t>(bytes, 4); version != kVersion) {
    return fault(fmt::format("it has version {}, but only {} can be read", version, kVersion));
  }
  const auto flags = load_at<std::uint8_t>(bytes, 6);
  const auto reserved = load_at<std::uint8_t>(bytes, 7) | load_at<std::uint8_t>(bytes, 23);
  if ((flags & ~kColorFlag) != 0 || reserved != 0) return fault("a reserved bit of the header is set");
  return absl::OkStatus();
}

absl::Status check_scale(const QuantisedHeader& header) {
  if (!(header.error_bound >= kMinErrorBound && header.error_bound <= kMaxErrorBound)) {
    return fault(
        fmt::format("an error bound of {} m is not in [{}, {}] m", header.error_bound, kMinErrorBound, kMaxErrorBound));
  }
  if (!(header.step >= header.error_bound && header.step <= 2 * header.error_bound)) {
    return fault(
        fmt::format("a step of {} m is not once to twice the error bound of {} m", header.step, header.error_bound));
  }
  return absl::OkStatus();
}

absl::Status check_counts(const QuantisedHeader& header, const DecodeLimits& limits) {
  const std::uint64_t points = std::uint64_t{header.width} * header.height;
  RETURN_IF_ERROR(check_points(kPrefix, points, limits));
  // max_points may be any number. Only after this check the products below, body_bytes included, cannot overflow.
  RETURN_IF_ERROR(check_decoded_points(kPrefix, points, kPointBytes, limits));
  if (header.finite > points) {
    return fault(fmt::format("{} finite points are more than {} x {}", header.finite, header.width, header.height));
  }
  for (const std::uint8_t planes : header.planes) {
    if (header.finite == 0 ? planes != 0 : planes < 1 || planes > 4) {
      return fault(
          fmt::format("a coordinate has {} byte planes, but must have 1 to 4, or 0 if no point is finite", planes));
    }
  }
  return check_bytes("quantised cloud: its decompressed ", header.body_bytes(), limits);
}

}  // namespace

std::size_t QuantisedHeader::body_bytes() const {
  const std::size_t point_bytes = std::size_t{planes[0]} + planes[1] + planes[2] + (has_color ? kColorChannels : 0);
  return bitmap_bytes() + finite * point_bytes;
}

std::string encode_header(const QuantisedHeader& header) {
  std::string bytes(kMagic);
  append(bytes, kVersion);
  append(bytes, header.has_color ? kColorFlag : std::uint8_t{0});
  append(bytes, std::uint8_t{0});
  append(bytes, header.width);
  append(bytes, header.height);
  append(bytes, header.finite);
  for (const std::uint8_t planes : header.planes) append(bytes, planes);
  append(bytes, std::uint8_t{0});
  append(bytes, header.step);
  append(bytes, header.error_bound);
  return bytes;
}

absl::StatusOr<QuantisedHeader> decode_header(std::string_view bytes, const DecodeLimits& limits) {
  RETURN_IF_ERROR(check_identity(bytes));
  QuantisedHeader header;
  header.has_color = (load_at<std::uint8_t>(bytes, 6) & kColorFlag) != 0;
  header.width = load_at<std::uint32_t>(bytes, 8);
  header.height = load_at<std::uint32_t>(bytes, 12);
  header.finite = load_at<std::uint32_t>(bytes, 16);
  for (std::size_t axis = 0; axis < 3; ++axis) header.planes[axis] = load_at<std::uint8_t>(bytes, 20 + axis);
  header.step = load_at<double>(bytes, 24);
  header.error_bound = load_at<double>(bytes, 32);
  RETURN_IF_ERROR(check_scale(header));
  RETURN_IF_ERROR(check_counts(header, limits));
  return header;
}

}  // namespace segserve::codec
