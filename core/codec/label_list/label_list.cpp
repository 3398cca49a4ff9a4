// SPDX-License-Identifier: Apache-2.0
#include "core/codec/label_list/label_list.hpp"

#include <fmt/format.h>

#include <cstring>
#include <iterator>

namespace segserve::codec {
namespace {

/// The text within the quotation marks of JSON.
std::string json_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < ' ') {
      fmt::format_to(std::back_inserter(out), "\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::string encode_segs_json(std::span<const std::uint32_t> label, std::string_view scene) {
  return fmt::format("{{\"params\": {{}}, \"sceneId\": \"{}\", \"segIndices\": [{}]}}\n", json_text(scene),
                     fmt::join(label, ", "));
}

absl::StatusOr<std::string> encode_kitti_label(std::span<const std::uint32_t> label) {
  constexpr std::uint32_t kMostInstances = 0xFFFF;
  constexpr unsigned kInstanceShift = 16;
  std::string out(label.size() * sizeof(std::uint32_t), '\0');
  for (std::size_t i = 0; i < label.size(); ++i) {
    if (label[i] > kMostInstances) {
      return absl::InvalidArgumentError(fmt::format(
          "SemanticKITTI has 16 bits for an instance, and point {} (counted from 0) has label {}", i, label[i]));
    }
    const std::uint32_t value = label[i] << kInstanceShift;
    std::memcpy(out.data() + i * sizeof value, &value, sizeof value);
  }
  return out;
}

}  // namespace segserve::codec
