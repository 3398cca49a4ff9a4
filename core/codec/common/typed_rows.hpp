// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "core/base/stop_check.hpp"
#include "core/codec/common/column.hpp"

namespace segserve::codec {

/// The words of a text body as numbers. Text is unmistakable, so that a word is read as it is written, whatever type
/// the header claims: coordinates as doubles, and integers in 64 bits, or as doubles as soon as one of the field has
/// decimals or is nan. Only floats that are no coordinates have the type of the header.
class TypedRows {
 public:
  /// Appends a field of `count` words in each row.
  void add_field(ScalarType declared, std::size_t count, bool is_coordinate);
  /// Appends a field whose words are not kept, so that the others have the indices that they have in the header.
  void add_skipped_field() { fields_.emplace_back(); }
  /// Makes room for this many rows, after the last field.
  void allocate(std::size_t rows);

  bool is_kept(std::size_t field) const { return fields_[field].count > 0; }
  /// Reads a word, after those before it in its row and in the rows before. Returns false, and has 0, if the word is no
  /// number.
  bool put(std::size_t row, std::size_t field, std::size_t index, std::string_view word);

  Column column(std::size_t field) const { return {data_.get() + fields_[field].offset, bytes_, fields_[field].type}; }
  /// The type of the header if it holds all values of the field, or else the type in which they are kept.
  ScalarType fitting_type(std::size_t field, StopCheck& check) const;

 private:
  struct TextField {
    std::size_t offset = 0;  ///< in a row
    std::size_t count = 0;   ///< 0 if it is skipped
    ScalarType declared = ScalarType::kFloat32;
    ScalarType type = ScalarType::kFloat32;  ///< in which its values are kept
  };

  std::byte* place(std::size_t row, const TextField& field, std::size_t index) const {
    return data_.get() + row * bytes_ + field.offset + index * size_of(field.type);
  }
  void widen(std::size_t row, TextField& field, std::size_t index);

  std::vector<TextField> fields_;
  std::size_t rows_ = 0, bytes_ = 0;  // how many, and of how many bytes
  std::unique_ptr<std::byte[]> data_;
};

}  // namespace segserve::codec
