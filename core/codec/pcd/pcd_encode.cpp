// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <lzf.h>

#include <bit>
#include <cstring>
#include <iterator>
#include <limits>

#include "core/codec/common/text_parsing.hpp"
#include "segserve/codec/pcd.hpp"

namespace segserve::codec {
namespace {

constexpr std::size_t kValueBytes = 4;  // the size of every field that we write
constexpr std::uint32_t kAllBits = 0xFFFFFFFFU;
constexpr std::uint32_t kColorBits = 0xFFFFFFU;

std::size_t point_bytes(const CloudView& cloud, std::span<const std::uint32_t> label) {
  return kValueBytes * (3U + (cloud.has_color() ? 1U : 0U) + (label.empty() ? 0U : 1U));
}

std::string_view name_of(PcdEncoding encoding) {
  switch (encoding) {
    case PcdEncoding::kAscii:
      return "ascii";
    case PcdEncoding::kBinary:
      return "binary";
    case PcdEncoding::kBinaryCompressed:
      break;
  }
  return "binary_compressed";
}

std::string encode_header(const CloudView& cloud, bool has_label, PcdEncoding encoding) {
  const bool color = cloud.has_color();
  const bool ascii = encoding == PcdEncoding::kAscii;
  const auto per_field = [&](std::string_view first_three, std::string_view rgb, std::string_view label) {
    return fmt::format("{}{}{}", first_three, color ? rgb : "", has_label ? label : "");
  };
  const Eigen::Vector3f sensor = cloud.view.sensor.value_or(Eigen::Vector3f::Zero());
  // As text of type F, some colors would be NaN. PCL writes an integer as well.
  std::string header = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
      "FIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\n",
      per_field("x y z", " rgb", " label"), per_field("4 4 4", " 4", " 4"),
      per_field("F F F", ascii ? " U" : " F", " U"), per_field("1 1 1", " 1", " 1"));
  fmt::format_to(std::back_inserter(header), "WIDTH {}\nHEIGHT {}\nVIEWPOINT {} {} {} 1 0 0 0\nPOINTS {}\nDATA {}\n",
                 cloud.width, cloud.height, sensor[0], sensor[1], sensor[2], cloud.size(), name_of(encoding));
  return header;
}

void append_ascii(const CloudView& cloud, std::span<const std::uint32_t> label, std::string& out) {
  const auto to = std::back_inserter(out);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    append_number(out, cloud.x[i]);
    append_number(out += ' ', cloud.y[i]);
    append_number(out += ' ', cloud.z[i]);
    if (cloud.has_color()) fmt::format_to(to, " {}", cloud.rgb[i] & kColorBits);
    if (!label.empty()) fmt::format_to(to, " {}", label[i]);
    out += '\n';
  }
}

/// Copies each value of a plane, its bits masked, to `out` and every `stride` bytes from there.
template <typename T>
void scatter(std::span<const T> plane, char* out, std::size_t stride, std::uint32_t mask) {
  static_assert(sizeof(T) == kValueBytes);
  for (const T& value : plane) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value) & mask;
    std::memcpy(out, &bits, kValueBytes);
    out += stride;
  }
}

/// The values of a binary body. Field f of point i begins at byte f * field_step + i * point_step.
std::string binary_body(const CloudView& cloud, std::span<const std::uint32_t> label, std::size_t field_step,
                        std::size_t point_step) {
  std::string body(cloud.size() * point_bytes(cloud, label), '\0');
  char* field = body.data();
  const auto put = [&](auto plane, std::uint32_t mask) {
    scatter(plane, field, point_step, mask);
    field += field_step;
  };
  put(cloud.x, kAllBits);
  put(cloud.y, kAllBits);
  put(cloud.z, kAllBits);
  if (cloud.has_color()) put(cloud.rgb, kColorBits);  // Without the top byte no color is a NaN.
  if (!label.empty()) put(label, kAllBits);
  return body;
}

/// The most bytes that LZF writes: a control byte before each 32 bytes, and the space that it wants to have ahead.
std::size_t compressed_bound(std::size_t bytes) { return bytes + bytes / 32 + 16; }

/// The body of binary_compressed: the compressed and the decompressed size, and one LZF block.
std::string compress(const std::string& planes) {
  constexpr std::size_t kSizes = 2 * sizeof(std::uint32_t);
  std::string out(kSizes + compressed_bound(planes.size()), '\0');
  const auto size = static_cast<std::uint32_t>(planes.size());
  std::uint32_t compressed = 0;
  if (size > 0) {  // LZF takes no empty block.
    compressed = lzf_compress(planes.data(), size, out.data() + kSizes, static_cast<unsigned>(out.size() - kSizes));
  }
  std::memcpy(out.data(), &compressed, sizeof compressed);
  std::memcpy(out.data() + 4, &size, sizeof size);
  out.resize(kSizes + compressed);
  return out;
}

}  // namespace

std::string encode_pcd(const CloudView& cloud, std::span<const std::uint32_t> label, PcdEncoding encoding) {
  const std::size_t body_bytes = cloud.size() * point_bytes(cloud, label);
  if (encoding == PcdEncoding::kBinaryCompressed &&
      compressed_bound(body_bytes) > std::numeric_limits<std::uint32_t>::max()) {
    encoding = PcdEncoding::kBinary;
  }
  std::string out = encode_header(cloud, !label.empty(), encoding);
  switch (encoding) {
    case PcdEncoding::kAscii:
      append_ascii(cloud, label, out);
      return out;
    case PcdEncoding::kBinary:
      return out += binary_body(cloud, label, kValueBytes, point_bytes(cloud, label));
    case PcdEncoding::kBinaryCompressed:
      break;
  }
  return out += compress(binary_body(cloud, label, kValueBytes * cloud.size(), kValueBytes));
}

}  // namespace segserve::codec
