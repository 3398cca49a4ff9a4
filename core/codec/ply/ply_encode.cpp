// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <iterator>

#include "core/codec/common/text_parsing.hpp"
#include "segserve/codec/ply.hpp"

namespace segserve::codec {
namespace {

std::string encode_header(const CloudView& cloud, bool has_label, PlyEncoding encoding) {
  return fmt::format(
      "ply\nformat {} 1.0\ncomment written by segserve\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n{}{}end_header\n",
      encoding == PlyEncoding::kAscii ? "ascii" : "binary_little_endian", cloud.size(),
      cloud.has_color() ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "",
      has_label ? "property uint label\n" : "");
}

void append_ascii(const CloudView& cloud, std::span<const std::uint32_t> label, std::string& out) {
  const auto to = std::back_inserter(out);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    append_number(out, cloud.x[i]);
    append_number(out += ' ', cloud.y[i]);
    append_number(out += ' ', cloud.z[i]);
    if (cloud.has_color()) {
      fmt::format_to(to, " {} {} {}", red(cloud.rgb[i]), green(cloud.rgb[i]), blue(cloud.rgb[i]));
    }
    if (!label.empty()) fmt::format_to(to, " {}", label[i]);
    out += '\n';
  }
}

void append_binary(const CloudView& cloud, std::span<const std::uint32_t> label, std::string& out) {
  const auto put = [&](auto value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
  const std::size_t point_bytes = 12U + (cloud.has_color() ? 3U : 0U) + (label.empty() ? 0U : 4U);
  out.reserve(out.size() + cloud.size() * point_bytes);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    put(cloud.x[i]);
    put(cloud.y[i]);
    put(cloud.z[i]);
    if (cloud.has_color()) {
      put(red(cloud.rgb[i]));
      put(green(cloud.rgb[i]));
      put(blue(cloud.rgb[i]));
    }
    if (!label.empty()) put(label[i]);
  }
}

}  // namespace

std::string encode_ply(const CloudView& cloud, std::span<const std::uint32_t> label, PlyEncoding encoding) {
  std::string out = encode_header(cloud, !label.empty(), encoding);
  if (encoding == PlyEncoding::kAscii) {
    append_ascii(cloud, label, out);
  } else {
    append_binary(cloud, label, out);
  }
  return out;
}

}  // namespace segserve::codec
