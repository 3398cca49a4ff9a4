// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/codec/gltf/gltf.hpp"

namespace segserve::codec {
namespace {

using Point = std::array<float, 3>;
constexpr std::size_t kPositionBytes = sizeof(Point), kColorBytes = 4;

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63U];
    }
  }
  return out;
}

void append_number(std::string& out, std::uint32_t value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// The segments of a cloud as glTF has them: all positions, then all colors, sorted by label.
class GltfWriter {
 public:
  explicit GltfWriter(const FileContent& content) : content_(content) {}

  absl::StatusOr<EncodedFile> run(GltfForm form) {
    sort_points();
    warn();
    const std::size_t per_point = kPositionBytes + (content_.cloud.has_color() ? kColorBytes : 0);
    if (points_.size() > std::numeric_limits<std::uint32_t>::max() / 2 / per_point) {
      return absl::InvalidArgumentError("glTF cannot hold so many points");
    }
    write_numbers();
    describe();
    out_.bytes =
        form == GltfForm::kBinary ? binary() : json("data:application/octet-stream;base64," + base64(numbers_));
    return std::move(out_);
  }

 private:
  std::uint32_t label_of(std::uint32_t point) const { return content_.label.empty() ? 0 : content_.label[point]; }

  /// The position with y up.
  Point turned(std::uint32_t point) const {
    const CloudView& cloud = content_.cloud;
    const float x = cloud.x[point], y = cloud.y[point], z = cloud.z[point];
    return cloud.view.kind == ViewKind::kCamera ? Point{x, -y, -z} : Point{x, z, -y};
  }

  void sort_points() {
    const CloudView& cloud = content_.cloud;
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      if (is_finite(cloud.x[i], cloud.y[i], cloud.z[i])) points_.push_back(i);
    }
    std::ranges::stable_sort(points_, {}, [this](std::uint32_t point) { return label_of(point); });
  }

  void warn() {
    const auto add = [this](WarningReason reason, std::string message) {
      out_.warnings.push_back({reason, std::move(message)});
    };
    const std::size_t left_out = content_.cloud.size() - points_.size();
    if (left_out > 0) {
      add(WarningReason::kPointsNotUsed, fmt::format("{} points that are not finite are left out", left_out));
    }
    if (!content_.attributes.empty()) {
      add(WarningReason::kAttributeNotKept,
          fmt::format("glTF has no place for the other values of the {} points", content_.cloud.size()));
    }
    if (content_.position != nullptr && !points_.empty()) {
      const auto& [x, y, z] = *content_.position;
      const std::uint32_t first = points_.front();
      add(WarningReason::kOther,
          fmt::format("the coordinates are in meters, near the origin: the point at ({}, {}, {}) is at ({}, {}, {}) "
                      "before y is turned up",
                      x[first], y[first], z[first], content_.cloud.x[first], content_.cloud.y[first],
                      content_.cloud.z[first]));
    }
  }

  void write_numbers() {
    for (const std::uint32_t point : points_) {
      const Point position = turned(point);
      numbers_.append(reinterpret_cast<const char*>(position.data()), kPositionBytes);
    }
    if (!content_.cloud.has_color()) return;
    for (const std::uint32_t point : points_) {
      const std::uint32_t rgb = content_.cloud.rgb[point];
      numbers_ += {static_cast<char>(red(rgb)), static_cast<char>(green(rgb)), static_cast<char>(blue(rgb)), '\xff'};
    }
  }

  void describe() {
    for (std::size_t begin = 0; begin < points_.size();) {
      const std::uint32_t label = label_of(points_[begin]);
      std::size_t end = begin;
      while (end < points_.size() && label_of(points_[end]) == label) ++end;
      describe_segment(label, begin, end);
      begin = end;
    }
  }

  void describe_segment(std::uint32_t label, std::size_t begin, std::size_t end) {
    const bool has_color = content_.cloud.has_color();
    Point low, high;
    low.fill(std::numeric_limits<float>::infinity());
    high.fill(-std::numeric_limits<float>::infinity());
    for (std::size_t i = begin; i < end; ++i) {
      const Point position = turned(points_[i]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], position[axis]);
        high[axis] = std::max(high[axis], position[axis]);
      }
    }
    const std::string separator = nodes_.empty() ? "" : ",";
    const std::string name = label == 0 ? "unlabeled" : fmt::format("segment {}", label);
    nodes_ += fmt::format("{}{{\"name\":\"{}\",\"mesh\":{}}}", separator, name, segments_);
    indices_ += fmt::format("{}{}", separator, segments_);
    meshes_ += fmt::format("{}{{\"name\":\"{}\",\"primitives\":[{{\"mode\":0,\"attributes\":{{\"POSITION\":{}{}}}}}]}}",
                           separator, name, accessors_count_,
                           has_color ? fmt::format(",\"COLOR_0\":{}", accessors_count_ + 1) : "");
    accessors_ += fmt::format(
        "{}{{\"bufferView\":0,\"byteOffset\":{},\"componentType\":5126,\"count\":{},\"type\":\"VEC3\",\"min\":[{}],"
        "\"max\":[{}]}}",
        separator, begin * kPositionBytes, end - begin, fmt::join(low, ","), fmt::join(high, ","));
    ++accessors_count_;
    if (has_color) {
      accessors_ += fmt::format(
          ",{{\"bufferView\":1,\"byteOffset\":{},\"componentType\":5121,\"normalized\":true,\"count\":{},\"type\":"
          "\"VEC4\"}}",
          begin * kColorBytes, end - begin);
      ++accessors_count_;
    }
    ++segments_;
  }

  /// The JSON, with the address of the numbers unless they follow in the same file.
  std::string json(const std::string& uri) const {
    const std::string head = "{\"asset\":{\"version\":\"2.0\",\"generator\":\"segserve\"},\"scene\":0,\"scenes\":[";
    if (points_.empty()) return head + "{}]}";
    const std::size_t positions = points_.size() * kPositionBytes;
    std::string views = fmt::format("{{\"buffer\":0,\"byteLength\":{},\"target\":34962}}", positions);
    if (content_.cloud.has_color()) {
      views += fmt::format(",{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{},\"target\":34962}}", positions,
                           numbers_.size() - positions);
    }
    const std::string address = uri.empty() ? "" : fmt::format(",\"uri\":\"{}\"", uri);
    return fmt::format(
        "{}{{\"nodes\":[{}]}}],\"nodes\":[{}],\"meshes\":[{}],\"accessors\":[{}],\"bufferViews\":[{}],\"buffers\":[{{"
        "\"byteLength\":{}{}}}]}}",
        head, indices_, nodes_, meshes_, accessors_, views, numbers_.size(), address);
  }

  std::string binary() const {
    constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJson = 0x4E4F534A, kBin = 0x004E4942;
    constexpr std::size_t kHeader = 12, kChunkHeader = 8, kAlignment = 4;
    std::string text = json("");
    text.resize((text.size() + kAlignment - 1) / kAlignment * kAlignment, ' ');
    const bool has_numbers = !numbers_.empty();  // Their length is a multiple of four.
    const std::size_t bytes = kHeader + kChunkHeader + text.size() + (has_numbers ? kChunkHeader + numbers_.size() : 0);
    std::string out;
    for (const std::uint32_t value : {kMagic, kVersion, static_cast<std::uint32_t>(bytes)}) append_number(out, value);
    append_number(out, static_cast<std::uint32_t>(text.size()));
    append_number(out, kJson);
    out += text;
    if (has_numbers) {
      append_number(out, static_cast<std::uint32_t>(numbers_.size()));
      append_number(out, kBin);
      out += numbers_;
    }
    return out;
  }

  const FileContent& content_;
  std::vector<std::uint32_t> points_;  // the finite ones, sorted by label
  std::string numbers_;
  std::string nodes_, indices_, meshes_, accessors_;
  std::size_t segments_ = 0, accessors_count_ = 0;
  EncodedFile out_;
};

}  // namespace

absl::StatusOr<EncodedFile> encode_gltf(const FileContent& content, GltfForm form) {
  return GltfWriter(content).run(form);
}

}  // namespace segserve::codec
