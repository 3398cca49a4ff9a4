// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/codec/common/column.hpp"
#include "core/codec/common/scalar_type.hpp"
#include "core/codec/common/surplus_lines.hpp"
#include "core/codec/common/text_parsing.hpp"
#include "core/codec/common/typed_rows.hpp"
#include "core/codec/ply/ply_header.hpp"
#include "segserve/codec/warning.hpp"

// The values in the body of a PLY file, one after the other.
namespace segserve::codec {

/// The length of a list that begins with `bytes`, or nullopt if it is negative.
inline std::optional<std::uint64_t> list_length(const std::byte* bytes, ScalarType type, std::endian order) {
  return visit_type(type, [&]<typename T>(T) -> std::optional<std::uint64_t> {
    const T length = load<T>(bytes, order);
    if (length < T{0}) return std::nullopt;
    return static_cast<std::uint64_t>(length);
  });
}

/// The vertices of a binary body, of which some properties are kept in its types and byte order.
class BinaryRows {
 public:
  void add_field(ScalarType type) {
    fields_.push_back({bytes_, type, true});
    bytes_ += size_of(type);
  }
  void add_skipped_field() { fields_.emplace_back(); }
  void allocate(std::size_t rows) { data_ = std::make_unique_for_overwrite<std::byte[]>(rows * bytes_); }
  bool is_kept(std::size_t field) const { return fields_[field].is_kept; }
  void put(std::size_t row, std::size_t field, const std::byte* value) {
    std::memcpy(data_.get() + row * bytes_ + fields_[field].offset, value, size_of(fields_[field].type));
  }
  Column column(std::size_t field) const { return {data_.get() + fields_[field].offset, bytes_, fields_[field].type}; }

 private:
  struct BinaryField {
    std::size_t offset = 0;  ///< in a row
    ScalarType type = ScalarType::kFloat32;
    bool is_kept = false;
  };
  std::vector<BinaryField> fields_;
  std::size_t bytes_ = 0;
  std::unique_ptr<std::byte[]> data_;
};

// BinaryValues and TextValues have the same members, so that read_element can walk over either kind of body. A member
// that returns false has found a fault, which place() then describes.

/// Walks over the values of a binary body.
class BinaryValues {
 public:
  using Rows = BinaryRows;
  BinaryValues(std::span<const std::byte> body, std::endian order) : rest_(body), order_(order) {}

  std::endian order() const { return order_; }
  static bool was_unreadable() { return false; }
  /// Whether the rest of the body is long enough for an element that has properties.
  bool can_hold(const PlyElement& element) const { return element.rows <= rest_.size() / element.least_row_bytes(); }
  bool begin_row() { return true; }
  bool end_row() { return true; }
  /// Copies the value of a property to a row, or skips it if `rows` is null.
  bool scalar(const PlyProperty& property, std::size_t field, std::size_t row, BinaryRows* rows) {
    const std::size_t bytes = size_of(property.type);
    if (rest_.size() < bytes) return false;
    if (rows != nullptr) rows->put(row, field, rest_.data());
    rest_ = rest_.subspan(bytes);
    return true;
  }
  bool skip_list(const PlyProperty& property) {
    const std::size_t bytes = size_of(*property.length_type);
    if (rest_.size() < bytes) return false;
    const auto length = list_length(rest_.data(), *property.length_type, order_);
    rest_ = rest_.subspan(bytes);
    if (!length || *length > rest_.size() / size_of(property.type)) return false;
    rest_ = rest_.subspan(static_cast<std::size_t>(*length) * size_of(property.type));
    return true;
  }
  /// Warns of bytes that follow the last element, if they are as many as a row of it has.
  void warn_of_surplus(const PlyElement& last, std::vector<Warning>& warnings) const {
    warn_of_surplus_bytes(rest_, last.least_row_bytes(), warnings);
  }
  /// Describes the last fault.
  static std::string place() { return "the body is too short, or the length of a list is wrong"; }

 private:
  std::span<const std::byte> rest_;
  std::endian order_;
};

/// Walks over the values of a text body, which has a line for each row.
class TextValues {
 public:
  using Rows = TypedRows;
  TextValues(std::string_view body, std::size_t first_line)
      : lines_(without_byte_order_mark(body), first_line), bytes_(body.size()) {}

  static std::endian order() { return std::endian::native; }
  /// Whether the body is long enough for an element that has properties.
  bool can_hold(const PlyElement& element) const {
    return element.rows <= most_values(bytes_) / element.properties.size();
  }
  bool begin_row() {
    std::optional<LineReader::Line> line = lines_.next();
    while (line && (is_blank(line->text) || is_comment(line->text))) line = lines_.next();
    if (!line) return explain("it ends too early");
    line_ = *line;
    return true;
  }
  bool end_row() {
    const std::string_view word = take_word(line_.text);
    return word.empty() || explain(fmt::format("{} is one value too many", quoted(word)));
  }
  bool scalar(const PlyProperty& property, std::size_t field, std::size_t row, TypedRows* rows) {
    const std::string_view word = take_word(line_.text);
    if (word.empty()) return explain(fmt::format("the value of '{}' is missing", property.name));
    if (rows == nullptr || rows->put(row, field, 0, word)) return true;
    is_unreadable_ = true;
    return explain(fmt::format("{} is not a value of '{}'", quoted(word), property.name));
  }
  /// Whether the last fault is a word that is not a value, so that the reader can go on behind it.
  bool was_unreadable() { return std::exchange(is_unreadable_, false); }
  bool skip_list(const PlyProperty& property) {
    const std::string_view word = take_word(line_.text);
    const auto length = parse_count(word);
    if (!length) return explain(fmt::format("{} is not the length of the list '{}'", quoted(word), property.name));
    for (std::uint64_t i = 0; i < *length; ++i) {
      if (take_word(line_.text).empty()) return explain(fmt::format("the list '{}' is too short", property.name));
    }
    return true;
  }
  /// Warns of rows that follow the last element.
  void warn_of_surplus(const PlyElement& /*last*/, std::vector<Warning>& warnings) {
    std::uint64_t rows = 0;
    while (begin_row()) ++rows;
    warn_of_surplus_lines(rows, warnings);
  }
  /// Describes the last fault.
  std::string place() const {
    return line_.number == 0 ? explanation_ : fmt::format("line {}: {}", line_.number, explanation_);
  }

 private:
  static bool is_comment(std::string_view line) { return line.starts_with('#') || line.starts_with("comment "); }

  bool explain(std::string explanation) {
    explanation_ = std::move(explanation);
    return false;
  }

  LineReader lines_;
  std::size_t bytes_;
  LineReader::Line line_{};
  std::string explanation_;
  bool is_unreadable_ = false;
};

}  // namespace segserve::codec
