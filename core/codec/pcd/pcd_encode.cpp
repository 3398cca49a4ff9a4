// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <lzf.h>

#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

#include "core/codec/common/text_parsing.hpp"
#include "segserve/codec/pcd.hpp"

namespace segserve::codec {
namespace {

constexpr std::size_t kValueBytes = 4;  // every field we write

std::size_t point_bytes(const CloudView& cloud, std::span<const std::uint32_t> label) {
  return kValueBytes * (3U + (cloud.has_color() ? 1U : 0U) + (label.empty() ? 0U : 1U));
}

std::string encode_header(const CloudView& cloud, bool has_label, PcdEncoding encoding) {
  const bool color = cloud.has_color();
  const bool ascii = encoding == PcdEncoding::kAscii;
  const auto per_field = [&](std::string_view first_three, std::string_view rgb, std::string_view label) {
    return fmt::format("{}{}{}", first_three, color ? rgb : "", has_label ? label : "");
  };
  const Eigen::Vector3f sensor = cloud.view.sensor.value_or(Eigen::Vector3f::Zero());
  // Text of type F would make a NaN of some colors; PCL, too, writes an integer then.
  std::string header = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
      "FIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\n",
      per_field("x y z", " rgb", " label"), per_field("4 4 4", " 4", " 4"),
      per_field("F F F", ascii ? " U" : " F", " U"), per_field("1 1 1", " 1", " 1"));
  fmt::format_to(std::back_inserter(header), "WIDTH {}\nHEIGHT {}\nVIEWPOINT {} {} {} 1 0 0 0\nPOINTS {}\nDATA {}\n",
                 cloud.width, cloud.height, sensor[0], sensor[1], sensor[2], cloud.size(),
                 ascii                              ? "ascii"
                 : encoding == PcdEncoding::kBinary ? "binary"
                                                    : "binary_compressed");
  return header;
}

void append_ascii(const CloudView& cloud, std::span<const std::uint32_t> label, std::string& out) {
  const auto to = std::back_inserter(out);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    append_number(out, cloud.x[i]);
    append_number(out += ' ', cloud.y[i]);
    append_number(out += ' ', cloud.z[i]);
    if (cloud.has_color()) fmt::format_to(to, " {}", cloud.rgb[i] & 0xFFFFFFU);
    if (!label.empty()) fmt::format_to(to, " {}", label[i]);
    out += '\n';
  }
}

/// Copies a plane to every `stride`-th byte from `out`. Colors lose their top byte, so that none is a NaN.
template <typename T>
void scatter(std::span<const T> plane, char* out, std::size_t stride, std::uint32_t mask = 0xFFFFFFFFU) {
  static_assert(sizeof(T) == kValueBytes);
  for (const T& value : plane) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value) & mask;
    std::memcpy(out, &bits, kValueBytes);
    out += stride;
  }
}

/// The body's values: field f of point i at f * field_step + i * point_step.
std::string lay_out(const CloudView& cloud, std::span<const std::uint32_t> label, std::size_t field_step,
                    std::size_t point_step) {
  std::string body(cloud.size() * point_bytes(cloud, label), '\0');
  char* field = body.data();
  const auto put = [&](auto plane, std::uint32_t mask) {
    scatter(plane, field, point_step, mask);
    field += field_step;
  };
  put(cloud.x, 0xFFFFFFFFU);
  put(cloud.y, 0xFFFFFFFFU);
  put(cloud.z, 0xFFFFFFFFU);
  if (cloud.has_color()) put(cloud.rgb, 0xFFFFFFU);
  if (!label.empty()) put(label, 0xFFFFFFFFU);
  return body;
}

/// LZF's worst case, a byte of control before each 32, and the room it wants to have ahead.
std::size_t compressed_bound(std::size_t bytes) { return bytes + bytes / 32 + 16; }

std::string compress(const std::string& planes) {
  std::string out(2 * sizeof(std::uint32_t) + compressed_bound(planes.size()), '\0');
  const auto size = static_cast<std::uint32_t>(planes.size());
  // Of nothing there is nothing to compress.
  const std::uint32_t compressed =
      size == 0 ? 0 : lzf_compress(planes.data(), size, out.data() + 8, static_cast<unsigned>(out.size() - 8));
  std::memcpy(out.data(), &compressed, sizeof compressed);
  std::memcpy(out.data() + 4, &size, sizeof size);
  out.resize(8 + compressed);
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
      return out += lay_out(cloud, label, kValueBytes, point_bytes(cloud, label));
    case PcdEncoding::kBinaryCompressed:
      break;
  }
  return out += compress(lay_out(cloud, label, kValueBytes * cloud.size(), kValueBytes));
}

}  // namespace segserve::codec
