// SPDX-License-Identifier: Apache-2.0
#include "core/codec/common/file_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <utility>

#include "core/codec/common/field_roles.hpp"

namespace segserve::codec {
namespace {

constexpr std::uint32_t kColorBits = 0xFFFFFFU;

bool is_word_character(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '.' || c == '-';
}

std::string as_word(std::string_view name) {
  std::string word(name);
  for (char& c : word) c = is_word_character(c) ? c : '_';
  return word.empty() ? "unnamed" : word;
}

/// Copies kBytes (or `bytes`, if kBytes is 0) of each point from a column to `out`, every `stride` bytes.
template <std::size_t kBytes>
void scatter(const FileColumn& column, std::size_t points, char* out, std::size_t stride) {
  const std::byte* from = column.data;
  for (std::size_t i = 0; i < points; ++i, from += column.stride, out += stride) {
    std::memcpy(out, from, kBytes == 0 ? column.bytes() : kBytes);
  }
}

void copy_column(const FileColumn& column, std::size_t points, char* out, std::size_t stride) {
  switch (column.bytes()) {
    case 1:
      return scatter<1>(column, points, out, stride);
    case 4:
      return scatter<4>(column, points, out, stride);
    case 8:
      return scatter<8>(column, points, out, stride);
    default:
      return scatter<0>(column, points, out, stride);
  }
}

template <typename T>
void append_value(std::string& out, T value) {
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(value)) {
      out += "nan";
      return;
    }
  }
  if constexpr (sizeof(T) == 1) {
    fmt::format_to(std::back_inserter(out), "{}", static_cast<int>(value));
  } else {
    fmt::format_to(std::back_inserter(out), "{}", value);
  }
}

}  // namespace

FileTable::FileTable(const FileContent& content, ColorForm form) : points_(content.cloud.size()) {
  add_position(content);
  if (content.cloud.has_color()) add_color(content, form);
  for (const Attribute& attribute : content.attributes) add_attribute(attribute);
  if (!content.label.empty()) add("label", ScalarType::kUint32, content.label.data(), sizeof(std::uint32_t));
}

void FileTable::add(std::string name, ScalarType type, const void* data, std::size_t stride) {
  columns_.push_back({std::move(name), type, 1, static_cast<const std::byte*>(data), stride});
}

void FileTable::add_position(const FileContent& content) {
  const CloudView& cloud = content.cloud;
  const std::array<const float*, 3> planes{cloud.x.data(), cloud.y.data(), cloud.z.data()};
  constexpr std::array<const char*, 3> kNames{"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (content.position != nullptr) {
      add(kNames[axis], ScalarType::kFloat64, (*content.position)[axis].data(), sizeof(double));
    } else {
      add(kNames[axis], ScalarType::kFloat32, planes[axis], sizeof(float));
    }
  }
}

void FileTable::add_color(const FileContent& content, ColorForm form) {
  rgb_.assign(content.cloud.rgb.begin(), content.cloud.rgb.end());
  for (std::uint32_t& rgb : rgb_) rgb &= kColorBits;  // Without the top byte no color is a NaN.
  if (form == ColorForm::kPacked) return add("rgb", ScalarType::kUint32, rgb_.data(), sizeof(std::uint32_t));
  const auto* const bytes = reinterpret_cast<const std::byte*>(rgb_.data());
  constexpr std::array<std::pair<const char*, std::size_t>, 3> kChannels{{{"red", 2}, {"green", 1}, {"blue", 0}}};
  for (const auto& [name, byte] : kChannels) add(name, ScalarType::kUint8, bytes + byte, sizeof(std::uint32_t));
}

void FileTable::add_attribute(const Attribute& attribute) {
  std::string name = as_word(attribute.name);
  // Other colors come before the harmonics of a splat, which may keep their name beside them.
  const bool is_shadowed = !rgb_.empty() && name.starts_with("f_dc_");
  if (has_meaning(name) && !is_shadowed) name = "input_" + name;
  const std::string base = name;
  const auto is_taken = [&] { return std::ranges::find(columns_, name, &FileColumn::name) != columns_.end(); };
  for (int number = 2; is_taken(); ++number) name = fmt::format("{}_{}", base, number);
  columns_.push_back(
      {std::move(name), attribute.type, attribute.count, attribute.values.data(), attribute.bytes_per_point()});
}

std::size_t FileTable::point_bytes() const {
  std::size_t sum = 0;
  for (const FileColumn& column : columns_) sum += column.bytes();
  return sum;
}

void FileTable::append_rows(std::string& out) const {
  const std::size_t begin = out.size(), stride = point_bytes();
  out.resize(begin + points_ * stride);
  char* field = out.data() + begin;
  for (const FileColumn& column : columns_) {
    copy_column(column, points_, field, stride);
    field += column.bytes();
  }
}

void FileTable::append_columns(std::string& out) const {
  const std::size_t begin = out.size();
  out.resize(begin + points_ * point_bytes());
  char* field = out.data() + begin;
  for (const FileColumn& column : columns_) {
    copy_column(column, points_, field, column.bytes());
    field += points_ * column.bytes();
  }
}

void FileTable::append_text(std::string& out, char separator) const {
  for (std::size_t i = 0; i < points_; ++i) {
    bool is_first = true;
    for (const FileColumn& column : columns_) {
      for (std::size_t k = 0; k < column.count; ++k) {
        if (!std::exchange(is_first, false)) out += separator;
        const std::byte* const value = column.data + i * column.stride + k * size_of(column.type);
        visit_type(column.type, [&]<typename T>(T) { append_value(out, load<T>(value)); });
      }
    }
    out += '\n';
  }
}

}  // namespace segserve::codec
